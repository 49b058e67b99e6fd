#include "core/error.hpp"
#include "core/fields/displacement_fields.hpp"
#include "core/wrap/wrap_map.hpp"
#include "evaluated.hpp"
#include "optimize/check/border_turn.hpp"
#include "optimize/space/shape_map.hpp"
#include "problems.hpp"

#include <gtest/gtest.h>

using namespace strake;

namespace {

/// Two ellipsoids that pierce each other.
TriMesh pierced_body() {
    const TriMesh one = ellipsoid({1, 0.6, 0.4}, 2), two = ellipsoid({0.3, 0.8, 0.2}, 2);
    TriMesh both;
    both.vertices.resize(one.num_vertices() + two.num_vertices(), 3);
    both.vertices << one.vertices, two.vertices;
    both.triangles.resize(one.num_triangles() + two.num_triangles(), 3);
    both.triangles << one.triangles, (two.triangles.array() + one.num_vertices()).matrix();
    return both;
}

/// Such a body, held at its -x end, in an ellipsoid that is elastic in its place.
Problem wrapped(int fields, std::vector<VariableKind> kinds = {VariableKind::load}) {
    Problem problem;
    problem.name = "wrapped";
    problem.surface = pierced_body();
    const Points c = triangle_centroids(problem.surface);
    WrapMapOptions options;
    options.held.assign(static_cast<std::size_t>(problem.surface.num_vertices()), 0);
    for (int t = 0; t < problem.surface.num_triangles(); ++t)
        if (c(t, 0) < -0.75) {
            problem.fixed.push_back(t);
            for (int k = 0; k < 3; ++k) options.held[static_cast<std::size_t>(problem.surface.triangles(t, k))] = 1;
        }
    const TriMesh around = ellipsoid({1.15, 0.9, 0.55}, 2);
    problem.wrap = std::make_shared<const WrapMap>(around, problem.surface, options);
    const Points w = triangle_centroids(around);
    for (int t = 0; t < around.num_triangles(); ++t)
        if (w(t, 0) < -0.7) problem.supports.push_back(t);
    problem.tree = octants(around, 3);
    problem.prism_height = Eigen::VectorXd::Constant(around.num_vertices(), 0.1);
    problem.parameters.kinds = std::move(kinds);
    problem.quantities = {closed_volume(problem.surface), area(true)};
    if (fields == 0) return problem;
    FieldConditions conditions;
    conditions.held = problem.fixed;
    add_fields(problem.parameters,
               std::make_shared<const DisplacementFields>(problem.surface, conditions, FieldOptions{fields, {}}));
    return problem;
}

}  // namespace

TEST(WrapSpace, AtRestAreTheBitsOfTheSurfaceAndWhatIsHeldStays) {
    Evaluated e(wrapped(6));
    const Points& rest = e.problem.surface.vertices;
    EXPECT_EQ(e.at(Eigen::VectorXd::Zero(e.space.size())).vertices, rest);
    const ShapeEvaluation moved = e.at(0.2 * random_vector(e.space.size(), 3));
    EXPECT_GT((moved.vertices - rest).cwiseAbs().maxCoeff(), 1e-3);
    for (const int t : e.problem.fixed)
        for (int k = 0; k < 3; ++k)
            EXPECT_EQ(moved.vertices.row(e.problem.surface.triangles(t, k)),
                      rest.row(e.problem.surface.triangles(t, k)));
    for (const char held : pinned_triangles(*e.rest)) EXPECT_TRUE(held == 0 || held == 1);
    EXPECT_EQ(pinned_triangles(*e.rest).size(), static_cast<std::size_t>(e.problem.surface.num_triangles()));
}

TEST(WrapSpace, GradientsThroughWrapAndBindingAreExact) {
    const std::vector<std::vector<VariableKind>> all{
        {VariableKind::load}, {VariableKind::normal_load, VariableKind::stiffness}, {VariableKind::strain}};
    for (const auto& kinds : all) {
        Problem problem = wrapped(kinds.front() == VariableKind::strain ? 0 : 6, kinds);
        problem.parameters.free_border = 0.6;
        Evaluated e(problem);
        const Eigen::VectorXd x = 0.15 * random_vector(e.space.size(), 3);
        ShapeEvaluation here = e.at(x);
        e.evaluator.differentiate(here);
        for (int i = 0; i < 2; ++i) {
            const Eigen::VectorXd g = here.gradients.row(i);
            // A direction that the value does change in.
            const Eigen::VectorXd p = random_vector(e.space.size(), 5) + 3 * g.normalized();
            const auto J = [&](const Eigen::VectorXd& y) { return e.at(y).values.at(static_cast<std::size_t>(i)); };
            EXPECT_NEAR(taylor_order(J, x, g, p, 3e-3), 2, 0.15) << static_cast<int>(kinds.front()) << ' ' << i;
            EXPECT_NEAR(taylor_order(J, x, 1.1 * g, p, 3e-3), 1, 0.15) << "the test can fail";
        }
    }
}

TEST(WrapSpace, ResponsesAreDerivativesOfTheShape) {
    Evaluated e(wrapped(6, {VariableKind::normal_load}));
    const Eigen::VectorXd x = 0.1 * random_vector(e.space.size(), 3), p = random_vector(e.space.size(), 5);
    e.at(x);
    Points along = Points::Zero(e.problem.surface.num_vertices(), 3);
    const Points here = e.at(x).vertices;
    design_response(
        e.space, e.evaluator.shell(), [&](int j, const Points& dv) { along += p[j] * dv; }, 1e-11, &here);
    constexpr double h = 1e-4;
    const Points change = (e.at(x + h * p).vertices - e.at(x - h * p).vertices) / (2 * h);
    EXPECT_LT((change - along).norm(), 1e-4 * along.norm());
}

/// Of bodies in a wrap, and of those that fields alone move: no row has a column of all vertices.
TEST(WrapSpace, ConditionsOfTheMotionLimitAreDerivativesOfItsVertices) {
    for (const bool has_shell : {true, false}) {
        Problem problem = wrapped(6, {VariableKind::normal_load});
        if (!has_shell) {
            problem.wrap.reset();
            problem.has_shell = false;
            problem.supports.clear();
            problem.prism_height.resize(0);
            problem.tree = octants(problem.surface, 2);
            problem.parameters.kinds.clear();
        }
        problem.parameters.max_displacement = 0.2;
        Evaluated e(problem);
        e.evaluator.limit_motion();
        const Eigen::VectorXd x = 0.15 * random_vector(e.space.size(), 3), p = random_vector(e.space.size(), 5);
        const MotionConditions at = e.evaluator.motion_conditions(x, 0.05);
        ASSERT_GE(at.rows.size(), 3u);
        const auto along = [&](const Eigen::VectorXd& y) {
            const Points now = e.evaluator.equilibrium(y);
            Eigen::VectorXd found(at.num_rows());
            for (std::size_t i = 0; i < at.rows.size(); ++i) {
                EXPECT_EQ(at.sensitivities[i].vertex.rows(), 0);
                found[static_cast<Eigen::Index>(i)] =
                    now.row(at.rows[i].vertex).dot(at.rows[i].direction) / e.evaluator.motion_limit().reference();
            }
            return found;
        };
        constexpr double h = 1e-4;
        const Eigen::VectorXd change = (along(x + h * p) - along(x - h * p)) / (2 * h);
        EXPECT_LT((change - at.slopes * p).norm(), 1e-5 * change.norm()) << has_shell;
        EXPECT_GT((change - 1.01 * at.slopes * p).norm(), 1e-3 * change.norm()) << "the test can fail";
    }
}

/// Without the strains that energies are measured by, the metric is the mean square motion of the surface.
TEST(WrapSpace, TheMetricIsThatOfTheSurface) {
    Evaluated e(wrapped(6, {VariableKind::normal_load}));
    const Eigen::VectorXd d = random_vector(e.space.size(), 2);
    e.at(Eigen::VectorXd::Zero(e.space.size()));
    const Eigen::VectorXd product = e.evaluator.metric_product(Eigen::VectorXd::Zero(e.space.size()), d);
    ASSERT_EQ(product.size(), d.size());
    EXPECT_LT((product - e.space.metric * d).norm(), 1e-6 * product.norm());
}

TEST(WrapSpace, ARunGainsAndItsDesignIsStored) {
    Problem problem = wrapped(6, {VariableKind::normal_load});
    problem.objective = "volume";
    problem.maximize = true;
    Constraint limit;
    limit.quantity = "area";
    limit.max = 1.01;
    limit.relative = true;
    problem.constraints = {limit};
    problem.optimize.max_evaluations = 12;
    expect_run_is_stored(problem, 0.003, 1e-9);
}

TEST(WrapSpace, TheMotionLimitIsOnTheSurface) {
    Problem problem = wrapped(0, {VariableKind::load});
    problem.objective = "volume";
    problem.maximize = true;
    problem.parameters.max_displacement = 0.01;
    problem.optimize.max_evaluations = 10;
    Points best;
    RunEvents events;
    events.accepted = [&](const AcceptedDesign& design) { best = design.vertices; };
    const RunResult r = optimize(problem, events);
    EXPECT_TRUE(r.is_done()) << r.reason;
    ASSERT_EQ(best.rows(), problem.surface.num_vertices());
    const double most = (best - problem.surface.vertices).rowwise().norm().maxCoeff();
    const double limit = 0.01 * box_diagonal(problem.surface);
    EXPECT_LE(most, limit * (1 + 1e-9));
    EXPECT_GT(most, 0.9 * limit);
}

TEST(WrapSpace, WhatAWrapCannotDoIsRefused) {
    const auto refusal = [](Problem problem) -> std::string {
        try {
            rest_facts(problem);
        } catch (const InvalidInput& refused) {
            return refused.what();
        }
        return "";
    };
    EXPECT_EQ(refusal(wrapped(6)), "");
    Problem problem = wrapped(6, {});
    problem.has_shell = false;
    problem.prism_height.resize(0);
    EXPECT_NE(refusal(problem).find("wrap: not possible together with shell: none"), std::string::npos)
        << refusal(problem);
    problem = wrapped(0);
    problem.fixed.push_back(problem.surface.num_triangles() - 1);
    EXPECT_NE(refusal(problem).find("is fixed, but not held by the wrap's binding"), std::string::npos);
    problem = wrapped(0);
    problem.surface = ellipsoid({1, 0.6, 0.4}, 2);
    EXPECT_NE(refusal(problem).find("vertices, the surface has"), std::string::npos) << refusal(problem);
    Problem other = wrapped(0);
    auto design = std::make_shared<StoredDesign>();
    design->tree = octants(ellipsoid({1, 1, 1}, 1), 1);
    EXPECT_THROW(check_elastic(*design, other.wrap->mesh().num_triangles()), InvalidInput);
}
