#pragma once
#include "core/mesh/mesh.hpp"

#include <array>
#include <vector>

/// Where parts of a surface pass through each other, and how far a motion opens these joints.
namespace strake {

/// Per triangle the smallest vertex of its part: what shares vertices is one.
std::vector<int> part_of_triangles(const TriMesh& mesh);

/// A point where an edge of one part pierces a triangle of another is a point of both. After a motion each part has
/// carried it elsewhere: the largest distance between the two, 0 without such a point.
/// @param intersecting pairs of triangles at rest, `Intersections::apart`; those of one part are left out
/// @param moved the vertices after the motion, n x 3
double joint_gap(const TriMesh& mesh, const std::vector<std::array<int, 2>>& intersecting, const Points& moved);

}  // namespace strake
