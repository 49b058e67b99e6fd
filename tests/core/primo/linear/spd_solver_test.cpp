#include "core/primo/linear/spd_solver.hpp"

#include "core/error.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <thread>

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

/// A square grid of blocks: ordering it takes a while.
BlockMatrix grid(int side) {
    std::vector<std::pair<int, int>> pairs;
    for (int i = 0; i < side * side; ++i) {
        if (i % side + 1 < side) pairs.emplace_back(i, i + 1);
        if (i + side < side * side) pairs.emplace_back(i, i + side);
    }
    BlockMatrix A = block_matrix(side * side, pairs);
    for (Matrix6& block : A.diagonal) block = 8 * Matrix6::Identity();
    for (Matrix6& block : A.below) block = -Matrix6::Identity();
    return A;
}

std::atomic<int> terminations{0};
extern "C" void count_termination(int) { ++terminations; }

}  // namespace

// METIS_NodeND takes SIGTERM for itself while it works: the ordering failed, the signal was lost, and the handler that
// it put back was good for one signal only.
TEST(SpdSolver, SignalsDuringTheOrderingReachTheirHandlerAndBreakNothing) {
    const BlockMatrix A = grid(120);
    SpdSolver undisturbed;
    undisturbed.analyze(A);
    struct sigaction ours {
    }, before{}, after{};
    ours.sa_handler = count_termination;
    ours.sa_flags = SA_RESTART;
    ASSERT_EQ(::sigaction(SIGTERM, &ours, &before), 0);
    terminations = 0;
    int sent = 0;
    std::atomic<bool> over{false};
    const pthread_t here = ::pthread_self();
    std::thread sender([&] {
        for (; !over; ++sent) {
            const int seen = terminations;
            ::pthread_kill(here, SIGTERM);
            while (!over && terminations == seen) std::this_thread::yield();
            std::this_thread::sleep_for(std::chrono::microseconds(200));
        }
    });
    while (terminations < 20) {
        SpdSolver solver;
        EXPECT_NO_THROW(solver.analyze(A));
        EXPECT_EQ(solver.num_factor_entries(), undisturbed.num_factor_entries());
    }
    over = true;
    sender.join();
    ASSERT_EQ(::sigaction(SIGTERM, &before, &after), 0);
    EXPECT_EQ(after.sa_handler, count_termination);
    EXPECT_EQ(after.sa_flags & (SA_RESTART | static_cast<int>(SA_RESETHAND)), SA_RESTART);
    EXPECT_EQ(terminations, sent);
}

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

TEST(SpdSolver, AnyNumberOfColumnsOfAnySizeIsSolvedAsOne) {
    BlockMatrix A = chain(41);
    for (std::size_t k = 0; k < A.below.size(); ++k) A.below[k](static_cast<int>(k % 6), 2) -= 0.3;
    SpdSolver solver;
    solver.analyze(A);
    ASSERT_TRUE(solver.factorize(A));
    for (const int columns : {1, 2, 4, 5, 8, 9, 16, 19}) {
        Eigen::MatrixXd B(246, columns);
        for (int c = 0; c < columns; ++c)
            for (int i = 0; i < 246; ++i) B(i, c) = std::pow(10.0, 9 * (c % 7) - 27) * std::sin(1.7 * i + c);
        B.col(columns / 2).setZero();
        const Eigen::MatrixXd X = solver.solve(B), AX = A.multiply_columns(X);
        for (int c = 0; c < columns; ++c) {
            EXPECT_LE((AX.col(c) - B.col(c)).norm(), 1e-5 * B.col(c).norm()) << columns << ", " << c;
            EXPECT_EQ(AX.col(c), A.multiply(X.col(c))) << columns << ", " << c;
        }
    }
}

TEST(SpdSolver, ProductsAreThoseOfTheFullMatrix) {
    BlockMatrix A = chain(7);
    for (std::size_t k = 0; k < A.below.size(); ++k)
        for (int r = 0; r < 6; ++r)
            for (int c = 0; c < 6; ++c) A.below[k](r, c) = std::cos(static_cast<double>(36 * k) + 6 * r + c);
    Eigen::MatrixXd full = Eigen::MatrixXd::Zero(42, 42);
    for (int j = 0; j < 7; ++j) {
        full.block<6, 6>(6 * j, 6 * j) = A.diagonal[j];
        for (int k = A.begin[j]; k < A.begin[j + 1]; ++k) {
            full.block<6, 6>(6 * A.row[k], 6 * j) = A.below[k];
            full.block<6, 6>(6 * j, 6 * A.row[k]) = A.below[k].transpose();
        }
    }
    const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(42, -1, 2);
    EXPECT_LE((A.multiply(x) - full * x).norm(), 1e-14 * (full * x).norm());
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
