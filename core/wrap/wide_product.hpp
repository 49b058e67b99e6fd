#pragma once
#include <Eigen/Core>

namespace strake {

/// A^T B of two tall matrices. Sums have one order, whatever the machine's registers and the number of threads.
/// @pre as many rows; at least 4 columns of A; the columns of B a multiple of 3.
Eigen::MatrixXd wide_product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

}  // namespace strake
