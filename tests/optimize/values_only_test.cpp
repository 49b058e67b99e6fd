#include "optimize/evaluate/evaluation.hpp"
#include "optimize/run/coarse_to_fine.hpp"
#include "optimize/space/refinement.hpp"
#include "problems.hpp"
#include "programs.hpp"

#include <gtest/gtest.h>
#include <Eigen/QR>

/// Runs without gradients, and what is handed from level to level in them.
namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A bowl with condition 1e4 in axes across the variables; its bottom is 1 away from the start in its own metric.
struct Bowl {
    MatrixXd hessian;
    VectorXd bottom;
    int gradients = 0;  ///< by differences

    explicit Bowl(int n) {
        const VectorXd entries = random_vector(n * n, 1);
        const MatrixXd across =
            Eigen::HouseholderQR<MatrixXd>(Eigen::Map<const MatrixXd>(entries.data(), n, n)).householderQ();
        VectorXd stiffness(n);
        for (int j = 0; j < n; ++j) stiffness[j] = std::pow(1e4, double(j) / (n - 1));
        hessian = across * stiffness.asDiagonal() * across.transpose();
        bottom = across * (stiffness.array() * n).rsqrt().matrix();
    }
    double at(const VectorXd& x) const { return 0.5 * (x - bottom).dot(hessian * (x - bottom)); }
    NonlinearProgram program() {
        NonlinearProgram p;
        p.start = VectorXd::Zero(bottom.size());
        p.lower = VectorXd::Constant(bottom.size(), -2);
        p.upper = VectorXd::Constant(bottom.size(), 2);
        p.evaluate = [this](const VectorXd& x) {
            Evaluation s;
            s.objective = at(x);
            return s;
        };
        p.expect = [this](const std::vector<VectorXd>&) { ++gradients; };
        return p;
    }
};

class LocalWithoutGradients : public testing::TestWithParam<Method> {};

TEST_P(LocalWithoutGradients, SearchesInTheMetric) {
    const auto left_after = [](int evaluations, bool knows_metric) {
        Bowl bowl(10);
        NonlinearProgram p = bowl.program();
        if (knows_metric) p.metric = bowl.hessian;
        MinimizeOptions how;
        how.method = GetParam();
        how.max_evaluations = evaluations;
        return bowl.at(minimize(p, how).x) / bowl.at(p.start);
    };
    EXPECT_LT(left_after(300, true), 1e-3);
    EXPECT_LT(left_after(300, true), 0.1 * left_after(300, false));
}

TEST_P(LocalWithoutGradients, KeepsToTheBoundsInTheMetric) {
    Bowl bowl(4);
    bowl.hessian.setIdentity();
    bowl.bottom.setConstant(0.5);
    NonlinearProgram p = bowl.program();
    p.metric = MatrixXd::Identity(4, 4) + 0.5 * MatrixXd::Ones(4, 4);
    p.upper = VectorXd::Constant(4, 0.3);
    int outside = 0;
    p.evaluate = [&, evaluate = p.evaluate](const VectorXd& x) {
        outside += (x.array() > 0.3).any();
        return evaluate(x);
    };
    MinimizeOptions how;
    how.method = GetParam();
    how.max_evaluations = 1000;
    const MinimizeResult r = minimize(p, how);
    EXPECT_EQ(outside, 0);
    EXPECT_LT((r.x - p.upper).lpNorm<Eigen::Infinity>(), 1e-3) << r.x.transpose();
}

INSTANTIATE_TEST_SUITE_P(Methods, LocalWithoutGradients,
                         testing::Values(Method::cobyla, Method::bobyqa, Method::neldermead, Method::sbplx,
                                         Method::praxis),
                         [](const auto& info) { return method_facts(info.param).name; });

/// A model twenty times too stiff costs a gradient a step, unless the values along the step are asked.
TEST(Differences, AStepThatIsTooShortIsFollowedBeforeTheNextGradient) {
    Bowl bowl(12);
    NonlinearProgram p = bowl.program();
    p.metric = bowl.hessian;
    p.hessian = p.guessed = 20 * bowl.hessian;
    p.differences.emplace().central = true;  // exact, here
    MinimizeOptions how;
    how.max_evaluations = 1000;
    const MinimizeResult r = minimize(p, how);
    EXPECT_LT(bowl.at(r.x), 1e-5 * bowl.at(p.start));
    EXPECT_LE(bowl.gradients, 4);
}

/// Rejected steps teach the curvature that the values rise by; at the end all that they rise by is noise.
TEST(Noise, IsNotHandedOnAsCurvature) {
    int ended_in_noise = 0;
    std::string reasons;
    for (const double bias : {0.01, 0.03, 0.1, 0.3, 1.0}) {
        Bowl bowl(6);
        const MatrixXd exact = bowl.hessian;
        const VectorXd wrong = bias * (MatrixXd(exact.llt().matrixL()) * VectorXd::Ones(6));
        NonlinearProgram p = bowl.program();
        p.metric = exact;
        int call = 0;
        p.evaluate = [&](const VectorXd& x) {
            ++call;
            Evaluation s;
            s.objective = 1 + bowl.at(x) + 1e-3 * std::sin(37.0 * call * call);
            return s;
        };
        p.differentiate = [&](const VectorXd& x, Evaluation& s) {
            s.gradient = exact * (x - bowl.bottom) + wrong;
            s.jacobian.resize(0, 6);
        };
        MinimizeOptions how;
        how.max_evaluations = 300;
        how.confirm = false;
        const MinimizeResult r = minimize(p, how);
        reasons += r.reason + "\n";
        if (r.stop != MinimizeStop::roundoff && r.reason != "the expected decrease is below the tolerance") continue;
        ++ended_in_noise;
        EXPECT_LT(mean_curvature(r.hessian, exact), 10) << "bias " << bias;
    }
    EXPECT_GE(ended_in_noise, 1) << reasons;
}

/// Volume of an ellipsoid under an area limit, by values only.
Problem values_only(Method method) {
    Problem problem = ellipsoid_problem(2, 2);
    maximize_volume(problem);
    for (Quantity& quantity : problem.quantities) {
        quantity.has_sensitivities = false;
        quantity.evaluate = [evaluate = quantity.evaluate](const QuantityRequest& request) {
            QuantityResult result = evaluate(request);
            result.dJ_dv.clear();
            return result;
        };
    }
    problem.optimize.method = method;
    problem.optimize.finite_differences = true;
    problem.optimize.max_evaluations = 300;
    return problem;
}

TEST(ValuesOnly, ALevelStartsFromTheBestShapeThatWasSeen) {
    for (const Method method : {Method::sqp, Method::mma, Method::cobyla}) {
        const RunResult r = optimize(values_only(method));
        ASSERT_EQ(r.levels.size(), 2u) << method_facts(method).name;
        EXPECT_LT(r.levels[1].inherited_shape_change, 1e-10) << method_facts(method).name;
        EXPECT_EQ(r.levels[1].objective_start, r.levels[0].objective_end) << method_facts(method).name;
        EXPECT_GT(r.objective, 1.02 * r.objective_start) << method_facts(method).name;
    }
}

TEST(ValuesOnly, CoarseLevelsAreLeftWhileThereIsBudget) {
    const RunResult r = optimize(values_only(Method::sqp));
    ASSERT_EQ(r.levels.size(), 2u) << r.reason;
    EXPECT_LT(r.levels[0].evaluations, 100);
    EXPECT_EQ(r.levels[0].stop, "finer details are expected to gain more");
}

}  // namespace

/// Each level has its share of the budget. Where finer ones expect no gain what is left is the present one's.
TEST(CoarseToFine, ABudgetIsNotLeftOverWhereRefiningExpectsNothing) {
    Problem problem = ellipsoid_problem(2, 3);
    maximize_volume(problem);
    problem.parameters.split = SplitRule::sensitivity;
    problem.optimize.min_expected_gain = 1e3;
    problem.optimize.progress_below = 0;
    problem.optimize.max_evaluations = 9;
    problem.constraints.clear();
    const RunResult r = optimize(problem);
    EXPECT_NE(r.reason.find("no progress is expected from further refinement"), std::string::npos) << r.reason;
    EXPECT_EQ(r.levels.size(), 1u);
    EXPECT_TRUE(r.evaluations == 9 || r.status == "converged") << r.evaluations << ", " << r.status << ", " << r.reason;
    EXPECT_GT(r.evaluations, 3);
}

/// A level with less than four evaluations steps too far and has none to come back. Where the budget pays for fewer
/// levels the first ones have it; three of four evaluations are the control.
TEST(CoarseToFine, ABudgetIsNotSplitForLevelsThatItCannotMove) {
    for (const auto& [budget, first] : {std::pair{6, 6}, {8, 4}, {12, 4}, {15, 5}}) {
        Problem problem = ellipsoid_problem(2, 3);
        maximize_volume(problem);
        problem.optimize.progress_below = 0;
        problem.optimize.max_evaluations = budget;
        const RunResult r = optimize(problem);
        ASSERT_GE(static_cast<int>(r.levels.size()), 1) << budget;
        EXPECT_EQ(r.levels[0].evaluations, first) << budget;
        problem.optimize.shares_with_all_levels = true;  // as runs before 0.2 are replayed
        EXPECT_EQ(optimize(problem).levels.at(0).evaluations, budget / 3) << budget;
    }
}

/// A variable at its bound can do no more, but its parts have bounds of their own.
TEST(Refinement, WhatABoundForbidsIsExpectedOfTheParts) {
    Problem problem = ellipsoid_problem(2, 2);
    maximize_volume(problem);
    const DesignSpace space = design_space(rest_facts(problem), 1);
    ShapeEvaluator evaluator(problem, space.rest, {"volume"});
    evaluator.enter(space);
    ShapeEvaluation e = evaluator.evaluate(VectorXd::Zero(space.size()), 1);
    ASSERT_EQ(e.status, EvaluationStatus::ok);
    evaluator.differentiate(e);
    const auto below = prospect(space, VectorXd::Zero(space.size()));
    ASSERT_TRUE(below);
    const VectorXd g = design_gradient(space, VectorXd::Zero(space.size()), e.sensitivities[0]);
    Eigen::Index steepest = 0;
    g.cwiseAbs().maxCoeff(&steepest);
    const auto expected = [&](double at) {
        VectorXd x = VectorXd::Zero(space.size());
        x[steepest] = at;
        return expected_decrease_of({space, x, e.sensitivities[0], 1, e.dJ_dv[0]}, *below);
    };
    const double inward = g[steepest] > 0 ? space.upper[steepest] : space.lower[steepest];
    const double outward = g[steepest] > 0 ? space.lower[steepest] : space.upper[steepest];
    EXPECT_EQ(expected(inward), expected(0));
    EXPECT_GT(expected(outward), expected(0) + 0.25 * g[steepest] * g[steepest] / space.metric(steepest, steepest) / 2);
}

}  // namespace strake
