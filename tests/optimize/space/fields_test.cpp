#include "core/error.hpp"
#include "core/fields/displacement_fields.hpp"
#include "optimize/evaluate/evaluation.hpp"
#include "optimize/run/coarse_to_fine.hpp"
#include "optimize/run/fit.hpp"
#include "problems.hpp"

#include <gtest/gtest.h>

using namespace strake;

namespace {

Problem with_fields(int number, std::vector<VariableKind> kinds = {VariableKind::load}) {
    Problem problem = ellipsoid_problem(2, 3);
    problem.parameters.kinds = std::move(kinds);
    problem.parameters.free_border = 0.6;
    FieldConditions conditions;
    conditions.held = problem.fixed;
    add_fields(problem.parameters,
               std::make_shared<const DisplacementFields>(problem.surface, conditions, FieldOptions{number, {}}));
    return problem;
}

struct Evaluated {
    Problem problem;
    std::shared_ptr<const RestFacts> rest;
    ShapeEvaluator evaluator;
    DesignSpace space;
    Evaluated(Problem p, int level)
        : problem(std::move(p)),
          rest(rest_facts(problem)),
          evaluator(problem, rest, {"volume", "area"}),
          space(design_space(rest, level)) {
        evaluator.enter(space);
    }
    ShapeEvaluation at(const Eigen::VectorXd& x) {
        ShapeEvaluation e = evaluator.evaluate(x, 1);
        EXPECT_EQ(e.status, EvaluationStatus::ok) << e.reason;
        return e;
    }
};

int count_of(const DesignSpace& space, VariableKind kind) {
    return static_cast<int>(
        std::ranges::count_if(space.variables, [&](const Variable& variable) { return variable.kind == kind; }));
}

}  // namespace

TEST(Fields, AreLevelZeroAndStayBesideThePatches) {
    const Evaluated coarse(with_fields(12), 0), fine(with_fields(12), 1);
    EXPECT_EQ(coarse.space.size(), 12);
    EXPECT_EQ(count_of(coarse.space, VariableKind::field), 12);
    EXPECT_EQ(count_of(fine.space, VariableKind::field), 12);
    EXPECT_EQ(count_of(fine.space, VariableKind::load), 6);
    EXPECT_EQ(coarse.space.variables[0].name, fine.space.variables[0].name);
    EXPECT_EQ(coarse.space.variables[0].name.substr(0, 8), "section.");
}

TEST(Fields, GradientsAreExactAloneAndBesidePatches) {
    for (const auto& kinds : std::vector<std::vector<VariableKind>>{
             {VariableKind::load}, {VariableKind::normal_load, VariableKind::stiffness}, {VariableKind::strain}, {}})
        for (const double size : {0.1, 0.6})
            for (const int level : {0, 1}) {
                if (level == 0 && kinds != std::vector<VariableKind>{VariableKind::load}) continue;
                Evaluated e(with_fields(12, kinds), level);
                const Eigen::VectorXd x = size * random_vector(e.space.size(), 3), p = random_vector(e.space.size(), 5);
                ShapeEvaluation here = e.at(x);
                e.evaluator.differentiate(here);
                for (int i = 0; i < 2; ++i) {
                    const Eigen::VectorXd g = here.gradients.row(i);
                    const auto J = [&](const Eigen::VectorXd& y) { return e.at(y).values[i]; };
                    EXPECT_NEAR(taylor_order(J, x, g, p, 3e-3), 2, 0.15) << kinds.size() << ' ' << size << ' ' << i;
                    Eigen::VectorXd wrong = g;
                    wrong[0] *= 1.1;
                    EXPECT_NEAR(taylor_order(J, x, wrong, p, 3e-3), 1, 0.15) << "the test can fail";
                }
            }
}

TEST(Fields, AChangeOfFieldsAloneMovesTheSurfaceByThemAndLeavesTheShell) {
    Evaluated e(with_fields(12), 1);
    Eigen::VectorXd x = 0.5 * random_vector(e.space.size(), 3);
    const Points before = e.at(x).vertices;
    const Poses poses = e.evaluator.poses();
    Eigen::VectorXd change = Eigen::VectorXd::Zero(x.size());
    change.head(12) = 0.3 * random_vector(12, 4);
    const Points after = e.at(x + change).vertices;
    EXPECT_LT((after - before - field_motion(e.space, change)).cwiseAbs().maxCoeff(), 1e-14);
    for (std::size_t t = 0; t < poses.rotation.size(); ++t)
        EXPECT_EQ(poses.rotation[t].coeffs(), e.evaluator.poses().rotation[t].coeffs()) << "no new equilibrium";
    for (const int t : e.problem.fixed)
        for (int k = 0; k < 3; ++k) {
            const int v = e.problem.surface.triangles(t, k);
            EXPECT_EQ(after.row(v), e.problem.surface.vertices.row(v));
        }
}

TEST(Fields, AreInheritedExactlyFromLevelToLevel) {
    for (const auto& kinds :
         std::vector<std::vector<VariableKind>>{{VariableKind::load}, {VariableKind::normal_load}}) {
        Evaluated e(with_fields(12, kinds), 0);
        DesignSpace space = e.space;
        Eigen::VectorXd x = 0.5 * random_vector(space.size(), 9);
        ShapeEvaluation before = e.at(x);
        for (int level = 1; level <= 3; ++level) {
            e.evaluator.accept();
            const InheritedSpace child = refine(space, x);
            e.evaluator.enter(child.space);
            const ShapeEvaluation after = e.at(child.x);
            EXPECT_LT((after.vertices - before.vertices).cwiseAbs().maxCoeff(), 1e-10 * e.rest->diagonal);
            EXPECT_EQ(child.prolongation.cols(), space.size());
            space = child.space;
            x = child.x + 0.1 * random_vector(child.x.size(), 10);  // patches join in
            before = e.at(x);
        }
    }
}

TEST(Fields, TheMetricCouplesThemWithLoadsThroughTheirDisplacements) {
    Evaluated e(with_fields(6), 1);
    e.at(Eigen::VectorXd::Zero(e.space.size()));
    std::vector<Points> moved;
    design_response(e.space, e.evaluator.shell(), [&](int, const Points& dv) { moved.push_back(dv); });
    const double reach = e.problem.parameters.max_displacement * e.rest->diagonal, all = e.rest->vertex_area.sum();
    for (int i = 0; i < 6; ++i) {
        EXPECT_NEAR(moved[i].rowwise().norm().maxCoeff(), reach, 1e-9 * reach) << "the unit of all variables";
        for (int j = 0; j < e.space.size(); ++j) {
            const double mean = (e.rest->vertex_area.asDiagonal() * moved[i]).cwiseProduct(moved[j]).sum() / all;
            EXPECT_NEAR(e.space.metric(i, j), 4 * mean / (reach * reach), 1e-6 + (i == j ? 1e-8 : 0)) << i << ' ' << j;
        }
    }
    EXPECT_GT(e.space.metric.topRightCorner(6, e.space.size() - 6).cwiseAbs().maxCoeff(), 1e-2);
}

/// At an equilibrium under loads the product is that of the metric of the responses there.
TEST(Fields, ThePresentMetricKnowsThem) {
    Evaluated e(with_fields(6), 1);
    const Eigen::VectorXd x = Eigen::VectorXd::Zero(e.space.size());
    e.at(x);
    for (int j : {0, 3, 7}) {
        const Eigen::VectorXd d =
            Eigen::VectorXd::Unit(e.space.size(), j) + 0.3 * Eigen::VectorXd::Unit(e.space.size(), 1);
        const Eigen::VectorXd product = e.evaluator.metric_product(x, d), wanted = e.space.metric * d;
        ASSERT_EQ(product.size(), wanted.size());
        EXPECT_LT((product - wanted).norm(), 1e-5 * wanted.norm()) << j;
    }
}

TEST(Fields, AWingletTheyRaiseIsNotInvertedButAFoldIs) {
    Evaluated e(with_fields(12), 0);
    int turns = -1;
    for (int j = 0; j < e.space.size(); ++j)
        if (e.space.variables[j].name == "section.twist.0") turns = j;
    ASSERT_GE(turns, 0);
    const double unit = e.space.variables[turns].unit;
    // Sections that turn by more than a right angle.
    Eigen::VectorXd x = Eigen::VectorXd::Zero(e.space.size());
    x[turns] = 1.0 / unit;
    const ShapeEvaluation turned = e.evaluator.evaluate(x, 1);
    EXPECT_TRUE(turned.reason.find("inverted") == std::string::npos) << turned.reason;
    int scales = -1;
    for (int j = 0; j < e.space.size(); ++j)
        if (e.space.variables[j].name.rfind("section.scale_z.0", 0) == 0) scales = j;
    ASSERT_GE(scales, 0);
    x.setZero();
    x[scales] = 3.0 / e.space.variables[scales].unit;
    const ShapeEvaluation one = e.evaluator.evaluate(x, 2), other = e.evaluator.evaluate(-x, 3);
    EXPECT_TRUE(one.status == EvaluationStatus::invalid || other.status == EvaluationStatus::invalid)
        << "through itself and out on the other side";
}

TEST(Fields, ARunBeginsWithThemAndGoesOnWithPatches) {
    for (const SplitRule split : {SplitRule::tree, SplitRule::sensitivity}) {
        Problem problem = with_fields(12, {VariableKind::normal_load});
        problem.parameters.split = split;
        problem.optimize.min_expected_gain = 0;
        maximize_volume(problem);
        problem.optimize.max_evaluations = 30;
        const RunResult r = optimize(problem);
        EXPECT_TRUE(r.is_done()) << r.status << ": " << r.reason;
        ASSERT_GT(r.levels.size(), 1u);
        EXPECT_EQ(r.levels[0].level, 0);
        EXPECT_EQ(r.levels[0].variables, 12);
        EXPECT_GT(r.levels[1].variables, 12);
        for (const LevelSummary& level : r.levels) EXPECT_LT(level.inherited_shape_change, 1e-10);
        Problem without = problem;
        without.parameters.user_variables.clear();
        without.parameters.fields.reset();
        EXPECT_GT(r.objective, (1 - 1e-3) * optimize(without).objective);
    }
}

/// Vertices moved by one field more than the first level has: of all candidates the run takes this one.
TEST(Fields, ARefinementTakesTheFieldThatTheGradientAsksFor) {
    Problem problem = with_fields(27, {VariableKind::normal_load});
    constexpr int wanted = 19, first = 12;
    problem.parameters.field_steps = {first, 27};
    problem.parameters.split = SplitRule::sensitivity;
    problem.parameters.max_displacement = 0.1;
    const Points target = problem.surface.vertices + 0.03 * problem.parameters.fields->field(wanted) +
                          0.03 * problem.parameters.fields->field(3);
    problem.quantities = {target_shape_same("match", problem.surface, with_vertices(problem.surface, target))};
    problem.objective = problem.quantities[0].names[0];
    problem.maximize = false;
    problem.constraints.clear();
    problem.optimize.max_evaluations = 25;
    std::vector<std::vector<int>> fields;
    RunEvents events;
    events.level = [&](const LevelStart& level) { fields.push_back(level.space.fields.numbers); };
    const RunResult r = optimize(problem, events);
    ASSERT_GT(fields.size(), 1u) << r.reason;
    EXPECT_EQ(fields[0].size(), static_cast<std::size_t>(first));
    EXPECT_TRUE(std::ranges::binary_search(fields[1], wanted));
    EXPECT_LT(fields[1].size(), 20u) << "fields that the target does not need";
    EXPECT_LT(r.objective, 1e-6 * r.objective_start);
    for (const LevelSummary& level : r.levels) EXPECT_LT(level.inherited_shape_change, 1e-10);
}

TEST(Fields, OfSuccessiveLevelsWhereNothingTellsWhichToTake) {
    Problem problem = with_fields(12);
    problem.parameters.field_steps = {4, 9, 12};
    const std::shared_ptr<const RestFacts> rest = rest_facts(problem);
    const DesignSpace coarse = design_space(rest, 0);
    EXPECT_FALSE(coarse.has_patches);
    EXPECT_EQ(coarse.fields.numbers, (std::vector{0, 1, 2, 3}));
    EXPECT_EQ(level_set(*rest, 1).fields.numbers.size(), 9u);
    EXPECT_EQ(more_fields(problem.parameters, {{0, 1, 2, 3, 8}, 9}).numbers.size(), 12u) << "those passed over, too";
    // Values of fields that a level does not have are carried, not lost.
    const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(coarse.size(), 0.1, 0.4);
    const InheritedSpace fewer = refine(coarse, x, LevelSet{*coarse.front, {{1, 3}, 4}, true});
    EXPECT_EQ(count_of(fewer.space, VariableKind::field), 2);
    const Eigen::VectorXd before = demand(coarse, x).fields, after = demand(fewer.space, fewer.x).fields;
    EXPECT_LT((before - after).norm(), 1e-12 * before.norm());
    Problem wrong = problem;
    wrong.parameters.field_steps = {4, 4, 12};
    EXPECT_THROW(rest_facts(wrong), InvalidInput);
    wrong.parameters.field_steps = {4, 9};
    EXPECT_THROW(rest_facts(wrong), InvalidInput);
}

TEST(Fields, AFitWithThemFindsATaperedAndFlattenedBody) {
    Problem problem = with_fields(27, {});
    TriMesh target = problem.surface;
    for (int v = 0; v < target.num_vertices(); ++v) {
        const double s = std::max(0.0, target.vertices(v, 0) + 0.75) / 1.75;  // zero where it is held
        target.vertices(v, 1) *= 1 + 0.15 * s;
        target.vertices(v, 2) *= 1 - 0.2 * s;
        target.vertices(v, 0) += 0.1 * s;
    }
    problem.parameters.max_displacement = 0.1;
    problem.quantities = {target_shape_same("match", problem.surface, target)};
    problem.fit = {problem.quantities[0].names[0]};
    problem.optimize.max_evaluations = 20;
    const RunResult r = fit(problem);
    const double before = (target.vertices - problem.surface.vertices).norm();
    EXPECT_LT((r.vertices - target.vertices).norm(), std::sqrt(0.03) * before) << r.reason;
}

TEST(Fields, WrongOnesAreRefused) {
    Problem problem = with_fields(6);
    problem.parameters.user_variables.push_back(problem.parameters.user_variables[0]);
    EXPECT_THROW(rest_facts(problem), InvalidInput) << "a name twice";
    problem = with_fields(6);
    problem.parameters.fields.reset();
    EXPECT_THROW(rest_facts(problem), InvalidInput) << "a field that is not there";
    problem = with_fields(6);
    problem.surface = ellipsoid({1, 0.6, 0.4}, 3);
    EXPECT_THROW(rest_facts(problem), InvalidInput) << "of another surface";
}
