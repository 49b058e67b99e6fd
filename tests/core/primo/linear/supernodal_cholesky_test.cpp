#include "core/primo/linear/supernodal_cholesky.hpp"

#include "core/primo/linear/block_order.hpp"
#include "core/primo/linear/elimination.hpp"

#include <gtest/gtest.h>
#include <Eigen/Cholesky>

#include <cmath>
#include <numeric>

namespace strake {
namespace {

/// Pairs that are joined in a graph without pattern: a path, and chords.
std::vector<std::pair<int, int>> chords(int size, int count) {
    std::vector<std::pair<int, int>> pairs;
    for (int i = 0; i + 1 < size; ++i) pairs.emplace_back(i, i + 1);
    for (int k = 0; k < count; ++k) pairs.emplace_back((31 * k + 5) % size, (k * k + 7 * k + 11) % size);
    return pairs;
}

/// Definite by its diagonal, full blocks.
BlockMatrix matrix(int size, const std::vector<std::pair<int, int>>& pairs) {
    BlockMatrix A = block_matrix(size, pairs);
    for (std::size_t k = 0; k < A.below.size(); ++k)
        for (int r = 0; r < 6; ++r)
            for (int c = 0; c < 6; ++c) A.below[k](r, c) = std::cos(36.0 * static_cast<double>(k) + 6 * r + 1.3 * c);
    std::vector<double> sum(size, 1);
    for (int j = 0; j < size; ++j)
        for (int k = A.begin[j]; k < A.begin[j + 1]; ++k) sum[j] += 6, sum[A.row[k]] += 6;
    for (int j = 0; j < size; ++j) {
        for (int r = 0; r < 6; ++r)
            for (int c = 0; c <= r; ++c) A.diagonal[j](r, c) = A.diagonal[j](c, r) = 0.1 * std::sin(j + 6.0 * r + c);
        A.diagonal[j] += (1 + sum[j]) * Matrix6::Identity();
    }
    return A;
}

Eigen::MatrixXd full(const BlockMatrix& A) {
    Eigen::MatrixXd out = Eigen::MatrixXd::Zero(6 * A.size(), 6 * A.size());
    for (int j = 0; j < A.size(); ++j) {
        out.block<6, 6>(6 * j, 6 * j) = A.diagonal[j];
        for (int k = A.begin[j]; k < A.begin[j + 1]; ++k) {
            out.block<6, 6>(6 * A.row[k], 6 * j) = A.below[k];
            out.block<6, 6>(6 * j, 6 * A.row[k]) = A.below[k].transpose();
        }
    }
    return out;
}

Neighbours neighbours(const BlockMatrix& A) {
    Neighbours out(A.size());
    for (int j = 0; j < A.size(); ++j)
        for (int k = A.begin[j]; k < A.begin[j + 1]; ++k) out[j].push_back(A.row[k]), out[A.row[k]].push_back(j);
    return out;
}

std::vector<int> counted(int size) {
    std::vector<int> order(size);
    std::iota(order.begin(), order.end(), 0);
    return order;
}

}  // namespace

TEST(SupernodalCholesky, SolvesWhatADenseFactorSolves) {
    for (const auto& [size, pairs] : std::vector<std::pair<int, std::vector<std::pair<int, int>>>>{
             {1, {}}, {5, {}}, {9, chords(9, 0)}, {40, chords(40, 60)}, {63, {{0, 62}, {3, 9}, {9, 50}}}}) {
        const BlockMatrix A = matrix(size, pairs);
        for (const std::vector<int>& order : {block_order(A), counted(size)}) {
            SupernodalCholesky cholesky;
            cholesky.analyze(A, order);
            Supernodes factor;
            ASSERT_TRUE(cholesky.factorize(A, factor)) << size;
            Eigen::MatrixXd B(6 * size, 3), X;
            for (int i = 0; i < B.size(); ++i) B.data()[i] = std::sin(1.7 * i);
            factor.solve(B, X);
            const Eigen::MatrixXd exact = full(A).ldlt().solve(B);
            EXPECT_LT((X - exact).norm(), 3e-6 * exact.norm()) << size;  // the factor is held in single precision
        }
    }
}

TEST(SupernodalCholesky, AMatrixThatIsNotDefiniteIsToldAndTheNextOneIsSolved) {
    BlockMatrix A = matrix(30, chords(30, 20));
    SupernodalCholesky cholesky;
    cholesky.analyze(A, block_order(A));
    Supernodes factor;
    for (const int j : {0, 14, 29}) {
        BlockMatrix bad = A;
        bad.diagonal[j](3, 3) = -1;
        EXPECT_FALSE(cholesky.factorize(bad, factor)) << j;
        EXPECT_EQ(factor.size, 0);
    }
    EXPECT_TRUE(cholesky.factorize(A, factor));
    EXPECT_EQ(factor.size, 180);
}

/// The rows of each column by the definition: those that are not zero in the factor of a matrix that cancels nothing.
TEST(SupernodalCholesky, SupernodesHoldTheFillAndJoiningAddsOnlyZeros) {
    const BlockMatrix A = matrix(40, chords(40, 30));
    const std::vector<int> order = postordered(neighbours(A), counted(40));
    std::vector<int> sorted = order;
    std::sort(sorted.begin(), sorted.end());
    EXPECT_EQ(sorted, counted(40));
    std::vector<std::vector<char>> fill(40, std::vector<char>(40, 0));
    const Neighbours of = neighbours(A);
    std::vector<int> place(40);
    for (int k = 0; k < 40; ++k) place[order[k]] = k;
    for (int k = 0; k < 40; ++k)
        for (const int other : of[order[k]]) fill[k][place[other]] = 1;
    for (int k = 0; k < 40; ++k)
        for (int i = k + 1; i < 40; ++i)
            for (int j = k + 1; j < 40; ++j)
                if (i != j && fill[i][k] && fill[j][k]) fill[i][j] = 1;
    long needed = 0, held = 0;
    double zeros = 0;
    int column = 0;
    for (const Supernode& s : supernodes_of(of, order, 6)) {
        EXPECT_EQ(s.first, column);
        zeros += s.zeros;
        for (; column < s.last; ++column) {
            held += s.last - column - 1 + static_cast<long>(s.below.size());
            for (int i = column + 1; i < 40; ++i)
                if (fill[i][column]) {
                    ++needed;
                    EXPECT_TRUE(i < s.last || std::binary_search(s.below.begin(), s.below.end(), i))
                        << i << ", " << column;
                }
        }
    }
    EXPECT_EQ(column, 40);
    EXPECT_EQ(held - needed, static_cast<long>(zeros));
    EXPECT_LT(zeros, 0.2 * static_cast<double>(held));
}

}  // namespace strake
