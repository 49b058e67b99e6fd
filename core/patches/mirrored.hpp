#pragma once
#include "core/mesh/symmetry_plane.hpp"
#include "core/patches/hierarchy.hpp"

namespace strake {

/// The levels of `tree` with patches that come in mirror images, or are their own: a triangle and its image (the
/// triangle nearest to the mirrored centroid) are in patches that are images of each other, at every level.
///
/// What lies on the side to which the normal of the plane points is kept and mirrored to the other side. A patch is its
/// own image where it lies across the plane and 70 % of it are met by its image; else it ends at the plane. What
/// reaches across by less than a third of its area goes to its neighbours. Nested as before and, where `tree` is,
/// edge-connected: where the triangulation is not its own image, triangles that come apart from the rest of their patch
/// join the nearest one. Cost: O(m log m) a level.
PatchHierarchy mirrored(const PatchHierarchy& tree, const TriMesh& mesh, const Adjacency& adjacent,
                        const SymmetryPlane& plane);

}  // namespace strake
