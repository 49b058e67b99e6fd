#include "optimize/nlp/program/value_noise.hpp"

#include <gtest/gtest.h>

#include <random>

using namespace strake;
using Eigen::VectorXd;

namespace {

VectorXd equal_places(int count, double h) { return VectorXd::LinSpaced(count, 0, h * (count - 1)); }

/// Uniform noise of this standard deviation, the same on every platform.
struct Noise {
    std::mt19937 random{7};
    double operator()(double deviation) {
        return deviation * std::sqrt(12.0) * (static_cast<double>(random()) / std::mt19937::max() - 0.5);
    }
};

}  // namespace

/// More & Wild's table: gamma_k (D^k f)^2 with gamma_k = (k!)^2 / (2k)!.
TEST(ValueNoise, IsTheDifferenceTableAtEqualDistances) {
    const VectorXd f{{1.0, 1.3, 0.9, 1.1}};
    const double third = f[3] - 3 * f[2] + 3 * f[1] - f[0];
    EXPECT_NEAR(noise_on_line(equal_places(4, 0.1), f), std::abs(third) * 6 / std::sqrt(720.0), 1e-14);
}

TEST(ValueNoise, APolynomialOfLowerDegreeHasNone) {
    const VectorXd t{{0, 0.003, 0.001, 0.009, 0.004}};
    const VectorXd f = 5 + 2 * t.array() - 30 * t.array().square() + 100 * t.array().cube();
    EXPECT_LT(noise_on_line(t, f), 1e-14);
    EXPECT_GT(noise_on_line(t, (f.array() + 1e3 * t.array().pow(4)).matrix()), 1e-14) << "else nothing is shown";
}

TEST(ValueNoise, FindsTheDeviationOfWhatIsAdded) {
    Noise noise;
    for (const double deviation : {1e-9, 1e-5}) {
        double squares = 0;
        constexpr int lines = 400;
        for (int k = 0; k < lines; ++k) {
            const VectorXd t{{0, 0.008, 0.004, 0.002, 0.0009}};
            VectorXd f = 1e3 + (0.1 * t.array()).sin() + 0.01 * t.array().square();
            for (double& value : f) value += noise(deviation);
            squares += std::pow(noise_on_line(t, f), 2);
        }
        EXPECT_NEAR(std::sqrt(squares / lines) / deviation, 1, 0.15);
    }
}

TEST(ValueNoise, IsNotToldByLongStepsOrFewPoints) {
    ValueNoise noise;
    noise.begin(1);
    for (const double t : {1.0, 0.5, 0.25, 0.12, 0.05}) noise.add(t, 1 + std::exp(t));
    EXPECT_EQ(noise.level(), 0);
    noise.add(0.008, 1.01), noise.add(0.004, 1.02);
    EXPECT_EQ(noise.level(), 0);
    noise.add(0.0041, 7);  // next to one that is known
    EXPECT_EQ(noise.level(), 0);
    noise.add(0.002, 0.99);
    EXPECT_GT(noise.level(), 1e-3);
    EXPECT_LT(noise.level(), 0.1);
}

TEST(ValueNoise, ASmoothFunctionHasNone) {
    for (const double bend : {0.1, 1.0, 10.0}) {
        ValueNoise noise;
        noise.begin(std::exp(0.0));
        for (double t = 0.009; t > 1e-4; t *= 0.4) noise.add(t, std::exp(bend * t));
        EXPECT_EQ(noise.level(), 0) << bend;
    }
}

TEST(ValueNoise, TheBestStepHasTheSmallestError) {
    const double noise = 1e-8, curvature = 3;
    const auto error = [&](double h) { return noise * std::sqrt(2.0) / h + curvature * h / 2; };
    const double best = best_difference_step(noise, curvature);
    EXPECT_LT(error(best), 1.1 * error(std::sqrt(2 * std::sqrt(2.0) * noise / curvature)));  // of the error's bound
    EXPECT_GT(error(best / 10), 2 * error(best));
    EXPECT_GT(error(best * 10), 2 * error(best));
}

TEST(ValueNoise, ResolutionIsRoundingOrMore) {
    EXPECT_DOUBLE_EQ(resolution(-1e6, 0), 10 * 2.220446049250313e-16 * 1e6);
    EXPECT_DOUBLE_EQ(resolution(1, 1e-3), 1e-3);
}
