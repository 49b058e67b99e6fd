#include "core/error.hpp"
#include "core/fields/displacement_fields.hpp"
#include "core/planform/planform_motion.hpp"
#include "evaluated.hpp"
#include "optimize/evaluate/fold_conditions.hpp"
#include "optimize/evaluate/validity.hpp"
#include "optimize/problem/sliding_parts.hpp"
#include "optimize/space/field_conditions.hpp"
#include "problems.hpp"
#include "tests/core/planform/wing_bodies.hpp"

#include <gtest/gtest.h>

/// Changes of wings as design variables: alone, with fields, and with a shell.
namespace strake {
namespace {

enum class Beside { nothing, fields, shell };

/// Half a wing whose first 25 % of the span is fixed; the wing is what lies outboard.
Problem wing_problem(Beside beside) {
    Loft loft;
    loft.cells = 12;
    loft.panels = 16;
    Problem problem;
    problem.name = "wing";
    problem.surface = lofted(loft);
    problem.symmetry = SymmetryPlane{Eigen::Vector3d::UnitY(), 0};
    problem.has_shell = beside == Beside::shell;
    problem.tree = octants(problem.surface, problem.has_shell ? 1 : 0);
    WingDeclaration declared;
    declared.symmetry = problem.symmetry;
    declared.stations = {0, 0.5, 1};
    for (int t = 0; t < problem.surface.num_triangles(); ++t) {
        double low = 9;
        for (const int v : problem.surface.triangles.row(t)) low = std::min(low, problem.surface.vertices(v, 1));
        (low > 0.75 - 1e-9 ? declared.triangles : problem.fixed).push_back(t);
    }
    Parameters& p = problem.parameters;
    p.max_displacement = 0.01;
    const auto wing = std::make_shared<const Wing>(problem.surface, declared);
    std::vector<PlanformRange> ranges{
        {.change = PlanformChange::span, .lower = -0.05, .upper = 0.1},
        {.change = PlanformChange::sweep, .lower = -0.1, .upper = 0.1},
        {.change = PlanformChange::twist, .by_station = true, .root_held = true, .lower = -0.07, .upper = 0.07},
        {.change = PlanformChange::chord, .by_station = true, .root_held = true, .lower = -0.1, .upper = 0.1}};
    add_planform(p, std::make_shared<const PlanformMotion>(problem.surface, std::vector{wing}, ranges));
    if (problem.has_shell) {
        problem.prism_height =
            Eigen::VectorXd::Constant(problem.surface.num_vertices(), 0.02 * box_diagonal(problem.surface));
        p.kinds = {VariableKind::normal_load};
    } else {
        p.kinds.clear();
    }
    problem.quantities = {closed_volume(problem.surface), area(true)};
    if (beside == Beside::fields)
        add_fields(p, std::make_shared<const DisplacementFields>(problem.surface, field_conditions(problem),
                                                                 FieldOptions{6, {}}));
    return problem;
}

TEST(PlanformVariables, HaveTheirOwnRangesAndMoveTheStartExactly) {
    Evaluated e(wing_problem(Beside::nothing));
    ASSERT_EQ(e.space.size(), 6);
    EXPECT_EQ(e.space.variables[0].name, "wing.delta_span");
    EXPECT_DOUBLE_EQ(e.space.lower[0] * e.space.variables[0].unit, -0.05);
    EXPECT_DOUBLE_EQ(e.space.upper[0] * e.space.variables[0].unit, 0.1);
    e.evaluator.limit_motion();  // of 1 %, which the span alone exceeds by far
    const ShapeEvaluation at = e.evaluator.evaluate(e.space.upper, 1);
    ASSERT_EQ(at.status, EvaluationStatus::ok) << at.reason;
    const Points wanted = e.problem.surface.vertices +
                          e.problem.parameters.planform->displacement(planform_change(e.space, e.space.upper));
    EXPECT_EQ(at.vertices, wanted);
    EXPECT_GT(at.max_displacement, 0.05 * e.rest->diagonal);
    for (const int t : e.problem.fixed)
        for (const int v : e.problem.surface.triangles.row(t))
            EXPECT_EQ(at.vertices.row(v), e.problem.surface.vertices.row(v));
}

TEST(PlanformVariables, GradientsAreExactBesideFieldsAndShell) {
    for (const Beside beside : {Beside::nothing, Beside::fields, Beside::shell}) {
        SCOPED_TRACE(static_cast<int>(beside));
        Evaluated e(wing_problem(beside));
        const Eigen::VectorXd x = 0.15 * random_vector(e.space.size(), 3), p = random_vector(e.space.size(), 5);
        const ShapeEvaluation here = expect_exact_gradients(e, x, p);
        ASSERT_EQ(here.status, EvaluationStatus::ok) << here.reason;
        for (int i = 0; i < 2; ++i) {
            const Eigen::VectorXd g = here.gradients.row(i);
            const auto J = [&](const Eigen::VectorXd& y) { return e.at(y).values.at(i); };
            for (int j = 0; j < e.space.size(); ++j)
                if (e.space.variables[static_cast<std::size_t>(j)].kind == VariableKind::planform) {
                    const Eigen::VectorXd one = Eigen::VectorXd::Unit(e.space.size(), j);
                    const double h = 1e-4, slope = (J(x + h * one) - J(x - h * one)) / (2 * h);
                    EXPECT_NEAR(slope, g[j], 1e-5 * g.lpNorm<Eigen::Infinity>()) << j;
                }
        }
    }
}

/// The datum of the limit goes with the planform: what the shell adds is limited, wherever the wing is.
TEST(PlanformVariables, TheMotionLimitIsAboutTheMovedStart) {
    Evaluated e(wing_problem(Beside::fields));
    e.evaluator.limit_motion();
    Eigen::VectorXd x = e.space.upper.cwiseMin(1);
    x.tail(6).setConstant(0.02);
    const ShapeEvaluation good = e.evaluator.evaluate(x, 1);
    EXPECT_EQ(good.status, EvaluationStatus::ok) << good.reason;
    x.tail(6).setConstant(1);
    const ShapeEvaluation bad = e.evaluator.evaluate(x, 2);
    EXPECT_EQ(bad.status, EvaluationStatus::invalid);
    EXPECT_NE(bad.reason.find("motion limit"), std::string::npos) << bad.reason;
    EXPECT_TRUE(e.evaluator.is_beyond(x, 0));
    const Eigen::VectorXd inside = e.evaluator.within(x, 1e-3);
    EXPECT_EQ(inside.head(6), x.head(6)) << "changes of wings are not limited";
    EXPECT_EQ(e.evaluator.evaluate(inside, 3).status, EvaluationStatus::ok);
}

TEST(PlanformVariables, RunsGainAndGoOn) {
    for (const Beside beside : {Beside::nothing, Beside::fields, Beside::shell}) {
        SCOPED_TRACE(static_cast<int>(beside));
        Problem problem = wing_problem(beside);
        maximize_volume(problem, 1.0);
        problem.optimize.max_evaluations = 14;
        expect_run_is_stored(problem, 0.002, 1e-8);
    }
}

/// What keeps searches by fields from folds knows the wings, too: it says what the guard says.
TEST(PlanformVariables, FoldsAreThoseOfFieldsAndWingsTogether) {
    const Evaluated e(wing_problem(Beside::fields));
    // Half of each range; fields that shrink the sections, far beyond the motion limit.
    Eigen::VectorXd x = 0.5 * random_vector(e.space.size(), 3).cwiseMax(e.space.lower).cwiseMin(e.space.upper);
    const Eigen::VectorXd p = random_vector(e.space.size(), 5);
    constexpr double below = 0.9, h = 1e-4;
    for (int j = 0; j < e.space.size(); ++j)
        if (e.space.variables[static_cast<std::size_t>(j)].kind == VariableKind::field) x[j] = -std::abs(x[j]);
    for (int tries = 0; tries < 20 && fold_conditions(e.space, x, below).values.size() < 4; ++tries)
        for (int j = 0; j < e.space.size(); ++j)
            if (e.space.variables[static_cast<std::size_t>(j)].kind == VariableKind::field) x[j] *= 1.5;
    const FoldConditions at = fold_conditions(e.space, x, below);
    ASSERT_GE(at.values.size(), 4);
    const Eigen::VectorXd change =
        (fold_conditions(e.space, x + h * p, below).values - fold_conditions(e.space, x - h * p, below).values) /
        (2 * h);
    ASSERT_EQ(change.size(), at.values.size());
    EXPECT_LT((change - at.slopes * p).norm(), 1e-4 * change.norm());
    Eigen::MatrixXd without = at.slopes;
    for (int j = 0; j < e.space.size(); ++j)
        if (e.space.variables[static_cast<std::size_t>(j)].kind == VariableKind::planform) without.col(j).setZero();
    EXPECT_GT((change - without * p).norm(), 1e-2 * change.norm()) << "the test can fail";
    double least = 1;
    for (const Eigen::Matrix3d& map : local_maps(*e.rest, demand(e.space, x)))
        least = std::min(least, map.determinant());
    EXPECT_NEAR(wanted_determinant - at.values[0], least, 1e-12);
}

/// A wing that pierces a body may move in it; nothing else may.
TEST(PlanformVariables, TheCutOfAPiercingWingMayWander) {
    const std::vector<WingBody> all = wing_bodies();
    const auto body = std::find_if(all.begin(), all.end(), [](const WingBody& one) { return one.name == "body"; });
    ASSERT_NE(body, all.end());
    Problem problem;
    problem.surface = body->mesh;
    problem.has_shell = false;
    problem.symmetry = SymmetryPlane{Eigen::Vector3d::UnitY(), 0};
    const auto wing = std::make_shared<const Wing>(body->mesh, body->declared);
    const auto planform = std::make_shared<const PlanformMotion>(
        body->mesh, std::vector{wing},
        std::vector<PlanformRange>{
            {.change = PlanformChange::sweep, .by_station = true, .lower = -0.1, .upper = 0.1},
            {.change = PlanformChange::dihedral, .by_station = true, .lower = -0.1, .upper = 0.1}});
    const Eigen::VectorXd z = Eigen::VectorXd::Constant(planform->size(), 0.1);
    const Points moved = body->mesh.vertices + planform->displacement(z);
    const auto defect = [&] {
        const ValidityGuard guard(body->mesh, adjacency(body->mesh),
                                  {{}, problem.symmetry, sliding_triangles(problem), true});
        return guard.defect(moved, planform->local_maps(z));
    };
    EXPECT_TRUE(sliding_triangles(problem).empty());
    EXPECT_NE(defect().find("intersect"), std::string::npos) << "a part that does not move by itself: " << defect();
    add_planform(problem.parameters, planform);
    EXPECT_EQ(defect(), "");
    EXPECT_GT(intersections(with_vertices(body->mesh, moved)).apart.size(), 10U) << "it pierces as before";
    std::vector<char> of_wing(static_cast<std::size_t>(body->mesh.num_triangles()), 0);
    for (const int t : body->declared.triangles) of_wing[static_cast<std::size_t>(t)] = 1;
    for (const int t : sliding_triangles(problem)) EXPECT_TRUE(of_wing[static_cast<std::size_t>(t)]) << t;
}

TEST(PlanformVariables, WhatCannotBeIsRefused) {
    Problem moved = wing_problem(Beside::nothing);
    moved.fixed.push_back(moved.surface.num_triangles() - 1);  // at the tip
    EXPECT_THROW(rest_facts(moved), InvalidInput);
    Problem none = wing_problem(Beside::nothing);
    none.parameters.planform.reset();
    EXPECT_THROW(rest_facts(none), InvalidInput);
}

}  // namespace
}  // namespace strake
