#pragma once
#include "core/mesh/mesh.hpp"

#include <Eigen/Core>
#include <vector>

/// Sums over a few hundred centres x_c at each of millions of points. They have one order, whatever the machine's
/// registers and the number of threads. Cost: centres times points, some 3 ns each (slopes 5).
namespace strake {

/// sum_c weights_c |x - x_c|^3 of each point (n x 3). @param weights a row per centre
Points cubic_sums(const Points& at, const Points& center, const Eigen::Matrix<double, Eigen::Dynamic, 3>& weights);
/// Its transpose: per centre the sum over the points. @param values a row per point; a multiple of 3 columns
Eigen::MatrixXd cubic_sums_transpose(const Points& at, const Points& center, const Eigen::MatrixXd& values);
/// Its derivative at each point: sum_c 3 |x - x_c| weights_c (x - x_c)^T.
std::vector<Eigen::Matrix3d> cubic_slopes(const Points& at, const Points& center,
                                          const Eigen::Matrix<double, Eigen::Dynamic, 3>& weights);

}  // namespace strake
