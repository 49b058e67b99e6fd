#pragma once
#include "core/mesh/mesh.hpp"
#include "core/mesh/symmetry_plane.hpp"

#include <vector>

/// Halves of bodies that are symmetric about a plane. Internal to core/wrap.
namespace strake {

/// Mirror image of a point, and of a displacement.
Eigen::RowVector3d mirrored_point(const SymmetryPlane& plane, const Eigen::RowVector3d& x);
Eigen::RowVector3d mirrored_vector(const SymmetryPlane& plane, const Eigen::RowVector3d& u);

/// Both halves: vertices and triangles of `half`, then their mirror images, turned over.
struct BothHalves {
    TriMesh mesh;
    std::vector<int> image;  ///< per vertex of `mesh`: its mirror image, itself on the plane
};
/// @param near vertices so near to the plane are their own images.
BothHalves with_mirror_image(const TriMesh& half, const SymmetryPlane& plane, double near);

/// The side of a plane that its normal shows to, cut exactly: vertices nearer than `snap` are moved onto the plane,
/// edges across it get a vertex there, triangles in it are left out. The cut stays open, its border lies on the plane.
TriMesh clipped(const TriMesh& mesh, const SymmetryPlane& plane, double snap);

/// Moves the open borders (vertices of edges with one triangle) exactly onto the plane. The farthest that one was off.
double put_borders_on(const SymmetryPlane& plane, TriMesh& mesh);

}  // namespace strake
