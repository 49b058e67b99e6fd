#include "optimize/nlp/sqp/parabola_misfit.hpp"

#include "optimize/nlp/program/methods.hpp"
#include "programs.hpp"

#include <gtest/gtest.h>
#include <cmath>
#include <numbers>

using namespace strake;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double pi = std::numbers::pi;

/// Of the step from `from` to `to`, with these multipliers of the constraints.
double misfit(const NonlinearProgram& program, const VectorXd& from, const VectorXd& to, const VectorXd& multipliers) {
    NonlinearProgram there = program;
    there.start = from;
    const MinimizeOptions options;
    Guard guard(there, options);
    Evaluation evaluation;
    EXPECT_TRUE(guard.try_at(from, true, evaluation));
    const SqpIterate now(guard);
    EXPECT_TRUE(guard.try_at(to, true, evaluation));
    return parabola_misfit(now, evaluation, multipliers, to - from);
}

/// `factor` times x y + y^2 <= 1 under a linear objective; the Lagrangian of any multiplier is a parabola.
NonlinearProgram saddle(double factor) {
    return program_of(
        vec({0, 0}), vec({-2, -2}), vec({2, 2}), 1, 0,
        [=](const VectorXd& x) {
            return VectorXd(factor * vec({x[0] - x[1], x[0] * x[1] + x[1] * x[1] - 1}));
        },
        [=](const VectorXd& x) {
            MatrixXd slopes(2, 2);
            slopes << 1, -1, x[1], x[0] + 2 * x[1];
            return MatrixXd(factor * slopes);
        });
}

/// x^2 and `height` (1 - cos 2 pi x), of one variable.
NonlinearProgram waves(double height, double factor = 1) {
    return program_of(
        vec({1}), vec({-9}), vec({9}), 0, 0,
        [=](const VectorXd& x) { return vec({factor * (x[0] * x[0] + height * (1 - std::cos(2 * pi * x[0])))}); },
        [=](const VectorXd& x) {
            return MatrixXd(vec({factor * (2 * x[0] + 2 * pi * height * std::sin(2 * pi * x[0]))}));
        });
}

}  // namespace

TEST(ParabolaMisfit, IsNothingAlongParabolas) {
    EXPECT_LT(misfit(bowl().program, vec({-0.5, 0.8, -0.9}), vec({0.1, 0.2, 0.7}), VectorXd()), 1e-14);
    for (const double multiplier : {0.0, 0.3, 40.0})  // the constraint is one, too
        EXPECT_LT(misfit(saddle(1), vec({0.5, -0.5}), vec({-1.2, 0.3}), vec({multiplier})), 1e-14) << multiplier;
    EXPECT_LT(misfit(waves(0), vec({1.3}), vec({-0.4}), VectorXd()), 1e-14);
}

/// From 0.25 to 0: the wave falls by h, and its slope there is 2 pi h and 0: -0.0625 - h + 0.125 (0.5 + 2 pi h) over
/// 0.25 (0.5 + 2 pi h).
TEST(ParabolaMisfit, IsThatOfTheTrapezoidalRule) {
    for (const double h : {0.01, 0.1, 1.0}) {
        const double slope = 0.25 * (0.5 + 2 * pi * h), exact = std::abs(-0.0625 - h + 0.5 * slope) / slope;
        EXPECT_NEAR(misfit(waves(h), vec({0.25}), vec({0}), VectorXd()), exact, 1e-14) << h;
        EXPECT_NEAR(misfit(waves(h, 1e6), vec({0.25}), vec({0}), VectorXd()), exact, 1e-14) << "another unit";
        EXPECT_NEAR(misfit(waves(h), vec({0}), vec({0.25}), VectorXd()), exact, 1e-14) << "the other way";
    }
    EXPECT_EQ(misfit(waves(0), vec({0}), vec({0}), VectorXd()), 0) << "no step";
}

/// The search tells of steps across waves, and stops where it is asked to; a bowl has none.
TEST(ParabolaMisfit, ASearchStopsAtWaves) {
    MinimizeOptions options;
    double largest = 0;
    options.on_misfit = [&](double found) { return (largest = std::max(largest, found)) <= 0.2; };
    EXPECT_EQ(minimize(bowl().program, options).stop, MinimizeStop::converged);
    EXPECT_LT(largest, 1e-6);
    NonlinearProgram program = waves(1);
    program.start = vec({3.6});
    const MinimizeResult result = minimize(program, options);
    EXPECT_EQ(result.stop, MinimizeStop::wavy) << result.reason;
    EXPECT_GT(largest, 0.2);
    EXPECT_LT(result.best.objective, program.evaluate(program.start).objective) << "what it had found is kept";
    program.differences = Differences{};
    largest = 0;
    EXPECT_NE(minimize(program, options).stop, MinimizeStop::wavy) << "differences are not looked at";
    EXPECT_EQ(largest, 0);
}
