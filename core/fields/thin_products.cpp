#include "core/fields/thin_products.hpp"

#include "core/parallel.hpp"

#include <algorithm>

namespace strake {
namespace {

constexpr int rows_in_cache = 1024;

}  // namespace

std::vector<std::size_t> used_functions(const Coefficients& c) {
    std::vector<std::size_t> used;
    for (Eigen::Index f = 0; f < c.rows(); ++f)
        if (!c.row(f).isZero(0)) used.push_back(static_cast<std::size_t>(f));
    return used;
}

// Eigen would copy all values first.
Points thin_product(const Eigen::MatrixXd& values, const Coefficients& c) {
    Points sum = Points::Zero(values.rows(), 3);
    const std::vector<std::size_t> used = used_functions(c);
    for_blocks(static_cast<int>(values.rows()), rows_in_cache, [&](int begin, int end) {
        const Eigen::Index m = end - begin;
        Eigen::Matrix<double, Eigen::Dynamic, 3> part = Eigen::Matrix<double, Eigen::Dynamic, 3>::Zero(m, 3);
        for (const std::size_t f : used) {
            const auto column = values.col(static_cast<Eigen::Index>(f)).segment(begin, m);
            for (int k = 0; k < 3; ++k) part.col(k) += c(static_cast<Eigen::Index>(f), k) * column;
        }
        sum.middleRows(begin, m) = part;
    });
    return sum;
}

/// A few blocks of rows at a time: what each adds is added in their order.
Coefficients thin_transposed_product(const Eigen::MatrixXd& values, const Points& x) {
    constexpr int blocks_a_time = 64;
    Coefficients sum = Coefficients::Zero(values.cols(), 3);
    std::vector<Coefficients> parts(blocks_a_time, sum);
    const auto rows = static_cast<int>(values.rows());
    for (int first = 0; first < rows; first += blocks_a_time * rows_in_cache) {
        const int count = std::min(rows - first, blocks_a_time * rows_in_cache);
        for_blocks(count, rows_in_cache, [&](int begin, int end) {
            const Eigen::Matrix<double, Eigen::Dynamic, 3> part = x.middleRows(first + begin, end - begin);
            Coefficients& own = parts[static_cast<std::size_t>(begin / rows_in_cache)];
            for (Eigen::Index f = 0; f < values.cols(); ++f)
                for (int k = 0; k < 3; ++k)
                    own(f, k) = values.col(f).segment(first + begin, end - begin).dot(part.col(k));
        });
        for (int b = 0; b * rows_in_cache < count; ++b) sum += parts[static_cast<std::size_t>(b)];
    }
    return sum;
}

}  // namespace strake
