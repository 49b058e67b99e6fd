#include "optimize/nlp/surrogate/main_effects.hpp"

#include "core/error.hpp"
#include "optimize/nlp/surrogate/spread.hpp"
#include "programs.hpp"

#include <gtest/gtest.h>
#include <cmath>

namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// sin x1 + 7 sin^2 x2 + 0.1 x3^4 sin x1 on [-pi, pi]^3 (Ishigami and Homma 1990).
double ishigami(const VectorXd& x) {
    return std::sin(x[0]) + 7 * std::pow(std::sin(x[1]), 2) + 0.1 * std::pow(x[2], 4) * std::sin(x[0]);
}

/// Its shares: V1 = (1 + b pi^4 / 5)^2 / 2, V2 = a^2 / 8, V3 = 0, V = a^2 / 8 + b pi^4 / 5 + b^2 pi^8 / 18 + 1 / 2.
VectorXd ishigami_shares() {
    const double a = 7, b = 0.1, p4 = std::pow(M_PI, 4);
    const double V = a * a / 8 + b * p4 / 5 + b * b * p4 * p4 / 18 + 0.5;
    return vec({0.5 * std::pow(1 + b * p4 / 5, 2) / V, a * a / 8 / V, 0});
}

MainEffects effects_of_ishigami(int points) {
    const MatrixXd x = M_PI * (2 * sobol_points(0, points, 3).array() - 1);
    VectorXd values(points);
    for (int i = 0; i < points; ++i) values[i] = ishigami(x.row(i));
    return main_effects(GaussianProcess(x, values), VectorXd::Constant(3, -M_PI), VectorXd::Constant(3, M_PI));
}

TEST(MainEffects, AgreeWithIshigamisClosedForm) {
    const MainEffects effects = effects_of_ishigami(200);
    const VectorXd exact = ishigami_shares();
    for (int j = 0; j < 3; ++j) {
        EXPECT_NEAR(effects.share[j], exact[j], 0.02) << "coordinate " << j;
        EXPECT_LT(effects.error[j], 0.02);
    }
    EXPECT_NEAR(effects.deviation, std::sqrt(13.8446), 0.05 * std::sqrt(13.8446));
    for (int q = 0; q < 21; ++q) {  // E[f | x1] = (1 + b pi^4 / 5) sin x1 + a / 2
        const double x = -M_PI + q * 2 * M_PI / 20;
        EXPECT_NEAR(effects.curve(q, 0), (1 + 0.02 * std::pow(M_PI, 4)) * std::sin(x) + 3.5, 0.25);
    }
}

TEST(MainEffects, FewPointsAreSaidToErr) {
    const MainEffects effects = effects_of_ishigami(24);
    const VectorXd off = (effects.share - ishigami_shares()).cwiseAbs();
    EXPECT_GT(effects.error.maxCoeff(), 0.02);
    EXPECT_LT(off.maxCoeff(), 4 * effects.error.maxCoeff());
}

TEST(MainEffects, OfALinearFunctionAreItsSquaredSlopes) {
    const MatrixXd x = sobol_points(0, 40, 4);
    const VectorXd slope = vec({3, -2, 1, 0});
    for (const double mean : {0.0, 1e6}) {
        const GaussianProcess model(x, (x * slope).array() + mean);
        const MainEffects effects = main_effects(model, VectorXd::Zero(4), VectorXd::Ones(4));
        for (int j = 0; j < 4; ++j) EXPECT_NEAR(effects.share[j], slope[j] * slope[j] / 14, 1e-6);
        EXPECT_NEAR(effects.deviation, std::sqrt(14.0 / 12), 1e-6);
        EXPECT_LT(effects.error.maxCoeff(), 1e-6);
    }
}

/// A product of two coordinates has no main effect about its centre: x1 x2 on [-1, 1]^2.
TEST(MainEffects, OfAPureInteractionAreZero) {
    const MatrixXd x = 2 * sobol_points(0, 60, 2).array() - 1;
    const GaussianProcess model(x, x.col(0).cwiseProduct(x.col(1)), {.trend = Trend::quadratic});
    const MainEffects effects = main_effects(model, -VectorXd::Ones(2), VectorXd::Ones(2));
    EXPECT_NEAR(effects.share.maxCoeff(), 0, 1e-5);
    EXPECT_NEAR(effects.deviation, 1.0 / 3, 1e-4);
}

TEST(MainEffects, OfAConstantAreZeroAndBoundsAreChecked) {
    const MatrixXd x = sobol_points(0, 30, 2);
    const GaussianProcess model(x, VectorXd::Constant(30, 5));
    EXPECT_EQ(main_effects(model, VectorXd::Zero(2), VectorXd::Ones(2)).share.maxCoeff(), 0);
    EXPECT_THROW(main_effects(model, VectorXd::Ones(2), VectorXd::Ones(2)), InvalidInput);
    EXPECT_THROW(main_effects(model, VectorXd::Zero(3), VectorXd::Ones(3)), InvalidInput);
}

}  // namespace
}  // namespace strake
