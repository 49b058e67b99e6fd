#include "core/primo/block_matrix.hpp"

#include <algorithm>

#include "core/primo/lanes.hpp"

namespace strake {

int BlockMatrix::find(int a, int b) const {
    const int column = std::min(a, b), wanted = std::max(a, b);
    const auto first = row.begin() + begin[column], last = row.begin() + begin[column + 1];
    return static_cast<int>(std::lower_bound(first, last, wanted) - row.begin());
}

namespace {

STRAKE_INLINE Loose<Two>& two(double* at) { return loose<Two>(at); }

/// y += A x. Two columns of A at a time: twelve numbers are three registers of four.
STRAKE_INLINE void add_block(const double* A, const double* x, double* y) {
    Four low = {}, middle = {}, high = {};
    for (int pair = 0; pair < 3; ++pair, A += 12, x += 2) {
        low += four(A).lanes * x[0];
        middle += four(A + 4).lanes * Four{x[0], x[0], x[1], x[1]};
        high += four(A + 8).lanes * x[1];
    }
    four(y).lanes += low + __builtin_shufflevector(middle, high, 2, 3, 4, 5);
    two(y + 4).lanes += __builtin_shufflevector(middle, middle, 0, 1) + __builtin_shufflevector(high, high, 2, 3);
}

/// y += A^T x.
STRAKE_INLINE void add_transposed_block(const double* A, const double* x, double* y) {
    const Four first = four(x).lanes, second = {x[4], x[5], x[0], x[1]}, third = four(x + 2).lanes;
    for (int pair = 0; pair < 3; ++pair, A += 12, y += 2) {
        const Four low = four(A).lanes * first, middle = four(A + 4).lanes * second, high = four(A + 8).lanes * third;
        const Two a = __builtin_shufflevector(low, low, 0, 1) + __builtin_shufflevector(low, low, 2, 3) +
                      __builtin_shufflevector(middle, middle, 0, 1);
        const Two b = __builtin_shufflevector(middle, middle, 2, 3) + __builtin_shufflevector(high, high, 0, 1) +
                      __builtin_shufflevector(high, high, 2, 3);
        two(y).lanes += __builtin_shufflevector(a, b, 0, 2) + __builtin_shufflevector(a, b, 1, 3);
    }
}

/// Y += H X for `columns` columns: the matrix is read once for all.
STRAKE_INLINE void add_product(const BlockMatrix& H, const double* X, double* Y, long columns) {
    const long height = 6L * H.size();
    for (int j = 0; j < H.size(); ++j) {
        for (long c = 0; c < columns; ++c)
            add_block(H.diagonal[j].data(), X + c * height + 6L * j, Y + c * height + 6L * j);
        for (int k = H.begin[j]; k < H.begin[j + 1]; ++k) {
            const double* A = H.below[k].data();
            const long at = 6L * j, other = 6L * H.row[k];
            for (long c = 0; c < columns; ++c) {
                add_block(A, X + c * height + at, Y + c * height + other);
                add_transposed_block(A, X + c * height + other, Y + c * height + at);
            }
        }
    }
}

void add_product_here(const BlockMatrix& H, const double* X, double* Y, long columns) {
    run_lanes([&]() __attribute__((always_inline)) { add_product(H, X, Y, columns); });
}

}  // namespace

Eigen::VectorXd BlockMatrix::multiply(const Eigen::VectorXd& x) const {
    Eigen::VectorXd y = Eigen::VectorXd::Zero(x.size());
    add_product_here(*this, x.data(), y.data(), 1);
    return y;
}

Eigen::MatrixXd BlockMatrix::multiply_columns(const Eigen::MatrixXd& X) const {
    Eigen::MatrixXd Y = Eigen::MatrixXd::Zero(X.rows(), X.cols());
    add_product_here(*this, X.data(), Y.data(), X.cols());
    return Y;
}

BlockMatrix block_matrix(int size, const std::vector<std::pair<int, int>>& pairs) {
    std::vector<std::pair<int, int>> places;
    places.reserve(pairs.size());
    for (const auto& [a, b] : pairs)
        if (a != b) places.emplace_back(std::min(a, b), std::max(a, b));
    std::sort(places.begin(), places.end());
    places.erase(std::unique(places.begin(), places.end()), places.end());
    BlockMatrix matrix;
    matrix.begin.assign(size + 1, 0);
    for (const auto& [column, row] : places) {
        ++matrix.begin[column + 1];
        matrix.row.push_back(row);
    }
    for (int j = 0; j < size; ++j) matrix.begin[j + 1] += matrix.begin[j];
    matrix.diagonal.assign(size, Matrix6::Zero());
    matrix.below.assign(places.size(), Matrix6::Zero());
    return matrix;
}

}  // namespace strake
