#include "core/wrap/radial_sums.hpp"

#include "core/parallel.hpp"
#include "derivatives.hpp"

#include <gtest/gtest.h>
#include <cmath>

using namespace strake;

namespace {

using Weights = Eigen::Matrix<double, Eigen::Dynamic, 3>;

/// Points of no even number, centres neither.
struct Sums {
    Points at, center;
    Weights weights;
    explicit Sums(Eigen::Index points = 1003, Eigen::Index centers = 41) {
        const Eigen::VectorXd all = random_vector(static_cast<int>(3 * (points + 2 * centers)), 5);
        at = Eigen::Map<const Points>(all.data(), points, 3);
        center = Eigen::Map<const Points>(all.data() + 3 * points, centers, 3);
        weights = Eigen::Map<const Points>(all.data() + 3 * (points + centers), centers, 3);
    }
    Eigen::RowVector3d value(const Eigen::RowVector3d& x) const {
        Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
        for (Eigen::Index c = 0; c < center.rows(); ++c)
            sum += std::pow((x - center.row(c)).norm(), 3) * weights.row(c);
        return sum;
    }
};

}  // namespace

TEST(RadialSums, AreThoseOfTheFormula) {
    for (const Eigen::Index points : {1, 3, 4, 127, 128, 129, 1003}) {
        const Sums sums(points);
        const Points values = cubic_sums(sums.at, sums.center, sums.weights);
        ASSERT_EQ(values.rows(), points);
        for (Eigen::Index p = 0; p < points; ++p)
            EXPECT_LT((values.row(p) - sums.value(sums.at.row(p))).norm(), 1e-13 * 41 * 8) << points << ' ' << p;
    }
    const Sums sums;
    EXPECT_GT((cubic_sums(sums.at, sums.center, 1.001 * sums.weights).row(7) - sums.value(sums.at.row(7))).norm(),
              1e-6);
    EXPECT_TRUE(cubic_sums(sums.at, sums.center, Weights::Zero(41, 3)).isZero(0));
}

TEST(RadialSums, TransposeAndSlopesAreExact) {
    const Sums sums(40000);  // several parts of the transposed sum
    const Eigen::MatrixXd g = Sums(40000, 7).at.array().sin().matrix() * Eigen::MatrixXd::Random(3, 6);
    const Points values = cubic_sums(sums.at, sums.center, sums.weights);
    const Eigen::MatrixXd back = cubic_sums_transpose(sums.at, sums.center, g);
    ASSERT_EQ(back.rows(), 41);
    for (const int first : {0, 3}) {
        const double forward = values.cwiseProduct(g.middleCols<3>(first)).sum(),
                     again = back.middleCols<3>(first).cwiseProduct(sums.weights).sum();
        EXPECT_LT(std::abs(forward - again), 1e-12 * values.norm() * g.norm());
    }
    const Eigen::RowVector3d h = 1e-5 * Eigen::RowVector3d(0.3, -0.5, 0.8);
    const std::vector<Eigen::Matrix3d> slopes = cubic_slopes(sums.at, sums.center, sums.weights);
    for (Eigen::Index p = 0; p < 40000; p += 4001) {
        const Eigen::RowVector3d x = sums.at.row(p), moved = 0.5 * (sums.value(x + h) - sums.value(x - h));
        EXPECT_LT((slopes[static_cast<std::size_t>(p)] * h.transpose() - moved.transpose()).norm(), 1e-12);
        EXPECT_GT((slopes[static_cast<std::size_t>(p)].transpose() * h.transpose() - moved.transpose()).norm(), 1e-8);
    }
}

TEST(RadialSums, HaveTheSameBitsWithTwoThreads) {
    const Sums sums(40000);
    set_num_threads(1);
    const Points values = cubic_sums(sums.at, sums.center, sums.weights);
    const Eigen::MatrixXd back = cubic_sums_transpose(sums.at, sums.center, values);
    const std::vector<Eigen::Matrix3d> slopes = cubic_slopes(sums.at, sums.center, sums.weights);
    set_num_threads(2);
    EXPECT_EQ(values, cubic_sums(sums.at, sums.center, sums.weights));
    EXPECT_EQ(back, cubic_sums_transpose(sums.at, sums.center, values));
    EXPECT_EQ(slopes, cubic_slopes(sums.at, sums.center, sums.weights));
    set_num_threads(0);
}
