#include "core/wrap/wide_product.hpp"

#include "core/parallel.hpp"
#include "core/primo/linear/lanes.hpp"

#include <algorithm>

namespace strake {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr int tall = 4, broad = 3;  ///< columns of A and of B whose products are summed at once, in twelve registers
constexpr int rows_at_once = 512;   ///< of their columns that stay in the first cache
constexpr int columns_at_once = 16;
constexpr int ahead = 256;  ///< rows that are fetched before they are needed

/// Adds to sums(0..3, 0..2) what rows of four columns at `a` and of three at `b` make. Not unrolled the sums would be
/// in memory: five times the time.
STRAKE_INLINE void add_products(const double* a, Index a_stride, const double* b, Index b_stride, Index rows,
                                double* sums, Index sums_stride) {
    Four all[tall][broad] = {};
    Index r = 0;
    for (; r + 4 <= rows; r += 4) {
        Four of_b[broad];
#pragma GCC unroll 4
        for (int j = 0; j < broad; ++j) of_b[j] = four(b + j * b_stride + r).lanes;
#pragma GCC unroll 4
        for (int i = 0; i < tall; ++i) {
            __builtin_prefetch(a + i * a_stride + r + ahead);
            const Four of_a = four(a + i * a_stride + r).lanes;
#pragma GCC unroll 4
            for (int j = 0; j < broad; ++j) all[i][j] += of_a * of_b[j];
        }
    }
    for (int i = 0; i < tall; ++i)
        for (int j = 0; j < broad; ++j) {
            double rest = 0;
            for (Index k = r; k < rows; ++k) rest += a[i * a_stride + k] * b[j * b_stride + k];
            sums[j * sums_stride + i] += sum(all[i][j]) + rest;
        }
}

/// Rows of A^T B: those of four columns of A from `first` on.
STRAKE_INLINE void add_rows(const MatrixXd& a, const MatrixXd& b, Index first, MatrixXd& product) {
    for (Index from = 0; from < a.rows(); from += rows_at_once) {
        const Index rows = std::min<Index>(rows_at_once, a.rows() - from);
        for (Index j = 0; j < b.cols(); j += broad)
            add_products(a.data() + first * a.outerStride() + from, a.outerStride(),
                         b.data() + j * b.outerStride() + from, b.outerStride(), rows,
                         product.data() + j * product.outerStride() + first, product.outerStride());
    }
}

}  // namespace

MatrixXd wide_product(const MatrixXd& a, const MatrixXd& b) {
    MatrixXd product = MatrixXd::Zero(a.cols(), b.cols());
    for_blocks(static_cast<int>(a.cols() / tall), columns_at_once / tall, [&](int begin, int end) {
        run_lanes([&]() __attribute__((always_inline)) {
            for (int k = begin; k < end; ++k) add_rows(a, b, tall * static_cast<Index>(k), product);
        });
    });
    for (Index i = a.cols() - a.cols() % tall; i < a.cols(); ++i)  // what is left of fours
        product.row(i).noalias() = a.col(i).transpose() * b;
    return product;
}

}  // namespace strake
