#include "optimize/least_squares/least_squares.hpp"

#include "core/error.hpp"
#include "optimize/least_squares/least_squares_watch.hpp"

#include <gtest/gtest.h>
#include <Eigen/QR>
#include <limits>

using namespace strake;
using Eigen::VectorXd;

namespace {

const double not_a_number = std::numeric_limits<double>::quiet_NaN();

/// Rosenbrock's valley, minimum 0 at (1, 1).
bool rosenbrock(const VectorXd& x, VectorXd& r, RowMajorMatrix* J) {
    r = Eigen::Vector2d(10 * (x[1] - x[0] * x[0]), 1 - x[0]);
    if (J) {
        J->resize(2, 2);
        *J << -20 * x[0], 10, -1, 0;
    }
    return true;
}

LeastSquares valley() {
    return {Eigen::Vector2d(-1.2, 1), Eigen::Vector2d(-5, -5), Eigen::Vector2d(5, 5), 2, rosenbrock, {}};
}

double cost(const VectorXd& x) {
    VectorXd r;
    rosenbrock(x, r, nullptr);
    return r.squaredNorm();
}

/// The search that is linked (Ceres, or with STRAKE_GPL off our own), and our own.
struct LeastSquaresBy : testing::TestWithParam<LeastSquaresEnd (*)(LeastSquaresWatch&, double&)> {
    static LeastSquaresResult least_squares(const LeastSquares& problem, const LeastSquaresOptions& options) {
        return least_squares_by(GetParam(), problem, options);
    }
};
INSTANTIATE_TEST_SUITE_P(Searches, LeastSquaresBy, testing::Values(search_least_squares, levenberg_marquardt));

}  // namespace

TEST_P(LeastSquaresBy, FindsTheMinimumAndHoldsBounds) {
    const LeastSquaresResult free = least_squares(valley(), {});
    EXPECT_EQ(free.stop, LeastSquaresStop::converged);
    EXPECT_LT((free.x - Eigen::Vector2d(1, 1)).norm(), 1e-5);
    LeastSquares bounded = valley();
    bounded.upper[0] = 0.5;
    LeastSquaresOptions exact;
    exact.objective_tolerance = exact.step_tolerance = 1e-12;
    const LeastSquaresResult at = least_squares(bounded, exact);
    EXPECT_NEAR(at.x[0], 0.5, 1e-9);
    EXPECT_NEAR(cost(at.x), 0.25, 1e-3);  // Ceres goes slowly along a bound
}

TEST_P(LeastSquaresBy, StepsThatAllFailAreNotConvergence) {
    for (const double bad : {not_a_number, std::numeric_limits<double>::infinity(), 1e300}) {
        LeastSquares p = valley();
        p.evaluate = [&](const VectorXd& x, VectorXd& r, RowMajorMatrix* J) {
            rosenbrock(x, r, J);
            if (x != p.start) r[0] = bad;
            return true;
        };
        const LeastSquaresResult end = least_squares(p, {});
        EXPECT_EQ(end.stop, LeastSquaresStop::no_valid_step) << bad;
        EXPECT_EQ(end.x, p.start);
    }
}

TEST_P(LeastSquaresBy, ARefusedRegionIsWalkedAround) {
    LeastSquares p = valley();
    int refused = 0;
    p.evaluate = [&](const VectorXd& x, VectorXd& r, RowMajorMatrix* J) {
        if ((x - Eigen::Vector2d(-1.2, 1)).norm() > 0.5 && cost(x) > 24) return ++refused, false;
        return rosenbrock(x, r, J);
    };
    LeastSquaresOptions damped;
    damped.radius = 3;
    const LeastSquaresResult end = least_squares(p, damped);
    EXPECT_EQ(end.stop, LeastSquaresStop::converged);
    EXPECT_LT(cost(end.x), 1e-8);
    EXPECT_GT(refused, 0);
}

TEST_P(LeastSquaresBy, NoStartNoJacobianAndWrongSizes) {
    LeastSquares p = valley();
    p.evaluate = [](const VectorXd&, VectorXd&, RowMajorMatrix*) { return false; };
    EXPECT_EQ(least_squares(p, {}).stop, LeastSquaresStop::no_start);
    p.evaluate = [](const VectorXd& x, VectorXd& r, RowMajorMatrix* J) {
        rosenbrock(x, r, J);
        r.conservativeResize(1);
        return true;
    };
    EXPECT_EQ(least_squares(p, {}).stop, LeastSquaresStop::no_start);
    p.evaluate = [](const VectorXd& x, VectorXd& r, RowMajorMatrix* J) {
        rosenbrock(x, r, J);
        if (J) (*J)(0, 0) = not_a_number;
        return true;
    };
    EXPECT_NE(least_squares(p, {}).stop, LeastSquaresStop::converged);
}

TEST_P(LeastSquaresBy, ExceptionsPassThroughAndNothingIsPrinted) {
    testing::internal::CaptureStderr();
    for (const int at : {1, 4}) {
        LeastSquares p = valley();
        int count = 0;
        p.evaluate = [&](const VectorXd& x, VectorXd& r, RowMajorMatrix* J) {
            if (++count == at) throw std::runtime_error("lost");
            return rosenbrock(x, r, J);
        };
        EXPECT_THROW(least_squares(p, {}), std::runtime_error);
        EXPECT_EQ(count, at);
    }
    LeastSquares p = valley();
    p.go_on = [](int) -> bool { throw std::runtime_error("lost"); };
    EXPECT_THROW(least_squares(p, {}), std::runtime_error);
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST_P(LeastSquaresBy, WhatWouldAbortCeresIsRefused) {
    LeastSquares p = valley();
    p.start[0] = not_a_number;
    EXPECT_THROW(least_squares(p, {}), InvalidInput);
    p = valley();
    p.lower[0] = 3;
    EXPECT_THROW(least_squares(p, {}), InvalidInput);
    p = valley();
    p.upper[1] = not_a_number;
    EXPECT_THROW(least_squares(p, {}), InvalidInput);
    p = valley();
    p.num_residuals = 0;
    EXPECT_THROW(least_squares(p, {}), InvalidInput);
    p = valley();
    p.start.resize(0);
    EXPECT_THROW(least_squares(p, {}), InvalidInput);
    p = valley();
    p.upper.resize(1);
    EXPECT_THROW(least_squares(p, {}), InvalidInput);
    for (const LeastSquaresOptions& bad :
         {LeastSquaresOptions{-1, 0, 0, 1, 1}, LeastSquaresOptions{10, -1, 0, 1, 1},
          LeastSquaresOptions{10, not_a_number, 0, 1, 1}, LeastSquaresOptions{10, 0, not_a_number, 1, 1},
          LeastSquaresOptions{10, 0, 0, 0, 1}, LeastSquaresOptions{10, 0, 0, not_a_number, 1},
          LeastSquaresOptions{10, 0, 0, 1, 0}})
        EXPECT_THROW(least_squares(valley(), bad), InvalidInput);
}

TEST_P(LeastSquaresBy, StopsWhenAskedAndAtItsLimit) {
    LeastSquares p = valley();
    p.go_on = [](int iteration) { return iteration < 2; };
    EXPECT_EQ(least_squares(p, {}).stop, LeastSquaresStop::stopped);
    p.go_on = {};
    LeastSquaresOptions few;
    few.max_iterations = 2;
    EXPECT_EQ(least_squares(p, few).stop, LeastSquaresStop::limit);
}

/// Residuals J (x - x*) + c with c orthogonal to the columns: the minimum is known, x* or its projection.
TEST_P(LeastSquaresBy, LinearProblemsEndAtTheirSolutionWithinTheBounds) {
    RowMajorMatrix J(7, 3);
    for (int i = 0; i < 7; ++i)
        for (int j = 0; j < 3; ++j) J(i, j) = std::sin(0.9 * i * (j + 1) + j);
    const Eigen::Vector3d best(0.3, -0.8, 2);
    LeastSquares p{Eigen::Vector3d::Zero(), Eigen::Vector3d::Constant(-5), Eigen::Vector3d::Constant(5), 7, {}, {}};
    p.evaluate = [&](const VectorXd& x, VectorXd& r, RowMajorMatrix* jacobian) {
        r = J * (x - best);
        if (jacobian) *jacobian = J;
        return true;
    };
    LeastSquaresOptions exact;
    exact.objective_tolerance = exact.step_tolerance = 1e-14;
    EXPECT_LT((least_squares(p, exact).x - best).norm(), 1e-9);
    p.upper[2] = 1;  // the others then solve the rest
    const Eigen::Matrix<double, 7, 2> rest = J.leftCols<2>();
    const Eigen::Vector2d others = rest.colPivHouseholderQr().solve(J * best - J.col(2));
    const VectorXd x = least_squares(p, exact).x;
    EXPECT_NEAR(x[2], 1, 1e-12);
    EXPECT_LT((x.head<2>() - others).norm(), 1e-2);  // Ceres goes slowly along a bound
}
