#pragma once
#include "core/mesh/mesh.hpp"

#include <array>
#include <functional>
#include <vector>

namespace strake {

/// Twice the vector area of a closed polygon (n x 3, n >= 3), seen from its first corner (Newell).
Eigen::Vector3d polygon_area_vector(const Points& polygon);

/// Triangulates a polygon seen along `normal` (a unit vector) without new corners: always clips the best-shaped ear
/// that contains no other corner, not even on its border. Triangles keep the polygon's orientation.
/// @param is_taken forbidden diagonals i-j; empty: none.
/// @return n - 2 triangles, in numbers of the polygon's corners; empty if the polygon crosses itself. Typically O(n^2).
std::vector<std::array<int, 3>> clip_ears(const Points& polygon, const Eigen::Vector3d& normal,
                                          const std::function<bool(int i, int j)>& is_taken = {});

}  // namespace strake
