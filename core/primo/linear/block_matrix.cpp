#include "core/primo/linear/block_matrix.hpp"

#include <algorithm>
#include <atomic>

#include "core/parallel.hpp"
#include "core/primo/linear/lanes.hpp"

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

/// Y = H X in the rows from `begin` to `end`, one of the groups, for `columns` columns: the matrix is read once for
/// all, but for the blocks between two groups.
STRAKE_INLINE void product(const BlockMatrix& H, int begin, int end, const double* X, double* Y, long columns) {
    const long height = 6L * H.size();
    for (long c = 0; c < columns; ++c) std::fill(Y + c * height + 6L * begin, Y + c * height + 6L * end, 0.0);
    const int group = begin / BlockMatrix::group;
    for (int q = H.crossing_begin[group]; q < H.crossing_begin[group + 1]; ++q) {
        const auto [k, j] = H.crossing[q];
        for (long c = 0; c < columns; ++c)
            add_block(H.below[k].data(), X + c * height + 6L * j, Y + c * height + 6L * H.row[k]);
    }
    for (int j = begin; j < end; ++j) {
        for (long c = 0; c < columns; ++c)
            add_block(H.diagonal[j].data(), X + c * height + 6L * j, Y + c * height + 6L * j);
        for (int k = H.begin[j]; k < H.begin[j + 1]; ++k) {
            const double* A = H.below[k].data();
            const long at = 6L * j, other = 6L * H.row[k];
            for (long c = 0; c < columns; ++c) {
                if (H.row[k] < end) add_block(A, X + c * height + at, Y + c * height + other);
                add_transposed_block(A, X + c * height + other, Y + c * height + at);
            }
        }
    }
}

void product_here(const BlockMatrix& H, const double* X, double* Y, long columns) {
    for_blocks(H.size(), BlockMatrix::group, [&](int begin, int end) {
        run_lanes([&]() __attribute__((always_inline)) { product(H, begin, end, X, Y, columns); });
    });
}

void list_crossings(BlockMatrix& matrix) {
    const int n = matrix.size(), group = BlockMatrix::group;
    matrix.crossing_begin.assign((n + group - 1) / group + 1, 0);
    const auto for_crossings = [&](const auto& found) {
        for (int j = 0; j < n; ++j)
            for (int k = matrix.begin[j]; k < matrix.begin[j + 1]; ++k)
                if (matrix.row[k] / group != j / group) found(matrix.row[k] / group, k, j);
    };
    for_crossings([&](int to, int, int) { ++matrix.crossing_begin[to + 1]; });
    for (std::size_t g = 1; g < matrix.crossing_begin.size(); ++g)
        matrix.crossing_begin[g] += matrix.crossing_begin[g - 1];
    std::vector<int> next = matrix.crossing_begin;
    matrix.crossing.resize(next.back());
    for_crossings([&](int to, int k, int j) { matrix.crossing[next[to]++] = {k, j}; });
}

}  // namespace

bool BlockMatrix::is_finite() const {
    std::atomic<bool> finite = true;
    for (const auto* blocks : {&diagonal, &below})
        for_blocks(static_cast<int>(blocks->size()), group, [&](int begin, int end) {
            for (int k = begin; k < end && finite; ++k)
                if (!(*blocks)[k].allFinite()) finite = false;
        });
    return finite;
}

Eigen::VectorXd BlockMatrix::multiply(const Eigen::VectorXd& x) const {
    Eigen::VectorXd y(x.size());
    product_here(*this, x.data(), y.data(), 1);
    return y;
}

Eigen::MatrixXd BlockMatrix::multiply_columns(const Eigen::MatrixXd& X) const {
    Eigen::MatrixXd Y(X.rows(), X.cols());
    product_here(*this, X.data(), Y.data(), X.cols());
    return Y;
}

BlockMatrix block_matrix(int size, const std::vector<std::pair<int, int>>& pairs) {
    std::vector<int> begin(size + 1, 0);
    for (const auto& [a, b] : pairs)
        if (a != b) ++begin[std::min(a, b) + 1];
    for (int j = 0; j < size; ++j) begin[j + 1] += begin[j];
    std::vector<int> next(begin.begin(), begin.end() - 1), row(begin[size]);
    for (const auto& [a, b] : pairs)
        if (a != b) row[next[std::min(a, b)]++] = std::max(a, b);
    BlockMatrix matrix;
    matrix.begin.reserve(size + 1);
    matrix.row.reserve(row.size());
    for (int j = 0; j < size; ++j) {
        const auto first = row.begin() + begin[j], last = row.begin() + begin[j + 1];
        std::sort(first, last);
        matrix.row.insert(matrix.row.end(), first, std::unique(first, last));
        matrix.begin.push_back(static_cast<int>(matrix.row.size()));
    }
    matrix.diagonal.assign(size, Matrix6::Zero());
    matrix.below.assign(matrix.row.size(), Matrix6::Zero());
    list_crossings(matrix);
    return matrix;
}

}  // namespace strake
