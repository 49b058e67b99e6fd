#include "optimize/nlp/program/failure_border.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

/// What is believed of a border of failures, from points on both sides.
namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd vec2(double a, double b) {
    VectorXd v(2);
    v << a, b;
    return v;
}

double probability(double z_score) { return 0.5 * std::erfc(-z_score / M_SQRT2); }

/// Points of a box around zero, sorted by a plane that zero is 0.05 below.
FailureBorder sorted_points(int n, int count, VectorXd& normal) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(-0.3, 0.3);
    normal = VectorXd::Ones(n).normalized();
    FailureBorder border;
    for (int i = 0; i < count; ++i) {
        const VectorXd x = VectorXd::NullaryExpr(n, [&] { return uniform(random); });
        normal.dot(x) > 0.05 ? border.add_failed(x) : border.add_sound(x);
    }
    return border;
}

TEST(FailureBorder, OneFailureIsNoBorder) {
    FailureBorder border;
    border.add_sound(vec2(-1, 0));
    border.add_failed(vec2(1, 0));
    EXPECT_FALSE(border.classifier(vec2(0, 0), MatrixXd::Identity(2, 2)));
    border.add_failed(vec2(0.5, 0));
    EXPECT_TRUE(border.classifier(vec2(0, 0), MatrixXd::Identity(2, 2)));
}

TEST(FailureBorder, KnowsItsSides) {
    FailureBorder border;
    border.add_sound(vec2(-0.1, 0));
    border.add_failed(vec2(0.2, 0));
    border.add_failed(vec2(0.1, 0));
    const auto classifier = border.classifier(vec2(0, 0), MatrixXd::Identity(2, 2));
    ASSERT_TRUE(classifier);
    EXPECT_GT(probability(classifier->z_score(vec2(0, 0))), 0.9);
    EXPECT_LT(probability(classifier->z_score(vec2(0.1, 0))), 0.1);
    // Beside the line of what is known, less is known.
    const double near = classifier->z_score(vec2(0.02, 0)), beside = classifier->z_score(vec2(0.02, 0.1));
    EXPECT_GT(near, beside);
    EXPECT_NEAR(probability(beside), 0.5, 0.2);
}

/// Planes drawn at random that part the same points: the share of them that leaves a point sound.
TEST(FailureBorder, IsAsSureAsTheShareOfThePlanesThatPartThePoints) {
    const std::vector<VectorXd> sound = {vec2(0, 0), vec2(-0.02, 0.01), vec2(0.004, -0.012)};
    const std::vector<VectorXd> failed = {vec2(0.02, 0.004), vec2(0.012, 0.02)};
    FailureBorder border;
    for (const VectorXd& x : sound) border.add_sound(x);
    for (const VectorXd& x : failed) border.add_failed(x);
    const auto classifier = border.classifier(sound[0], MatrixXd::Identity(2, 2));
    ASSERT_TRUE(classifier);
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    const std::vector<VectorXd> asked = {vec2(0.01, 0), vec2(0, 0.01), vec2(0.005, 0.005), vec2(0.01, -0.02)};
    std::vector<int> below(asked.size(), 0);
    int planes = 0;
    for (int i = 0; i < 200000; ++i) {
        const VectorXd w = VectorXd::NullaryExpr(3, [&] { return normal(random); });
        const auto at = [&](const VectorXd& x) { return w.head(2).dot(x) / classifier->unit + w[2]; };
        bool parts = true;
        for (const VectorXd& x : sound) parts = parts && at(x) < 0;
        for (const VectorXd& x : failed) parts = parts && at(x) > 0;
        if (!parts) continue;
        ++planes;
        for (std::size_t k = 0; k < asked.size(); ++k) below[k] += at(asked[k]) < 0;
    }
    ASSERT_GT(planes, 5000);
    for (std::size_t k = 0; k < asked.size(); ++k)
        EXPECT_NEAR(probability(classifier->z_score(asked[k])), below[k] / static_cast<double>(planes), 0.06) << k;
}

TEST(FailureBorder, ManyPointsTellThePlane) {
    VectorXd normal;
    const FailureBorder border = sorted_points(4, 150, normal);
    const auto classifier = border.classifier(VectorXd::Zero(4), MatrixXd::Identity(4, 4));
    ASSERT_TRUE(classifier);
    const FailureCut cut = classifier->cut(VectorXd::Zero(4), 0);
    EXPECT_NEAR(cut.normal.norm(), 1, 1e-9);
    EXPECT_GT(cut.normal.dot(normal), 0.98);
    EXPECT_NEAR(cut.limit, 0.05, 0.02);
    // A larger z-score keeps further away.
    EXPECT_LT(classifier->cut(VectorXd::Zero(4), 1).limit, cut.limit);
}

TEST(FailureBorder, ASingleFailureAmongSoundPointsIsIgnored) {
    VectorXd normal;
    FailureBorder border = sorted_points(4, 150, normal);
    border.add_failed(-0.1 * normal);
    const auto classifier = border.classifier(VectorXd::Zero(4), MatrixXd::Identity(4, 4));
    ASSERT_TRUE(classifier);
    EXPECT_GT(classifier->cut(VectorXd::Zero(4), 0).normal.dot(normal), 0.98);
}

/// Other units of the variables, and the metric in them: the same belief.
TEST(FailureBorder, DoesNotDependOnTheUnits) {
    const VectorXd scale = vec2(1e3, 1e-2);
    FailureBorder one, other;
    for (const VectorXd& x : {vec2(-0.1, 0.05), vec2(0, -0.1)})
        one.add_sound(x), other.add_sound(scale.cwiseProduct(x));
    for (const VectorXd& x : {vec2(0.1, 0.05), vec2(0.05, 0.2)})
        one.add_failed(x), other.add_failed(scale.cwiseProduct(x));
    const MatrixXd metric = scale.cwiseAbs2().cwiseInverse().asDiagonal();
    const auto a = one.classifier(vec2(0, 0), MatrixXd::Identity(2, 2)), b = other.classifier(vec2(0, 0), metric);
    ASSERT_TRUE(a && b);
    const VectorXd x = vec2(0.03, -0.02);
    EXPECT_NEAR(a->z_score(x), b->z_score(scale.cwiseProduct(x)), 1e-6);
}

}  // namespace
}  // namespace strake
