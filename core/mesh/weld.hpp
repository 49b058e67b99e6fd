#pragma once
#include "core/mesh/mesh.hpp"

#include <vector>

namespace strake {

/// Number per point (n x 3) of its class of equal coordinates (0 and -0 are equal), counted in the order of first
/// appearance.
std::vector<int> equal_points(const Points& points);

/// Merges equal vertices, in the order of first appearance; triangles and groups are kept. A triangle may get repeated
/// vertices, which topology() reports.
TriMesh welded(const TriMesh& mesh);

}  // namespace strake
