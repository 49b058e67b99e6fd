#pragma once
#include "core/mesh/mesh.hpp"

namespace strake {

struct ClosestPoint {
    Eigen::Vector3d point;
    int triangle = -1;  ///< tie: the smallest number
    int corner_a = -1,
        corner_b = -1;  ///< local corners of the closest edge (both), vertex (corner_a), or face (neither)
    double distance = 0;
};

/// Closest point of triangle t to x, in double precision. Edges are measured from their smaller vertex number, so that
/// the triangles at an edge or vertex get bit-equal distances. Degenerate triangles are their edges.
ClosestPoint closest_point_on_triangle(const TriMesh& mesh, int t, const Eigen::Vector3d& x);

}  // namespace strake
