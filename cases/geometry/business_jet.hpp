#pragma once
#include "core/mesh/mesh.hpp"

/// A business jet of this project's own design as it comes out of a converter: fuselage, wing, T-tail, pylons and
/// engines, each triangulated by itself in long cells, cut with each other and joined. Slivers line the cuts, needles
/// and caps are spread over the rest.
namespace strake::example {

/// Closed surface in one piece, about 20 long, x downstream from the nose, y to the right, z up; normals point outward.
/// Sharp trailing edges; triangles of aspect ratios up to thousands.
/// @param triangles wanted, 5 000 to 1 000 000; met within 15 %. @throws InvalidInput outside of it.
TriMesh business_jet(int triangles);

}  // namespace strake::example
