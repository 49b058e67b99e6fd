#pragma once
#include "core/mesh/symmetry_plane.hpp"
#include "core/patches/hierarchy.hpp"

namespace strake {

/// The levels of `tree` made symmetric: every patch has a mirror image or is its own. At every level a triangle and its
/// image (the triangle nearest to the mirrored centroid) are in patches that are images of each other.
///
/// The side of the plane's normal is kept and mirrored to the other side. A patch across the plane is its own image if
/// it overlaps its image by 70 %; else it ends at the plane. A patch with less than a third of its area on the kept
/// side goes to its neighbours. Nested as before, and edge-connected if `tree` is: on an asymmetric triangulation,
/// triangles separated from their patch join the nearest one. Cost: O(m log m) a level.
PatchHierarchy mirrored(const PatchHierarchy& tree, const TriMesh& mesh, const Adjacency& adjacent,
                        const SymmetryPlane& plane);

}  // namespace strake
