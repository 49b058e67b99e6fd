#include "core/error.hpp"
#include "core/fields/displacement_fields.hpp"
#include "core/fields/invariance.hpp"
#include "evaluated.hpp"
#include "optimize/space/field_conditions.hpp"
#include "problems.hpp"
#include "tests/kinds_of_shape.hpp"

#include <gtest/gtest.h>

namespace strake::kept_shape {
namespace {

using Eigen::Vector3d;
using Type = ShapeKind::Type;

struct Kind {
    TriMesh mesh;
    ShapeKind kind;
};

std::vector<Kind> kinds() {
    return {{extruded_section(24, 4), {Type::extruded, Vector3d::UnitY(), {0, 0, 0}, 1}},
            {body_of_revolution(16, 10), {Type::revolved, Vector3d::UnitX(), {0, 0, 0}, 1}},
            {cyclic_body(6, 3), {Type::cyclic, Vector3d::UnitX(), {0, 0, 0}, 6}}};
}

/// Held at one end, with fields and two levels of patches.
Problem problem_of(const Kind& one, std::vector<VariableKind> variables, int fields = 9) {
    Problem problem;
    problem.name = "kind";
    problem.surface = one.mesh;
    problem.tree = octants(problem.surface, 2);
    problem.prism_height =
        Eigen::VectorXd::Constant(problem.surface.num_vertices(), 0.05 * box_diagonal(problem.surface));
    problem.fixed = held_end(one.mesh, one.kind);
    problem.quantities = {volume(problem.surface), area()};
    problem.parameters.kinds = std::move(variables);
    problem.parameters.invariance = std::make_shared<const Invariance>(one.mesh, one.kind);
    if (fields > 0)
        add_fields(problem.parameters, std::make_shared<const DisplacementFields>(
                                           problem.surface, field_conditions(problem), FieldOptions{fields, {}}));
    return problem;
}

}  // namespace

TEST(KeptShape, AnyDesignHasItToRoundOffAndHeldVerticesByEveryBit) {
    for (const Kind& one : kinds())
        for (const auto& variables : std::vector<std::vector<VariableKind>>{
                 {VariableKind::load}, {VariableKind::normal_load, VariableKind::stiffness}}) {
            Evaluated e(problem_of(one, variables), 2);
            ASSERT_GT(e.space.size(), 12) << to_string(one.kind);
            const Eigen::VectorXd x = 0.4 * random_vector(e.space.size(), 3);
            const Points v = e.at(x).vertices;
            const double diagonal = e.rest->diagonal;
            EXPECT_LT(off_kind(with_vertices(one.mesh, v), one.kind), 1e-12 * diagonal) << to_string(one.kind);
            EXPECT_GT((v - one.mesh.vertices).cwiseAbs().maxCoeff(), 0.01 * diagonal) << "the test can fail";
            for (const int t : e.problem.fixed)
                for (int k = 0; k < 3; ++k)
                    EXPECT_EQ(v.row(one.mesh.triangles(t, k)), one.mesh.vertices.row(one.mesh.triangles(t, k)));
        }
}

TEST(KeptShape, GradientsAreExactForEveryVariable) {
    for (const Kind& one : kinds()) {
        Evaluated e(problem_of(one, {VariableKind::load, VariableKind::stiffness}), 1);
        for (const double size : {0.0, 0.4}) {
            const Eigen::VectorXd x = size * random_vector(e.space.size(), 3);
            ShapeEvaluation here = e.at(x);
            e.evaluator.differentiate(here);
            for (int i = 0; i < 2; ++i) {
                const Eigen::VectorXd g = here.gradients.row(i);
                const auto J = [&](const Eigen::VectorXd& y) { return e.at(y).values[i]; };
                const Eigen::VectorXd p = random_vector(e.space.size(), 5);
                EXPECT_NEAR(taylor_order(J, x, g, p, 3e-3), 2, 0.2) << to_string(one.kind) << size << i;
                EXPECT_NEAR(taylor_order(J, x, 1.1 * g, p, 3e-3), 1, 0.2) << "the test can fail";
            }
            // Each variable alone, by central differences of an order that round-off leaves 1e-6 of.
            for (int j = 0; j < e.space.size(); ++j) {
                const Eigen::VectorXd h = 1e-4 * Eigen::VectorXd::Unit(e.space.size(), j);
                const double slope = (e.at(x + h).values[0] - e.at(x - h).values[0]) / 2e-4;
                EXPECT_NEAR(slope, here.gradients(0, j), 2e-6 * (std::abs(slope) + here.gradients.row(0).norm()))
                    << e.space.variables[static_cast<std::size_t>(j)].name;
            }
        }
    }
}

TEST(KeptShape, ResponsesAndTheMetricAreThoseOfTheSurface) {
    for (const Kind& one : kinds()) {
        Evaluated e(problem_of(one, {VariableKind::load}, 6), 1);
        const Eigen::VectorXd x = 0.2 * random_vector(e.space.size(), 7);
        e.at(x);
        std::vector<Points> rates;
        design_response(e.space, e.evaluator.shell(), [&](int, const Points& dv) { rates.push_back(dv); });
        for (int j = 0; j < e.space.size(); ++j) {
            const Eigen::VectorXd h = 1e-4 * Eigen::VectorXd::Unit(e.space.size(), j);
            const Points slope = (e.at(x + h).vertices - e.at(x - h).vertices) / 2e-4;
            EXPECT_LT((slope - rates[static_cast<std::size_t>(j)]).norm(), 1e-5 * slope.norm())
                << e.space.variables[static_cast<std::size_t>(j)].name;
        }
        const Eigen::VectorXd none = Eigen::VectorXd::Zero(e.space.size());
        e.at(none);
        for (int j = 0; j < e.space.size(); j += 3) {
            const Eigen::VectorXd d = Eigen::VectorXd::Unit(e.space.size(), j);
            const Eigen::VectorXd product = e.evaluator.metric_product(none, d), wanted = e.space.metric * d;
            EXPECT_LT((product - wanted).norm(), 1e-5 * wanted.norm()) << to_string(one.kind) << j;
        }
    }
}

TEST(KeptShape, AWholeRunStaysWithinIt) {
    for (const Kind& one : kinds()) {
        Problem problem = problem_of(one, {VariableKind::normal_load});
        maximize_volume(problem);
        problem.optimize.max_evaluations = 14;
        problem.optimize.min_expected_gain = 0;
        double worst = 0;
        int shapes = 0;
        RunEvents events;
        events.accepted = [&](const AcceptedDesign& design) {
            worst = std::max(worst, off_kind(with_vertices(one.mesh, design.vertices), one.kind));
            ++shapes;
        };
        const RunResult r = optimize(problem, events);
        EXPECT_TRUE(r.is_done()) << r.status << ": " << r.reason;
        EXPECT_GT(r.levels.size(), 1u);
        EXPECT_GT(shapes, 3);
        EXPECT_GT(r.objective, 1.001 * r.objective_start) << to_string(one.kind);
        worst = std::max(worst, off_kind(with_vertices(one.mesh, r.vertices), one.kind));
        EXPECT_LT(worst, 1e-12 * box_diagonal(one.mesh)) << to_string(one.kind);
        for (const LevelSummary& level : r.levels) EXPECT_LT(level.inherited_shape_change, 1e-10);
    }
}

TEST(KeptShape, WhatWouldLeaveItIsRefused) {
    const Kind one = kinds()[0];
    Problem problem = problem_of(one, {VariableKind::strain}, 0);
    EXPECT_THROW(rest_facts(problem), InvalidInput) << "rigid patches";
    problem = problem_of(one, {VariableKind::load}, 0);
    problem.fixed = {0};
    EXPECT_THROW(rest_facts(problem), InvalidInput) << "held on one side";
    problem = problem_of(one, {VariableKind::load}, 0);
    problem.fixed.clear();
    PrescribedStrain turn;
    turn.triangles = held_end(one.mesh, one.kind);
    turn.motion.rotation = Vector3d(0, 0.1, 0);
    problem.strains = {turn};
    EXPECT_NO_THROW(rest_facts(problem)) << "about the axis of the extrusion";
    problem.strains[0].motion.rotation = Vector3d(0, 0, 0.1);
    EXPECT_THROW(rest_facts(problem), InvalidInput) << "about another one";
}

}  // namespace strake::kept_shape
