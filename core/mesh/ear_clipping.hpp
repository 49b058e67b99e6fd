#pragma once
#include "core/mesh/mesh.hpp"

#include <array>
#include <functional>
#include <vector>

namespace strake {

/// Twice the vector area of a closed polygon (n x 3, n >= 3), seen from its first corner (Newell).
Eigen::Vector3d polygon_area_vector(const Points& polygon);

/// Cuts a polygon into triangles of its own corners, as it looks along `normal` (a unit vector): always the ear of the
/// best shape that holds no other corner, not even on its border. The triangles run as the polygon.
/// @param is_taken diagonals i-j that must not be used; none: all are free.
/// @return n - 2 triangles, in numbers of the polygon's corners; empty where it crosses itself. O(n^2), as a rule.
std::vector<std::array<int, 3>> clip_ears(const Points& polygon, const Eigen::Vector3d& normal,
                                          const std::function<bool(int i, int j)>& is_taken = {});

}  // namespace strake
