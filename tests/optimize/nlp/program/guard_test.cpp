#include "optimize/nlp/program/guard.hpp"

#include "programs.hpp"

#include <gtest/gtest.h>

using namespace strake;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// min x0 with x1 <= 0: objective and violation are the variables.
NonlinearProgram plane() {
    return program_of(
        vec({1e-3, 1}), vec({-10, -10}), vec({10, 10}), 1, 0, [](const VectorXd& x) { return x; },
        [](const VectorXd&) { return MatrixXd::Identity(2, 2); });
}

}  // namespace

/// The start has a small objective and a large violation. By the first penalty nothing is better than it; by the one
/// that the multipliers need later everything is.
TEST(Guard, TheBestMeritFollowsThePenalty) {
    std::vector<double> merits;
    MinimizeOptions options;
    options.on_step = [&](const MinimizeStep& step) { return merits.push_back(step.merit), true; };
    Guard guard(plane(), options);
    Evaluation evaluation;
    ASSERT_TRUE(guard.try_at(vec({1e-3, 1}), false, evaluation));
    EXPECT_DOUBLE_EQ(merits.back(), 1e-3 + 3e-3) << "a first penalty of three times the objective";
    guard.penalty = 10;
    ASSERT_TRUE(guard.try_at(vec({2, 0.5}), false, evaluation));
    EXPECT_DOUBLE_EQ(merits.back(), 7);
    EXPECT_EQ(guard.merit_x, vec({2, 0.5}));
    ASSERT_TRUE(guard.try_at(vec({4, 0}), false, evaluation));
    EXPECT_DOUBLE_EQ(merits.back(), 4);
    guard.penalty = 1;  // which may fall again
    ASSERT_TRUE(guard.try_at(vec({5, 0}), false, evaluation));
    EXPECT_DOUBLE_EQ(merits.back(), 1.001);
    EXPECT_EQ(guard.merit_x, vec({1e-3, 1}));
}

TEST(Guard, APointThatHasJustFailedIsNotPaidAgain) {
    int calls = 0;
    NonlinearProgram program = plane();
    const auto right = program.evaluate;
    program.evaluate = [&](const VectorXd& x) {
        ++calls;
        Evaluation e = right(x);
        if (x[0] > 2) e.failure = "too far";
        return e;
    };
    const MinimizeOptions options;
    Guard guard(program, options);
    Evaluation evaluation;
    const auto fails = [&](const VectorXd& x) {
        const bool failed = !guard.try_at(x, false, evaluation) && guard.cause == StopCause::failure;
        guard.cause = StopCause::none;
        return failed && guard.failed_x == x;
    };
    ASSERT_TRUE(guard.try_at(program.start, false, evaluation));
    EXPECT_TRUE(fails(vec({3, 0})));
    EXPECT_TRUE(fails(vec({3, 0})));
    EXPECT_TRUE(fails(vec({4, 0})));
    EXPECT_TRUE(fails(vec({3, 0})));
    EXPECT_EQ(calls, 3);
    EXPECT_EQ(guard.evaluations, 3);
    EXPECT_EQ(guard.failures, 2);
    ASSERT_TRUE(guard.try_at(vec({2, 0}), false, evaluation));
    EXPECT_TRUE(fails(vec({3, 0}))) << "from a new point the way there is another one";
    EXPECT_EQ(calls, 5);
}
