#pragma once
#include "core/patches/body.hpp"

#include <vector>

namespace strake {

/// Creases that survive remeshing, and the strip beside them.
struct Creases {
    std::vector<char> edge;  ///< per edge: a crease
    std::vector<char> near;  ///< per triangle: its centroid is within the reach of a crease
};

/// Edges of dihedral >= tau in chains at least four times as long as `reach`, and all non-manifold and misoriented
/// edges. The edge's own angle decides, not its vertices': flat refinement preserves it. Triangles within `reach` of a
/// crease seed no region, which closes gaps in a crease shorter than twice the reach.
/// @param tau radians @param reach a length, > 0. Cost: O(m log m).
Creases persistent_creases(const Body& body, double tau, double reach);

}  // namespace strake
