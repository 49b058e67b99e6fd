#include "cases/geometry/dirty_body.hpp"
#include "core/error.hpp"
#include "core/fields/displacement_fields.hpp"
#include "evaluated.hpp"
#include "optimize/evaluate/fold_conditions.hpp"
#include "optimize/run/fit.hpp"
#include "problems.hpp"

#include <gtest/gtest.h>

using namespace strake;

namespace {

/// Any surface, its first eighth along x held, moved by fields alone.
Problem without_shell(const TriMesh& surface, int number, bool has_volume = true) {
    Problem problem;
    problem.name = "dirty";
    problem.surface = surface;
    problem.has_shell = false;
    problem.tree.levels = {level_by(surface, nullptr, [](int) { return 0; })};
    const Points c = triangle_centroids(surface);
    const double low = c.col(0).minCoeff(), high = c.col(0).maxCoeff();
    FieldConditions conditions;
    for (int t = 0; t < surface.num_triangles(); ++t)
        if (c(t, 0) < low + (high - low) / 8) problem.fixed.push_back(t);
    conditions.held = problem.fixed;
    problem.parameters.kinds.clear();
    add_fields(problem.parameters,
               std::make_shared<const DisplacementFields>(surface, conditions, FieldOptions{number, {}}));
    if (has_volume) problem.quantities.push_back(closed_volume(surface));
    problem.quantities.push_back(area(true));
    return problem;
}

}  // namespace

TEST(WithoutShell, EveryDirtyBodyMovesExactlyByTheFields) {
    for (const std::string& kind : example::dirty_body_kinds()) {
        // Panels that meet in T-junctions only: each by itself encloses nothing.
        Evaluated e(without_shell(example::dirty_body(kind), 12, kind != "t_junctions"));
        const Points& rest = e.problem.surface.vertices;
        const ShapeEvaluation start = e.evaluator.evaluate(Eigen::VectorXd::Zero(e.space.size()), 1);
        ASSERT_EQ(start.status, EvaluationStatus::ok) << kind << ": " << start.reason;
        EXPECT_EQ(start.vertices, rest) << "the bits of the file";
        const Eigen::VectorXd x = 0.15 * random_vector(e.space.size(), 3);
        const ShapeEvaluation at = e.evaluator.evaluate(x, 2);
        ASSERT_EQ(at.status, EvaluationStatus::ok) << kind << ": " << at.reason;
        const Points wanted = rest + field_motion(e.space, x);
        EXPECT_LT((at.vertices - wanted).cwiseAbs().maxCoeff(), 1e-14 * e.rest->diagonal);
        for (const int t : e.problem.fixed)
            for (int k = 0; k < 3; ++k) {
                const int v = e.problem.surface.triangles(t, k);
                EXPECT_EQ(at.vertices.row(v), rest.row(v));
            }
        EXPECT_EQ(e.evaluator.shell(), nullptr);
    }
}

TEST(WithoutShell, GradientsAreExact) {
    for (const char* kind : {"wing_through_body", "holes", "inner_walls", "crossing_boxes"}) {
        Evaluated e(without_shell(example::dirty_body(kind), 12));
        const Eigen::VectorXd x = 0.1 * random_vector(e.space.size(), 3), p = random_vector(e.space.size(), 5);
        ShapeEvaluation here = e.evaluator.evaluate(x, 1);
        ASSERT_EQ(here.status, EvaluationStatus::ok) << kind << ": " << here.reason;
        e.evaluator.differentiate(here);
        for (int i = 0; i < 2; ++i) {
            const Eigen::VectorXd g = here.gradients.row(i);
            const auto J = [&](const Eigen::VectorXd& y) { return e.evaluator.evaluate(y, 1).values.at(i); };
            EXPECT_NEAR(taylor_order(J, x, g, p, 3e-3), 2, 0.15) << kind << ' ' << i;
            EXPECT_NEAR(taylor_order(J, x, 1.1 * g, p, 3e-3), 1, 0.15) << "the test can fail";
        }
    }
}

TEST(WithoutShell, TheMetricIsThatOfTheDisplacements) {
    Evaluated e(without_shell(example::dirty_body("crossing_boxes"), 8));
    Points moved[2] = {field_motion(e.space, Eigen::VectorXd::Unit(8, 1)),
                       field_motion(e.space, Eigen::VectorXd::Unit(8, 4))};
    const double reach = e.problem.parameters.max_displacement * e.rest->diagonal, all = e.rest->vertex_area.sum();
    EXPECT_NEAR(moved[0].rowwise().norm().maxCoeff(), reach, 1e-9 * reach);
    const double mean = (e.rest->vertex_area.asDiagonal() * moved[0]).cwiseProduct(moved[1]).sum() / all;
    EXPECT_NEAR(e.space.metric(1, 4), 4 * mean / (reach * reach), 1e-6);
    e.evaluator.evaluate(Eigen::VectorXd::Zero(8), 1);
    const Eigen::VectorXd d = random_vector(8, 2);
    EXPECT_LT((e.evaluator.metric_product(Eigen::VectorXd::Zero(8), d) - e.space.metric * d).norm(), 1e-12 * d.norm());
}

TEST(WithoutShell, ARunGainsAndItsDesignIsStored) {
    Problem problem = without_shell(example::dirty_body("wing_through_body"), 12);
    maximize_volume(problem, 1.01);
    problem.optimize.max_evaluations = 12;
    expect_run_is_stored(problem, 0.005, 1e-12);
}

/// Of a thin body whose motion limit is far beyond its thickness: what fields fold is known before it is evaluated.
TEST(WithoutShell, FoldsAreALimitThatNoEvaluationIsPaidFor) {
    Problem problem = without_shell(ellipsoid({1, 0.6, 0.06}, 3), 18);
    maximize_volume(problem);
    problem.maximize = false;
    problem.constraints.clear();
    problem.optimize.max_evaluations = 16;
    int folded = 0;
    RunEvents events;
    events.evaluation = [&](const EvaluationRecord& record) {
        folded += record.reason.find("fold space") != std::string::npos;
    };
    const RunResult r = optimize(problem, events);
    EXPECT_TRUE(r.is_done()) << r.status << ": " << r.reason;
    EXPECT_LT(r.objective, 0.35 * r.objective_start);  // a map may take all but a twentieth
    EXPECT_EQ(folded, 0);
}

TEST(WithoutShell, ConditionsOfFoldsAreThoseOfTheDeterminants) {
    const Evaluated e(without_shell(ellipsoid({1, 0.6, 0.06}, 2), 18));
    const Eigen::VectorXd x = 0.4 * random_vector(e.space.size(), 3), p = random_vector(e.space.size(), 5);
    constexpr double below = 0.95, h = 1e-6;
    const FoldConditions at = fold_conditions(e.space, x, below);
    ASSERT_GT(at.values.size(), 3);
    ASSERT_LE(at.values.size(), 24);
    EXPECT_EQ(at.values.maxCoeff(), at.values[0]) << "the least determinant first";
    const Eigen::VectorXd change =
        (fold_conditions(e.space, x + h * p, below).values - fold_conditions(e.space, x - h * p, below).values) /
        (2 * h);
    ASSERT_EQ(change.size(), at.values.size());
    EXPECT_LT((change - at.slopes * p).norm(), 1e-7 * change.norm());
    EXPECT_GT((change - 1.001 * at.slopes * p).norm(), 1e-4 * change.norm()) << "the test can fail";
    const double least = wanted_determinant - at.values[0];
    EXPECT_TRUE(is_folded(e.space, x, least + 1e-9));
    EXPECT_FALSE(is_folded(e.space, x, least - 1e-9));
    EXPECT_FALSE(is_folded(e.space, Eigen::VectorXd::Zero(x.size())));
    EXPECT_EQ(fold_conditions(e.space, Eigen::VectorXd::Zero(x.size()), below).values.size(), 0);
}

/// From a design that does not fold: it stays possible, which a determinant linearised at the end of a step denies.
TEST(WithoutShell, ConditionsBetweenTwoDesignsHoldAtBoth) {
    const Evaluated e(without_shell(ellipsoid({1, 0.6, 0.06}, 2), 18));
    int cut_off = 0;
    for (const unsigned seed : {3u, 5u, 7u, 9u}) {
        Eigen::VectorXd to = random_vector(e.space.size(), seed);
        while (!is_folded(e.space, to)) to *= 1.5;
        for (const double reach : {1.0, 4.0, 16.0}) {
            const Eigen::VectorXd end = reach * to;
            Eigen::VectorXd from = 0.3 * to;
            while (is_folded(e.space, from)) from *= 0.9;
            const FoldConditions between = fold_conditions_between(e.space, from, end);
            const FoldConditions at = fold_conditions(e.space, end, wanted_determinant);
            ASSERT_GT(between.values.size(), 0);
            ASSERT_EQ(between.values.size(), at.values.size());
            EXPECT_LE(between.values.maxCoeff(), 0);
            const Eigen::VectorXd there = between.values + between.slopes * (end - from);
            for (Eigen::Index k = 0; k < there.size(); ++k)
                if (at.values[k] > 0) {
                    EXPECT_NEAR(there[k], at.values[k], 1e-9 * (1 + at.values[k]));
                }
            cut_off += static_cast<int>(((at.values - at.slopes * (end - from)).array() > 0).count());
        }
    }
    EXPECT_GT(cut_off, 0) << "the test can fail";
}

TEST(WithoutShell, AFitFindsAStretchedBody) {
    Problem problem = without_shell(example::dirty_body("crossing_cylinders"), 27);
    TriMesh target = problem.surface;
    const double low = target.vertices.col(0).minCoeff() + 0.55;
    for (int v = 0; v < target.num_vertices(); ++v)
        target.vertices(v, 2) += 0.02 * std::pow(std::max(0.0, target.vertices(v, 0) - low), 2);
    problem.parameters.max_displacement = 0.2;
    problem.quantities = {target_shape_same("match", problem.surface, target)};
    problem.fit = {problem.quantities[0].names[0]};
    problem.optimize.max_evaluations = 15;
    const RunResult r = fit(problem);
    EXPECT_LT((r.vertices - target.vertices).norm(), 0.2 * (target.vertices - problem.surface.vertices).norm())
        << r.reason;
}

TEST(WithoutShell, WhatNeedsAShellIsRefused) {
    const Problem problem = without_shell(example::dirty_body("crossing_boxes"), 6);
    const auto refused = [](const Problem& wrong) { EXPECT_THROW(rest_facts(wrong), InvalidInput); };
    Problem wrong = problem;
    wrong.parameters.kinds = {VariableKind::load};
    refused(wrong);
    wrong = problem;
    wrong.strains = {{{700}, {}}};
    refused(wrong);
    wrong = problem;
    wrong.given_traction = Points::Zero(wrong.surface.num_triangles(), 3);
    refused(wrong);
    wrong = problem;
    wrong.spring_per_area = Eigen::VectorXd::Ones(wrong.surface.num_triangles());
    refused(wrong);
    wrong = problem;
    UserVariable load;
    load.name = "push";
    load.triangles = {0};
    load.traction = Points::Ones(1, 3);
    wrong.parameters.user_variables.push_back(load);
    refused(wrong);
}

/// Fields of the same names of a body that is held elsewhere.
TEST(WithoutShell, DesignsOfOtherFieldsAreNotMixed) {
    Problem one = without_shell(example::dirty_body("wing_through_body"), 6), other = one;
    FieldConditions conditions;
    conditions.held.assign(one.fixed.begin(), one.fixed.begin() + static_cast<std::ptrdiff_t>(one.fixed.size() / 2));
    const auto fields = std::make_shared<const DisplacementFields>(other.surface, conditions, FieldOptions{6, {}});
    for (int b = 0; b < 6; ++b) ASSERT_EQ(fields->name(b), one.parameters.fields->name(b));
    other.parameters.fields = fields;
    maximize_volume(one, 1.01);
    one.optimize.max_evaluations = 2;
    std::optional<StoredDesign> best;
    RunEvents events;
    events.accepted = [&](const AcceptedDesign& design) { best = stored_design(design); };
    optimize(one, events);
    ASSERT_TRUE(best.has_value());
    const auto design = std::make_shared<const StoredDesign>(*best);
    try {
        mixed_design({one, design}, {other, design}, 0.3);
        ADD_FAILURE() << "was mixed";
    } catch (const InvalidInput& refused) {
        EXPECT_NE(std::string(refused.what()).find("displacement fields of the same names"), std::string::npos)
            << refused.what();
    }
}
