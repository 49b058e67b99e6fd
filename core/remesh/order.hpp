#pragma once
#include "core/mesh/mesh.hpp"

/// Internal to core/remesh.
namespace strake {

/// The mesh without triangles that repeat a corner and without unused vertices, numbered along a curve through space:
/// what is near in space is near in memory, too, whatever order a file has. @pre indices in range, coordinates finite.
TriMesh in_order_of_space(const TriMesh& mesh);

}  // namespace strake
