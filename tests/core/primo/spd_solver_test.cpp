#include "core/primo/spd_solver.hpp"

#include "core/error.hpp"

#include <gtest/gtest.h>

/// What a factorization is trusted with: libraries call a factor of NaN a success and print warnings of their own.
namespace strake {
namespace {

/// Diagonally dominant, a chain of blocks.
BlockMatrix chain(int size) {
    std::vector<std::pair<int, int>> pairs;
    for (int i = 0; i + 1 < size; ++i) pairs.emplace_back(i, i + 1);
    BlockMatrix A = block_matrix(size, pairs);
    for (Matrix6& block : A.diagonal) block = 4 * Matrix6::Identity();
    for (Matrix6& block : A.below) block = -Matrix6::Identity();
    return A;
}

}  // namespace

TEST(SpdSolver, SolvesWhatIsPositiveDefinite) {
    const BlockMatrix A = chain(30);
    SpdSolver solver;
    solver.analyze(A);
    ASSERT_TRUE(solver.factorize(A));
    const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(180, -1, 2);
    const Eigen::VectorXd x = solver.solve(b), left = b - A.multiply(x);
    EXPECT_LT(left.norm(), 1e-6 * b.norm());  // the factor is held in single precision,
    EXPECT_LT((A.multiply(x + solver.solve(left)) - b).norm(), 1e-12 * b.norm());  // which a correction makes up for
}

TEST(SpdSolver, AnIndefiniteMatrixHasNoFactorAndNothingIsPrinted) {
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    SpdSolver solver;
    solver.analyze(chain(30));
    BlockMatrix A = chain(30);
    A.diagonal[17](3, 3) = -1;
    EXPECT_FALSE(solver.factorize(A));
    EXPECT_FALSE(solver.has_factor());
    A.diagonal[17](3, 3) = 4;
    EXPECT_TRUE(solver.factorize(A));  // and the solver is as good as before
    A.diagonal[17].setZero();
    A.below[16].setZero();
    A.below[17].setZero();  // a part that nothing holds
    EXPECT_FALSE(solver.factorize(A));
    EXPECT_EQ(testing::internal::GetCapturedStdout() + testing::internal::GetCapturedStderr(), "");
}

TEST(SpdSolver, WhatIsNotFiniteIsNeverCalledAFactor) {
    for (const double wrong : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
        for (const bool on_diagonal : {true, false}) {
            testing::internal::CaptureStdout();
            testing::internal::CaptureStderr();
            SpdSolver solver;
            BlockMatrix A = chain(30);
            solver.analyze(A);
            (on_diagonal ? A.diagonal[9](2, 2) : A.below[9](2, 2)) = wrong;
            bool factored = false;
            try {
                factored = solver.factorize(A);
            } catch (const SolverError&) {
            }
            EXPECT_FALSE(factored) << wrong << on_diagonal;
            EXPECT_FALSE(solver.has_factor());
            EXPECT_EQ(testing::internal::GetCapturedStdout() + testing::internal::GetCapturedStderr(), "");
        }
}

}  // namespace strake
