#pragma once
#include "objectives/quantity.hpp"

namespace strake {

/// A plane, normal . x = offset.
struct SectionPlane {
    Eigen::Vector3d normal;  ///< any length but zero
    double offset = 0;       ///< along the unit normal
};

/// Radius of a nose or an edge, length: that of the sphere through the vertices of the marked triangles, or, with a
/// plane, of the circle through the places where it cuts their edges (those of the start; they move with the edges).
/// Least squares of |q|^2 - 2 c . q - k (algebraic), r^2 = k + |c|^2, each point alike: exact on spheres and circles.
/// Smooth as long as the points do not come to lie on a plane or line. `evaluate` gives a failure of kind `undefined`
/// where they do, or where an edge turns parallel to the plane.
/// @throws InvalidInput for the same at the start, and for fewer than five points.
Quantity edge_radius(const std::string& name, const TriMesh& start, const std::vector<char>& region,
                     const std::optional<SectionPlane>& plane = {});

}  // namespace strake
