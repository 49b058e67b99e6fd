#include "optimize/least_squares/robust.hpp"

#include "derivatives.hpp"

#include <gtest/gtest.h>

using namespace strake;

namespace {

constexpr Loss all[] = {Loss::none, Loss::huber, Loss::cauchy, Loss::soft_l1};

/// Residuals r = A v of `points` points of `width` rows; weights fall.
Residuals linear(const Eigen::VectorXd& v, int width, double size) {
    Residuals r;
    const int rows = 12;
    Eigen::MatrixXd A(rows, v.size());
    for (int i = 0; i < rows; ++i) A.row(i) = size * random_vector(v.size(), 20 + i).transpose();
    r.r = A * v;
    r.dr_dv = A.sparseView();
    r.width = width;
    r.weight = Eigen::VectorXd::LinSpaced(rows / width, 1, 0.1);
    return r;
}

}  // namespace

TEST(Robust, LossesAreTheirFormulas) {
    const double a = 0.5, s = 4;
    EXPECT_EQ(robust_loss(Loss::none, a, s)[0], s);
    EXPECT_NEAR(robust_loss(Loss::huber, a, s)[0], 2 * a * 2 - a * a, 1e-14);
    EXPECT_NEAR(robust_loss(Loss::cauchy, a, s)[0], a * a * std::log(1 + s / (a * a)), 1e-14);
    EXPECT_NEAR(robust_loss(Loss::soft_l1, a, s)[0], 2 * a * a * (std::sqrt(1 + s / (a * a)) - 1), 1e-14);
    for (const Loss loss : all) EXPECT_NEAR(robust_loss(loss, a, 1e-10)[0], 1e-10, 1e-18);
}

TEST(Robust, SumOfSquaresIsTheSumOfTheLoss) {
    for (const Loss loss : all)
        for (const int width : {1, 3}) {
            const Residuals r = linear(random_vector(6, 2), width, 1);
            double sum = 0;
            for (Eigen::Index i = 0; i < r.weight.size(); ++i)
                sum +=
                    r.weight[i] * robust_loss(loss, 0.7, r.r.segment(i * width, width).squaredNorm() / r.weight[i])[0];
            EXPECT_NEAR(robust(loss, 0.7, r).r.squaredNorm(), sum, 1e-13 * sum);
        }
}

TEST(Robust, DerivativesAreExactFarAndNear) {
    for (const Loss loss : all)
        for (const int width : {1, 3})
            for (const double size : {1.0, 1e-2}) {
                const Eigen::VectorXd v = random_vector(6, 2), p = random_vector(6, 9);
                const Residuals at = robust(loss, 0.7, linear(v, width, size));
                const double h = 1e-5;
                const Eigen::VectorXd difference = (robust(loss, 0.7, linear(v + h * p, width, size)).r -
                                                    robust(loss, 0.7, linear(v - h * p, width, size)).r) /
                                                   (2 * h);
                const Eigen::VectorXd exact = at.dr_dv * p;
                EXPECT_LT((exact - difference).norm(), 1e-8 * exact.norm());
                if (loss != Loss::none && size == 1) {  // the plain derivative is another: the test can fail
                    EXPECT_GT((linear(v, width, size).dr_dv * p - difference).norm(), 1e-2 * exact.norm());
                }
            }
}

TEST(Robust, AZeroResidualOrWeightIsHarmless) {
    for (const Loss loss : all) {
        Residuals r = linear(Eigen::VectorXd::Zero(6), 1, 1);
        r.weight[3] = 0;
        r = robust(loss, 0.7, r);
        EXPECT_TRUE(r.r.isZero(0));
        EXPECT_TRUE(Eigen::MatrixXd(r.dr_dv).allFinite());
        EXPECT_NEAR(Eigen::MatrixXd(r.dr_dv).norm(),
                    Eigen::MatrixXd(linear(Eigen::VectorXd::Zero(6), 1, 1).dr_dv).norm(), 1e-12);
    }
}
