#pragma once
#include "core/fields/invariance.hpp"
#include "core/mesh/mesh.hpp"
#include "core/mesh/symmetry_plane.hpp"

#include <array>
#include <optional>

namespace strake {

/// Coordinates of a body: axes, and the box of its vertices along them.
struct FieldFrame {
    Eigen::Matrix3d axes;          ///< columns, orthonormal: the axis of the sections first
    Eigen::Vector3d middle, half;  ///< of the box along each; half = 0: the body is flat there
    std::array<char, 3> letter;    ///< the coordinate direction that each axis is nearest to: 'x', 'y', 'z'
    int plane_axis = -1;           ///< which one is normal to the plane of symmetry; -1: there is none

    /// Coordinates in [-1, 1]^3 for points of the body; 0 along axes without extent.
    Eigen::Vector3d local(const Eigen::Vector3d& x) const;
};

/// The same triangles, with the vertices that none of them uses moved onto one that is used: extents are those of the
/// surface, wherever a file keeps its other points.
TriMesh with_loose_vertices_joined(TriMesh mesh);

/// Principal axes of the surface (vertex areas), the one with the largest extent first; the normal of a plane of
/// symmetry is one of them, and first only where its extent is more than 5 % larger than the others: a flying wing that
/// is about as wide as long has its axis from nose to tail. Where two principal moments agree within 1e-3 (round
/// bodies) the coordinate directions decide.
/// @param is_half the surface ends on the plane: moments and extents are those of the whole.
/// @param axis of the sections; else the longest.
/// @param by_extent_alone the normal of the plane is as any other axis: of runs that began so
/// @param kind its axis is one of the frame: that of the sections where the shape is the same around it, with the
/// middle on it and equal extents across; the last one where the shape is extruded along it.
/// @throws InvalidInput: an axis that is neither in the plane nor normal to it, or so to that of `kind`.
FieldFrame field_frame(const TriMesh& rest, const std::optional<SymmetryPlane>& plane, bool is_half,
                       const std::optional<Eigen::Vector3d>& axis, const std::optional<ShapeKind>& kind = {},
                       bool by_extent_alone = false);

}  // namespace strake
