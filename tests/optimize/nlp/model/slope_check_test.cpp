#include "optimize/nlp/model/slope_check.hpp"

#include "programs.hpp"

#include <gtest/gtest.h>

using namespace strake;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

bool says(const MinimizeResult& r, const std::string& words) { return r.reason.find(words) != std::string::npos; }

/// sum w_i (x_i - a_i)^2 + offset, convex, its optimum within the bounds.
NonlinearProgram quadratic(int n, double offset = 1) {
    const VectorXd weight = VectorXd::LinSpaced(n, 1, 3), at = VectorXd::LinSpaced(n, -0.5, 0.6);
    return program_of(
        VectorXd::Zero(n), VectorXd::Constant(n, -1), VectorXd::Constant(n, 1), 0, 0,
        [=](const VectorXd& x) { return vec({offset + (x - at).cwiseAbs2().dot(weight)}); },
        [=](const VectorXd& x) { return MatrixXd(2 * (x - at).cwiseProduct(weight).transpose()); });
}

NonlinearProgram with_gradient(NonlinearProgram p, const std::function<void(VectorXd&)>& change) {
    p.differentiate = [right = p.differentiate, change](const VectorXd& x, Evaluation& s) {
        right(x, s);
        change(s.gradient);
    };
    return p;
}

}  // namespace

TEST(SlopeCheck, AFlippedSignBesideALargeConstantIsFound) {
    for (const double offset : {0.0, 1.0, 1e6}) {
        SCOPED_TRACE(offset);
        const NonlinearProgram p = with_gradient(quadratic(6, offset), [](VectorXd& g) { g = -g; });
        const MinimizeResult r = minimize(p, {});
        EXPECT_TRUE(r.gradient_inconsistent) << r.reason;
        EXPECT_NE(r.stop, MinimizeStop::converged);
        EXPECT_NEAR(r.slope_ratio, -1, 0.05);
        EXPECT_LT(r.slope_expected, 0);
        EXPECT_GT(r.slope_found, 0);
    }
}

TEST(SlopeCheck, StepsConfirmARightGradientAndNoWrongOne) {
    const MinimizeResult right = minimize(quadratic(3), {});
    EXPECT_TRUE(right.gradient_confirmed) << right.reason;
    const auto one_flipped = [](VectorXd& g) { g[1] = -g[1]; };
    EXPECT_FALSE(minimize(with_gradient(quadratic(3), one_flipped), {}).gradient_confirmed);
    MinimizeOptions few;
    few.max_evaluations = 3;
    EXPECT_FALSE(minimize(quadratic(30), few).gradient_confirmed);
}

TEST(SlopeCheck, ALargeConstantDoesNotEndTheSearchEarly) {
    for (const double offset : {0.0, 1e3, 1e6}) {
        const NonlinearProgram p = quadratic(6, offset);
        for (const Method method : {Method::sqp, Method::lbfgs, Method::mma, Method::cobyla}) {
            SCOPED_TRACE(std::string(method_facts(method).name) + " " + std::to_string(offset));
            MinimizeOptions how;
            how.method = method;
            how.max_evaluations = 400;
            const MinimizeResult r = minimize(p, how);
            EXPECT_EQ(r.stop, MinimizeStop::converged) << r.reason;
            EXPECT_FALSE(r.gradient_inconsistent) << r.reason;
            EXPECT_LT(r.best.objective - offset, 1e-4);
        }
    }
}

/// All steps confirm such a gradient: only a direction that none has taken can tell.
TEST(SlopeCheck, AGradientThatIsZeroForHalfOfTheVariablesIsFoundByTwoEvaluations) {
    const NonlinearProgram p = with_gradient(quadratic(12), [](VectorXd& g) { g.tail(6).setZero(); });
    std::vector<std::string> events;
    MinimizeOptions how;
    how.on_event = [&](const std::string& words) { events.push_back(words); };
    const MinimizeResult r = minimize(p, how);
    EXPECT_TRUE(r.gradient_inconsistent) << r.reason;
    EXPECT_EQ(r.confirmations, 2);
    EXPECT_TRUE(says(r, "in a direction that no step has taken")) << r.reason;
    EXPECT_EQ(events.back(), "two evaluations in a direction that no step has taken contradict the gradient");
}

/// Long steps along a curved function are far from any rule: what that hides is asked again, along a longer step, and
/// told with its length.
TEST(SlopeCheck, WhatLongStepsHideIsAskedAgain) {
    for (const double slope : {-1.0, 1.0}) {
        const NonlinearProgram p = program_of(
            vec({-1, 0}), vec({-1, -1}), vec({1, 1}), 0, 0,
            [=](const VectorXd& x) { return vec({-2 * x[0] - 0.6 * std::pow(x[0], 3) + slope * x[1]}); },
            [=](const VectorXd& x) {
                return MatrixXd(vec({-2 - 1.8 * x[0] * x[0], 0}).transpose());
            });
        MinimizeOptions how;
        std::vector<std::string> events;
        how.on_event = [&](const std::string& words) { events.push_back(words); };
        const MinimizeResult r = minimize(p, how);
        MinimizeOptions before;
        before.trusts_long_steps = true;
        EXPECT_FALSE(minimize(p, before).gradient_inconsistent) << "else nothing is hidden";
        EXPECT_TRUE(r.gradient_inconsistent) << r.reason;
        EXPECT_EQ(r.confirmations, 4);
        ASSERT_FALSE(events.empty());
        EXPECT_EQ(events.back(), "four evaluations in a direction that no step has taken contradict the gradient");
        EXPECT_EQ(r.slope_where, "in a direction that no step has taken, along a step of length 0.003");
        EXPECT_NEAR(std::abs(r.slope_found), 0.003, 1e-9) << "along that step";
        EXPECT_EQ(r.slope_expected, 0);
        EXPECT_TRUE(says(r, "the objective changes by ") && says(r, " where its gradient says 0")) << r.reason;
        EXPECT_FALSE(says(r, "inf")) << r.reason;
    }
}

TEST(SlopeCheck, AZeroGradientIsFoundAtTheStart) {
    const NonlinearProgram p = with_gradient(quadratic(4), [](VectorXd& g) { g.setZero(); });
    const MinimizeResult r = minimize(p, {});
    EXPECT_TRUE(r.gradient_inconsistent) << r.reason;
    EXPECT_EQ(r.evaluations, 3);
}

TEST(SlopeCheck, AFactorIsToldByTheStepsAlone) {
    for (const double factor : {3.0, 0.3}) {
        SCOPED_TRACE(factor);
        const NonlinearProgram p = with_gradient(quadratic(6), [=](VectorXd& g) { g *= factor; });
        const MinimizeResult r = minimize(p, {});
        EXPECT_TRUE(r.gradient_inconsistent) << r.reason;
        EXPECT_NEAR(r.slope_ratio, 1 / factor, 0.01);
        EXPECT_EQ(r.confirmations, 0) << "what was paid for is enough";
        EXPECT_LT(r.best.objective, 1.001) << "such a search goes on";
    }
}

TEST(SlopeCheck, AtABoundTheCheckGoesInward) {
    // The gradient of the first variable is flipped: it goes to its upper bound, where the values want it lower.
    NonlinearProgram p = with_gradient(quadratic(3), [](VectorXd& g) { g[0] = std::abs(g[0]) > 0 ? -0.3 : 0; });
    p.start = vec({1, 0, 0});
    const MinimizeResult r = minimize(p, {});
    EXPECT_TRUE(r.gradient_inconsistent) << r.reason;
    EXPECT_NE(r.stop, MinimizeStop::converged);
}

TEST(SlopeCheck, StepsInAllDirectionsNeedNoFurtherEvaluation) {
    const MinimizeResult r = minimize(hock_schittkowski_71().program, {});
    EXPECT_EQ(r.stop, MinimizeStop::converged) << r.reason;
    EXPECT_EQ(minimize(quadratic(1), {}).confirmations, 0);
}

TEST(SlopeCheck, ARightGradientIsConfirmedByNoMoreThanTwo) {
    for (const int n : {2, 6, 20, 60}) {
        SCOPED_TRACE(n);
        const MinimizeResult r = minimize(quadratic(n), {});
        EXPECT_EQ(r.stop, MinimizeStop::converged) << r.reason;
        EXPECT_LE(r.confirmations, 2);
    }
}

/// At the least of a convex function with kinks the gradient is that of one side.
TEST(SlopeCheck, AKinkIsNoWrongGradient) {
    for (const int n : {1, 3, 8}) {
        SCOPED_TRACE(n);
        const NonlinearProgram p = program_of(
            VectorXd::Constant(n, 0.4), VectorXd::Constant(n, -1), VectorXd::Constant(n, 1), 0, 0,
            [](const VectorXd& x) { return vec({1 + x.cwiseAbs().sum()}); },
            [](const VectorXd& x) {
                MatrixXd g(1, x.size());
                for (Eigen::Index j = 0; j < x.size(); ++j) g(0, j) = x[j] < 0 ? -1 : 1;
                return g;
            });
        EXPECT_FALSE(minimize(p, {}).gradient_inconsistent);
    }
}

/// Noise of the values is no fault of the gradient.
TEST(SlopeCheck, NoiseIsNoWrongGradient) {
    for (const double size : {1e-9, 1e-7, 1e-5, 1e-3})
        for (unsigned seed = 1; seed <= 10; ++seed) {
            SCOPED_TRACE(std::to_string(size) + " " + std::to_string(seed));
            NonlinearProgram p = quadratic(10);
            p.evaluate = [=, exact = p.evaluate](const VectorXd& x) {
                Evaluation s = exact(x);
                const double wave = std::sin(1e7 * x.sum() + seed) + std::sin(3.3e6 * x[0] - 1.7 * seed);
                s.objective += size * wave;
                return s;
            };
            EXPECT_FALSE(minimize(p, {}).gradient_inconsistent);
        }
}

TEST(SlopeCheck, ABudgetThatEndsAmongContradictionsSaysSo) {
    const NonlinearProgram p = with_gradient(quadratic(6), [](VectorXd& g) { g = -g; });
    MinimizeOptions how;
    how.max_evaluations = 9;
    const MinimizeResult r = minimize(p, how);
    EXPECT_LE(r.evaluations, 9);
    EXPECT_TRUE(r.gradient_inconsistent) << r.reason;
}

/// Runs of before end as they did.
TEST(SlopeCheck, TheMeaningOfBeforeIsKept) {
    MinimizeOptions before;
    before.is_relative_to_objective = true;
    const NonlinearProgram p = with_gradient(quadratic(6, 1e8), [](VectorXd& g) { g = -g; });
    const MinimizeResult r = minimize(p, before);
    EXPECT_EQ(r.stop, MinimizeStop::converged) << r.reason;
    EXPECT_EQ(r.confirmations, 0);
}
