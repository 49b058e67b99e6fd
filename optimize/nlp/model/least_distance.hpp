#pragma once
#include <Eigen/Core>

/// The point of a polyhedron that is nearest to another one. Internal.
namespace strake {

/// min |w|^2 / 2 + q.w   s.t.  inequality_rows w <= inequality_limits,  equality_rows w = equality_limits.
struct LeastDistance {
    Eigen::VectorXd q;
    Eigen::MatrixXd inequality_rows, equality_rows;
    Eigen::VectorXd inequality_limits, equality_limits;
};

/// The minimum, which is unique. Rows of length 1 are met within 1e-11 of the larger of 1, their limit and the largest
/// |w_i|. Empty: no point meets all rows, or rounding does not let it be found. By the dual active-set method of
/// Goldfarb and Idnani (Mathematical Programming 27, 1983) for a Hessian that is the identity: O(n^2) for each row that
/// becomes or ceases to be active.
Eigen::VectorXd nearest_point(const LeastDistance& problem);

}  // namespace strake
