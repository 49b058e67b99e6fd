#pragma once
#include "objectives/quantity/quantity.hpp"

namespace strake {

/// Extent of the surface along a direction: name.length = name.max - name.min of n . v over the vertices (span, length,
/// a side of the box). With `smoothing` = s > 0 (length) the smooth bounds
///   max: s log sum_v exp(n . v / s),   min: - s log sum_v exp(- n . v / s)
/// which lie outside the exact ones by at most s log(number of vertices). With 0: exact; the gradient is that of the
/// extreme vertex (tie: the smallest number) and jumps when another takes over.
/// @throws InvalidInput: a zero direction; a smoothing that is negative or not finite.
Quantity extent(const std::string& name, const TriMesh& start, const Eigen::Vector3d& direction, double smoothing = 0);

inline const std::vector<std::string> extent_values{"length", "min", "max"};

/// s log sum exp(x_i / s) (s > 0), at most s log(count) above the largest x_i; sets `weight` (may be null) to its
/// derivatives, which sum to one. With s = 0: the largest itself (tie: the first).
double smooth_max(const Eigen::VectorXd& x, double s, Eigen::VectorXd* weight);

}  // namespace strake
