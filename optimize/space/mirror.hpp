#pragma once
#include "core/patches/hierarchy.hpp"
#include "core/primo/shell.hpp"

/// Mirror symmetry of a surface and of its patches: what ties the two sides of a full model.
namespace strake {

/// The plane of symmetry of the surface through its area centroid: the coordinate direction or principal axis whose
/// reflection brings the triangles' centres closest to the surface; none when that leaves more than 1e-3 of the
/// diagonal (area-weighted root mean square). Of planes without misfit but rounding, the one between left and right: it
/// contains the longest direction, or crosses it where the body is flat like a wing; then the first of y, x, z, and
/// then the axes. An offset within rounding of zero is zero.
std::optional<SymmetryPlane> plane_of_symmetry(const TriMesh& mesh);

/// All such planes, orthogonal to each other: that one first, then those of the least misfit.
std::vector<SymmetryPlane> planes_of_symmetry(const TriMesh& mesh);

/// Mirror image of a vector, I - 2 n n^T.
Eigen::Matrix3d reflection(const SymmetryPlane& plane);

/// Per patch: the patch that its mirror image covers (itself for one that lies across the plane), -1 where no patch
/// agrees with it on 90 % of the area of both. Always an involution.
std::vector<int> mirror_images(const TriMesh& mesh, const PatchLevel& level, const SymmetryPlane& plane);

}  // namespace strake
