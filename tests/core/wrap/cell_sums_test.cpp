#include "core/wrap/cell_sums.hpp"

#include "core/parallel.hpp"
#include "core/wrap/radial_sums.hpp"
#include "derivatives.hpp"

#include <gtest/gtest.h>
#include <cmath>

using namespace strake;

namespace {

/// Points on an ellipsoid whose box has a diagonal of one, centres near it, weights of no order.
struct Ground {
    Points at, center;
    RadialWeights weights;
    explicit Ground(int points, int centers = 500) : at(on_ellipsoid(points, 1)), center(on_ellipsoid(centers, 1.02)) {
        const Eigen::VectorXd all = random_vector(3 * centers, 9);
        weights = Eigen::Map<const Points>(all.data(), centers, 3);
    }
    static Points on_ellipsoid(int count, double scale) {
        Points x(count, 3);
        for (int i = 0; i < count; ++i) {  // a spiral
            const double z = 1 - 2 * (i + 0.5) / count, r = std::sqrt(1 - z * z), turn = 2.399963229728653 * i;
            x.row(i) << scale * 0.4 * r * std::cos(turn), scale * 0.25 * r * std::sin(turn), scale * 0.1 * z;
        }
        return x;
    }
    double total() const { return weights.cwiseAbs().sum(); }
};

}  // namespace

TEST(CellSums, AreThoseCenterByCenterForMuchLess) {
    const Ground g(200000);
    const CellSums cells(g.at, g.center, true), one_by_one(g.at, g.center, false);
    EXPECT_LT(cells.cost(), 0.8 * one_by_one.cost());
    EXPECT_EQ(one_by_one.cost(), 200000.0 * 500);
    const Points exact = cubic_sums(g.at, g.center, g.weights), sums = cells.values(g.weights);
    EXPECT_EQ(one_by_one.values(g.weights), exact);
    EXPECT_LT((sums - exact).cwiseAbs().maxCoeff(), 3e-12 * g.total());
    EXPECT_GT((sums - exact).cwiseAbs().maxCoeff(), 0) << "no boxes were used";
    RadialWeights other = g.weights;
    other(17, 1) += 1e-6 * g.total();
    EXPECT_GT((cells.values(other) - exact).cwiseAbs().maxCoeff(), 3e-12 * g.total()) << "the test can fail";
    const std::vector<Eigen::Matrix3d> slopes = cells.slopes(g.weights),
                                       exact_slopes = cubic_slopes(g.at, g.center, g.weights);
    double farthest = 0;
    for (std::size_t p = 0; p < slopes.size(); ++p)
        farthest = std::max(farthest, (slopes[p] - exact_slopes[p]).cwiseAbs().maxCoeff());
    EXPECT_LT(farthest, 1e-8 * g.total());
    EXPECT_GT(exact_slopes[5].norm(), 1e-4 * g.total());
}

TEST(CellSums, AreForgottenWhereTheyDoNotPayOff) {
    const Ground g(20000, 30);
    const CellSums cells(g.at, g.center, true);
    EXPECT_EQ(cells.cost(), 20000.0 * 30);
    EXPECT_EQ(cells.values(g.weights), cubic_sums(g.at, g.center, g.weights));
    EXPECT_EQ(cells.points(), g.at);
}

TEST(CellSums, TransposeIsExact) {
    const Ground g(150000);
    const CellSums cells(g.at, g.center, true);
    const Eigen::VectorXd all = random_vector(150000 * 6, 4);
    Eigen::MatrixXd values = Eigen::Map<const Eigen::MatrixXd>(all.data(), 150000, 6);
    const Points moved = cells.values(g.weights);
    values.rightCols<3>() = moved - cubic_sums(g.at, g.center, g.weights);  // where the two maps differ
    const Eigen::MatrixXd back = cells.transpose(values), exact = cubic_sums_transpose(g.at, g.center, values);
    ASSERT_EQ(back.rows(), 500);
    EXPECT_LT((back - exact).cwiseAbs().maxCoeff(), 1e-8 * exact.cwiseAbs().maxCoeff());
    for (const int first : {0, 3}) {
        const double forward = moved.cwiseProduct(values.middleCols<3>(first)).sum();
        const auto pulled = [&](const Eigen::MatrixXd& b) {
            return b.middleCols<3>(first).cwiseProduct(g.weights).sum();
        };
        const double size = moved.norm() * values.col(first).norm();
        EXPECT_LT(std::abs(forward - pulled(back)), 1e-15 * size);
        if (first == 3) {
            EXPECT_GT(std::abs(forward - pulled(exact)), 1e-13 * size) << "the transpose of another map";
        }
    }
}

/// Points in a plane, on a line and in one place; few of them; as many centres as points.
TEST(CellSums, DegenerateClouds) {
    for (const double flat : {1e-3, 0.0}) {
        Ground g(150000);
        g.at.col(2) *= flat;
        if (flat == 0) g.at.col(1).setConstant(0.1), g.at.bottomRows(15000).rowwise() = g.at.row(3).eval();
        const CellSums cells(g.at, g.center, true);
        EXPECT_LT(cells.cost(), 0.8 * cells.num_terms()) << flat;
        const Points exact = cubic_sums(g.at, g.center, g.weights);
        EXPECT_LT((cells.values(g.weights) - exact).cwiseAbs().maxCoeff(), 3e-12 * g.total()) << flat;
        const auto slopes = cells.slopes(g.weights), exact_slopes = cubic_slopes(g.at, g.center, g.weights);
        for (std::size_t p = 0; p < slopes.size(); p += 101)
            EXPECT_LT((slopes[p] - exact_slopes[p]).norm(), 1e-7 * g.total());
    }
    const Ground few(5, 5);
    EXPECT_LT(
        (CellSums(few.at, few.center, true).values(few.weights) - cubic_sums(few.at, few.center, few.weights)).norm(),
        1e-15);
}

TEST(CellSums, HaveTheSameBitsWithTwoThreads) {
    const Ground g(150000);
    const CellSums cells(g.at, g.center, true);
    set_num_threads(1);
    const Points values = cells.values(g.weights);
    const Eigen::MatrixXd back = cells.transpose(values);
    const auto slopes = cells.slopes(g.weights);
    set_num_threads(2);
    const CellSums again(g.at, g.center, true);
    EXPECT_EQ(values, again.values(g.weights));
    EXPECT_EQ(back, again.transpose(values));
    EXPECT_EQ(slopes, again.slopes(g.weights));
    set_num_threads(0);
}
