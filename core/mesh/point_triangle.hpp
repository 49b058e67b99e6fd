#pragma once
#include "core/mesh/closest_point.hpp"

namespace strake {

/// Closest point of triangle t to x, in double precision. Edges are measured from their smaller vertex number, so that
/// the triangles at an edge or vertex get bit-equal distances. Degenerate triangles are their edges.
ClosestPoint closest_point_on_triangle(const TriMesh& mesh, int t, const Eigen::Vector3d& x);

}  // namespace strake
