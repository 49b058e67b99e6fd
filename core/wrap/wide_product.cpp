#include "core/wrap/wide_product.hpp"

#include "core/parallel.hpp"
#include "core/wrap/add_products.hpp"

#include <algorithm>

namespace strake {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr int rows_at_once = 512;  ///< of their columns that stay in the first cache
constexpr int columns_at_once = 16;

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
