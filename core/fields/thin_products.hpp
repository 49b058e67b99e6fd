#pragma once
#include "core/mesh/mesh.hpp"

/// Products of the values of many functions (n x functions) with three columns of coefficients, one per coordinate.
/// Bound by memory: each value is read once. Internal to core/fields.
namespace strake {

using Coefficients = Eigen::Matrix<double, Eigen::Dynamic, 3>;  ///< functions x 3

/// Functions with a coefficient that is not 0, ascending.
std::vector<std::size_t> used_functions(const Coefficients& c);

/// values c, n x 3: the same bits for any number of threads.
Points thin_product(const Eigen::MatrixXd& values, const Coefficients& c);
/// values' x, functions x 3; likewise.
Coefficients thin_transposed_product(const Eigen::MatrixXd& values, const Points& x);

}  // namespace strake
