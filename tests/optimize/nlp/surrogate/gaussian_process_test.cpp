#include "optimize/nlp/surrogate/gaussian_process.hpp"

#include "core/error.hpp"
#include "optimize/nlp/surrogate/spread.hpp"
#include "programs.hpp"

#include <gtest/gtest.h>
#include <cmath>
#include <functional>
#include <random>

namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

double wavy(const VectorXd& x) { return std::sin(3 * x[0]) + x[0] * x[1] - 0.5 * x[1] * x[1] + 2; }

VectorXd values_of(const MatrixXd& points, const std::function<double(const VectorXd&)>& f) {
    VectorXd values(points.rows());
    for (Eigen::Index i = 0; i < points.rows(); ++i) values[i] = f(points.row(i));
    return values;
}

GaussianProcess wavy_model(const GaussianProcessOptions& options = {}) {
    const MatrixXd points = sobol_points(0, 30, 2);
    return {points, values_of(points, wavy), options};
}

TEST(GaussianProcess, AgreesWithTheFormulaOfTwoPoints) {
    MatrixXd points(2, 1);
    points << 0, 1;
    const VectorXd values = vec({1, 3});
    const GaussianProcess model(points, values, {.trend = Trend::constant});
    EXPECT_EQ(model.trend(), Trend::constant);
    const double l = model.kernel().length[0], g = model.kernel().nugget;
    const auto k = [&](double d) { return std::exp(-0.5 * d * d / (l * l)); };
    // By symmetry beta is the mean, and C^-1 acts on (-1, 1) as 1 / (1 + g - k(1)).
    for (const double x : {-0.7, 0.2, 0.5, 1.0, 2.5}) {
        const double expected = 2 + (k(x - 1) - k(x)) / (1 + g - k(1));
        EXPECT_NEAR(model.mean(VectorXd::Constant(1, x)), expected, 1e-9) << x;
    }
}

TEST(GaussianProcess, InterpolatesAndPredictsASmoothFunction) {
    const GaussianProcess model = wavy_model();
    double worst = 0;
    for (Eigen::Index i = 0; i < 30; ++i) {
        const VectorXd x = model.points().row(i);
        EXPECT_NEAR(model.mean(x), wavy(x), 1e-4);  // the nugget that is left
        EXPECT_LT(std::sqrt(model.variance(x)), 1e-3);
    }
    const MatrixXd others = latin_hypercube(200, 2, 5);
    for (Eigen::Index i = 0; i < 200; ++i)
        worst = std::max(worst, std::abs(model.mean(others.row(i)) - wavy(others.row(i))));
    EXPECT_LT(worst, 5e-3);
    EXPECT_GT(model.predicted_share(), 0.999);
}

/// Trends without and with the squared distance from a point, where they can have it.
std::vector<GaussianProcessOptions> all_trends() {
    std::vector<GaussianProcessOptions> all;
    for (const Trend trend : {Trend::constant, Trend::linear, Trend::quadratic}) {
        all.push_back({.trend = trend});
        if (trend != Trend::quadratic) all.push_back({.trend = trend, .square_about = vec({0.2, 0.7})});
    }
    return all;
}

/// Five points tell the curvature that eight directions share, and none of the slopes across the others.
TEST(GaussianProcess, ACurvatureThatAllDirectionsShareIsKnownFromFewPoints) {
    constexpr int d = 8;
    const VectorXd about = VectorXd::Constant(d, 0.3);
    MatrixXd points = MatrixXd::Zero(5, d);
    points.rowwise() += about.transpose();
    for (int k = 0; k < 4; ++k) points(k + 1, k / 2) += k % 2 == 0 ? 1 : -1;
    VectorXd values(5);
    for (int k = 0; k < 5; ++k) values[k] = 3 + 2 * (points.row(k).transpose() - about).squaredNorm() + points(k, 0);
    const GaussianProcess with(points, values, {.trend = Trend::constant, .square_about = about});
    const GaussianProcess without(points, values, {.trend = Trend::constant});
    VectorXd far = about;
    far[7] += 1;
    EXPECT_NEAR(with.mean(far), 5 + about[0], 0.05);
    EXPECT_GT(std::abs(without.mean(far) - 5 - about[0]), 0.5);  // the check can fail
    EXPECT_NEAR(with.hessian(about).diagonal().mean(), 4, 0.2);
}

/// Two curvatures in unknown shares are known from fewer points than one direction after another would take.
TEST(GaussianProcess, ASecondCurvatureIsKnownFromFewPoints) {
    const Eigen::Index d = 12;
    MatrixXd form = MatrixXd::Zero(d, d);
    for (Eigen::Index j = 0; j < d; ++j) form(j, j) = j % 2 == 0 ? 1 : -1;
    form(0, 3) = form(3, 0) = 0.5;
    const VectorXd about = VectorXd::Constant(d, 0.4), slope = VectorXd::LinSpaced(d, -1, 1);
    const auto f = [&](const VectorXd& x) {
        const VectorXd off = x - about;
        return slope.dot(off) + 3 * off.squaredNorm() - 2 * off.dot(form * off) + 5;
    };
    const MatrixXd points = sobol_points(0, 32, static_cast<int>(d));
    const auto model_with = [&](const MatrixXd& square_form) {
        return GaussianProcess(points, values_of(points, f),
                               {.group = std::vector<int>(12, 0), .square_about = about, .square_form = square_form});
    };
    const auto error_of = [&](const GaussianProcess& model) {
        const MatrixXd others = latin_hypercube(50, static_cast<int>(d), 5);
        double worst = 0;
        for (Eigen::Index i = 0; i < others.rows(); ++i)
            worst = std::max(worst, std::abs(model.mean(others.row(i)) - f(others.row(i))));
        return worst;
    };
    const GaussianProcess both = model_with(form), one = model_with({});
    EXPECT_TRUE(both.has_form());
    EXPECT_LT(error_of(both), 1e-6);
    EXPECT_GT(error_of(one), 1e-2) << "the control";
    const VectorXd x = VectorXd::Constant(d, 0.7);
    EXPECT_LT((both.gradient(x) - (slope + 6 * (x - about) - 4 * form * (x - about))).norm(), 1e-5);
    EXPECT_LT((both.hessian(x) - (6 * MatrixXd::Identity(d, d) - 4 * form)).norm(), 1e-4);
    EXPECT_FALSE(model_with(MatrixXd::Identity(d, d)).has_form()) << "points do not tell it from the first one";
    EXPECT_THROW(both.weights(), InvalidInput);
    EXPECT_THROW(both.factors(0, 0.5), InvalidInput);
    EXPECT_THROW(model_with(MatrixXd::Identity(2, 2)), InvalidInput);
}

TEST(GaussianProcess, DerivativesHaveSecondOrderRemainder) {
    for (const GaussianProcessOptions& options : all_trends()) {
        const Trend trend = options.trend;
        const GaussianProcess model = wavy_model(options);
        ASSERT_EQ(model.trend(), trend);
        const VectorXd x = vec({0.31, 0.62}), p = vec({0.8, -0.5});
        const auto remainder = [&](double h, double factor) {
            return std::abs(model.mean(x + h * p) - model.mean(x) - factor * h * model.gradient(x).dot(p));
        };
        EXPECT_NEAR(std::log10(remainder(1e-2, 1) / remainder(1e-3, 1)), 2, 0.1);
        EXPECT_NEAR(std::log10(remainder(1e-2, 1.1) / remainder(1e-3, 1.1)), 1, 0.2);  // the check can fail
        const auto slope_remainder = [&](double h, double factor) {
            return (model.gradient(x + h * p) - model.gradient(x) - factor * h * model.hessian(x) * p).norm();
        };
        EXPECT_NEAR(std::log10(slope_remainder(1e-2, 1) / slope_remainder(1e-3, 1)), 2, 0.1);
        EXPECT_NEAR(std::log10(slope_remainder(1e-2, 1.1) / slope_remainder(1e-3, 1.1)), 1, 0.2);
    }
}

TEST(GaussianProcess, VarianceGradientIsThatOfTheVariance) {
    MatrixXd points = sobol_points(0, 8, 2);
    for (const GaussianProcessOptions& options : all_trends()) {
        if (options.trend == Trend::quadratic) continue;  // these points are too few for it
        const GaussianProcess model(points, values_of(points, wavy), options);
        const VectorXd x = vec({1.3, 0.9}), p = vec({0.8, 0.5});
        const double scale = model.variance(x);
        ASSERT_GT(scale, 0);
        const auto remainder = [&](double h) {
            return std::abs(model.variance(x + h * p) - scale - h * model.variance_gradient(x).dot(p));
        };
        EXPECT_NEAR(std::log10(remainder(3e-2) / remainder(3e-3)), 2, 0.15);
    }
}

TEST(GaussianProcess, IsASumOfProductsOfFunctionsOfOneCoordinate) {
    for (const GaussianProcessOptions& options : all_trends()) {
        const GaussianProcess model = wavy_model(options);
        const VectorXd x = vec({0.4, 0.9});
        const double sum = model.weights().dot(model.factors(0, x[0]).cwiseProduct(model.factors(1, x[1])));
        EXPECT_NEAR(sum, model.mean(x), 1e-9);
    }
}

TEST(GaussianProcess, LeaveOneOutIsWhatAModelOfTheOthersPredicts) {
    const GaussianProcess model = wavy_model();
    const GaussianProcess::LeaveOneOut left = model.leave_one_out();
    for (const Eigen::Index i : {0, 7, 29}) {
        std::vector<Eigen::Index> others;
        for (Eigen::Index k = 0; k < 30; ++k)
            if (k != i) others.push_back(k);
        const GaussianProcess without = model.with_points(model.points()(others, Eigen::all), model.values()(others));
        const double predicted = without.mean(model.points().row(i));
        EXPECT_NEAR(left.error[i], model.values()[i] - predicted, 1e-5 * (1 + std::abs(left.error[i])));
        // One degree of freedom less in the estimate of s^2 is the only difference.
        const double ratio = without.scale() / model.scale();
        const double here = std::sqrt(without.variance(model.points().row(i)) + std::pow(without.noise(), 2));
        EXPECT_NEAR(left.deviation[i] * ratio, here, 1e-3 * here);
    }
}

TEST(GaussianProcess, FindsNoiseWhereThereIsSome) {
    const MatrixXd points = latin_hypercube(120, 2, 3);
    VectorXd values = values_of(points, wavy);
    std::mt19937 random(4);
    for (double& value : values) {
        double sum = -6;
        for (int k = 0; k < 12; ++k) sum += static_cast<double>(random()) / 4294967296.0;
        value += 0.05 * sum;
    }
    const GaussianProcess model(points, values);
    EXPECT_NEAR(model.noise(), 0.05, 0.015);
    EXPECT_LT(wavy_model().noise(), 1e-3);  // and none where there is none
}

TEST(GaussianProcess, TellsWhichCoordinatesMatter) {
    const MatrixXd points = sobol_points(0, 60, 5);
    const GaussianProcess model(points, values_of(points, wavy));
    const VectorXd& length = model.kernel().length;
    EXPECT_GT(length.tail(3).minCoeff(), 3 * length[0]);
    const GaussianProcess one_scale(points, values_of(points, wavy), {.group = {0, 0, 0, 0, 0}});
    EXPECT_EQ(one_scale.kernel().length.minCoeff(), one_scale.kernel().length.maxCoeff());
    EXPECT_GT(model.predicted_share(), one_scale.predicted_share());
}

TEST(GaussianProcess, IsntDisturbedByUnitsAndOrder) {
    const GaussianProcess model = wavy_model();
    MatrixXd points = model.points();
    points.col(1) *= 1000;
    const GaussianProcess scaled(points, (1e-3 * model.values()).array() - 7);
    const VectorXd x = vec({0.4, 0.6}), y = vec({0.4, 600});
    EXPECT_NEAR((scaled.mean(y) + 7) * 1e3, model.mean(x), 1e-4);
    const GaussianProcess reversed(model.points().colwise().reverse(), model.values().reverse());
    EXPECT_NEAR(reversed.mean(x), model.mean(x), 1e-5);
    const GaussianProcess again = wavy_model();
    EXPECT_EQ(again.mean(x), model.mean(x));  // the same bits
}

TEST(GaussianProcess, EqualPointsConstantValuesAndFewPointsAreNoTrouble) {
    MatrixXd points(3, 1);
    points << 0.5, 0.5, 1;
    const VectorXd x = VectorXd::Constant(1, 0.5);
    const GaussianProcess twice(points, vec({1, 1, 2}));
    EXPECT_NEAR(twice.mean(x), 1, 1e-3);
    const GaussianProcess split(points, vec({1, 3, 2}));
    EXPECT_NEAR(split.mean(x), 2, 1);
    EXPECT_TRUE(std::isfinite(split.variance(x)));
    const GaussianProcess flat(points, VectorXd::Constant(3, 4));
    EXPECT_EQ(flat.scale(), 0);
    EXPECT_NEAR(flat.mean(VectorXd::Constant(1, 9)), 4, 1e-12);
    EXPECT_EQ(flat.predicted_share(), 1);
    const GaussianProcess single(MatrixXd::Zero(1, 4), VectorXd::Constant(1, 2));
    EXPECT_EQ(single.mean(VectorXd::Ones(4)), 2);
    MatrixXd same = MatrixXd::Ones(4, 2);
    const GaussianProcess one_place(same, vec({1, 2, 3, 4}));
    EXPECT_NEAR(one_place.mean(VectorXd::Ones(2)), 2.5, 1e-6);
}

/// A bowl under waves that points on a line see, next to one another, and all others do not.
TEST(GaussianProcess, WavesShorterThanTheSpacingOfItsPointsAreNoise) {
    constexpr int d = 8, n = 24, near = 16, tries = 12;
    const auto f = [&](const VectorXd& x) { return (x.array() - 0.4).square().sum() + 0.2 * std::sin(5 * x.sum()); };
    int noisy = 0, noisy_without = 0;
    for (unsigned seed = 1; seed <= tries; ++seed) {
        MatrixXd points = latin_hypercube(n, d, seed);
        for (int i = 1; i <= near; ++i) points.row(i) = points.row(0).array() + 0.02 * i;  // two waves
        const MatrixXd off = points.rowwise() - points.colwise().mean();
        const double spacing = off.norm() / std::sqrt(n - 1) * std::pow(n, -1.0 / d);
        const auto noise = [&](double min_length) {
            const Kernel start{VectorXd::Constant(d, 0.4 * spacing), 0.01};
            const GaussianProcess model(points, values_of(points, f),
                                        {.group = std::vector<int>(d, 0), .min_length = min_length}, &start);
            EXPECT_GE(model.kernel().length[0], 0.999 * min_length * spacing);
            return model.noise();
        };
        noisy += noise(1.1) > 0.05;
        noisy_without += noise(0) > 0.05;
    }
    EXPECT_GE(noisy, 0.9 * tries);
    EXPECT_LE(noisy_without, 0.1 * tries);
}

/// So few coordinates that many points are near each other: waves that these resolve are none of the noise.
TEST(GaussianProcess, ABoundOfLengthsIsOfSpacings) {
    const MatrixXd points = sobol_points(0, 30, 1);
    const auto f = [](const VectorXd& x) { return std::sin(20 * x[0]); };
    const GaussianProcess model(points, values_of(points, f), {.min_length = 1.1}),
        coarse(points, values_of(points, f), {.min_length = 3});
    EXPECT_GT(model.predicted_share(), 0.99);
    EXPECT_GE(coarse.kernel().length[0], 3 * 0.28 / 30);
}

/// What a search may end with: of the trend's terms nothing but rounding is left.
TEST(GaussianProcess, PointsNextToOneAnotherSayLittleButNoNaN) {
    constexpr int d = 12, n = 4 * d + 2;
    const auto f = [](const VectorXd& x) { return x.squaredNorm() + std::sin(3 * x[0]); };
    for (const Trend trend : {Trend::linear, Trend::quadratic}) {
        const int count = trend == Trend::linear ? n : (d + 1) * (d + 2) + 4;
        const MatrixXd points = sobol_points(0, count, d);
        const GaussianProcess model(points, values_of(points, f), {.trend = trend});
        EXPECT_EQ(model.trend(), trend);
        for (const double size : {1e-6, 1e-8, 1e-10, 1e-12, 1e-15, 0.0}) {
            const MatrixXd near = (size * points).array() + 0.5;
            const GaussianProcess other = model.with_points(near, values_of(near, f));
            const VectorXd middle = VectorXd::Constant(d, 0.5);
            EXPECT_NEAR(other.mean(middle), f(middle), 1e-4) << size;
            EXPECT_TRUE(other.gradient(middle).allFinite() && other.hessian(middle).allFinite()) << size;
            EXPECT_GE(other.variance(middle), 0) << size;
        }
    }
}

TEST(GaussianProcess, RefusesWhatIsNotFiniteOrDoesNotFit) {
    EXPECT_THROW(GaussianProcess(MatrixXd::Zero(2, 1), VectorXd::Zero(3)), InvalidInput);
    EXPECT_THROW(GaussianProcess(MatrixXd(0, 1), VectorXd(0)), InvalidInput);
    EXPECT_THROW(GaussianProcess(MatrixXd::Zero(2, 1), VectorXd::Constant(2, NAN)), InvalidInput);
    EXPECT_THROW(GaussianProcess(MatrixXd::Zero(2, 2), VectorXd::Zero(2), {.group = {0}}), InvalidInput);
    EXPECT_THROW(GaussianProcess(MatrixXd::Zero(2, 2), VectorXd::Zero(2), {.group = {0, 2}}), InvalidInput);
    EXPECT_THROW(GaussianProcess(MatrixXd::Zero(2, 1), VectorXd::Zero(2), {.min_nugget = 0}), InvalidInput);
    for (const double length : {-1.0, 3.1, double(NAN)})
        EXPECT_THROW(GaussianProcess(MatrixXd::Zero(2, 1), VectorXd::Zero(2), {.min_length = length}), InvalidInput);
}

TEST(SpreadPoints, EveryPartOfEveryCoordinateContainsOne) {
    for (const int first : {0, 64, 192}) {
        const MatrixXd points = sobol_points(first, 64, 40);
        for (Eigen::Index j = 0; j < 40; ++j) {
            std::vector<int> in(64, 0);
            for (Eigen::Index i = 0; i < 64; ++i) ++in[static_cast<std::size_t>(points(i, j) * 64)];
            EXPECT_EQ(std::count(in.begin(), in.end(), 1), 64) << "coordinate " << j;
        }
    }
    EXPECT_EQ(sobol_points(5, 3, 7), sobol_points(0, 8, 7).bottomRows(3));
    const MatrixXd lhs = latin_hypercube(50, 9, 1);
    for (Eigen::Index j = 0; j < 9; ++j) {
        std::vector<int> in(50, 0);
        for (Eigen::Index i = 0; i < 50; ++i) ++in[static_cast<std::size_t>(lhs(i, j) * 50)];
        EXPECT_EQ(std::count(in.begin(), in.end(), 1), 50);
    }
    EXPECT_NE(lhs, latin_hypercube(50, 9, 2));
    EXPECT_THROW(sobol_points(0, 1, 0), InvalidInput);
    EXPECT_THROW(sobol_points(0, 1, 1001), InvalidInput);
}

/// Mean of a product over pairs of coordinates: random points err by 1 / sqrt(n).
TEST(SpreadPoints, PairsOfCoordinatesAreEvenToo) {
    constexpr int n = 256, d = 60;
    const MatrixXd points = sobol_points(0, n, d);
    const MatrixXd centred = points.array() - 0.5;
    const MatrixXd products = centred.transpose() * centred / n * 12;
    double square = 0;
    for (int j = 0; j < d; ++j)
        for (int k = 0; k < j; ++k) square += products(j, k) * products(j, k);
    const double rms = std::sqrt(square / (d * (d - 1) / 2));
    EXPECT_LT(rms, 0.5 / std::sqrt(n));
}

}  // namespace
}  // namespace strake
