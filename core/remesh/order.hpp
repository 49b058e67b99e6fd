#pragma once
#include "core/mesh/mesh.hpp"

/// Internal to core/remesh.
namespace strake {

/// The mesh without triangles that repeat a corner and without unused vertices, numbered along a space-filling curve:
/// neighbours in space are neighbours in memory. @pre indices in range, coordinates finite.
TriMesh in_order_of_space(const TriMesh& mesh);

}  // namespace strake
