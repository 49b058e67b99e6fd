#pragma once
#include "objectives/quantity/quantity.hpp"

namespace strake {

/// A plane, normal . x = offset.
struct SectionPlane {
    Eigen::Vector3d normal;  ///< any nonzero length
    double offset = 0;       ///< along the unit normal
};

/// Radius of a nose or an edge, length: of the sphere fitted to the vertices of the marked triangles or, with a plane,
/// of the circle fitted to the points where the plane cuts their edges (chosen at the start; they move with the edges).
/// Algebraic least squares of |q|^2 - 2 c . q - k, r^2 = k + |c|^2, with equal weights: exact on spheres and circles.
/// Smooth unless the points become coplanar (collinear); `evaluate` then fails with kind `undefined`, as it does when
/// an edge becomes parallel to the plane.
/// @throws InvalidInput for the same at the start, and for fewer than five points.
Quantity edge_radius(const std::string& name, const TriMesh& start, const std::vector<char>& region,
                     const std::optional<SectionPlane>& plane = {});

}  // namespace strake
