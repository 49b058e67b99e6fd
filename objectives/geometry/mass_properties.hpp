#pragma once
#include "core/mesh/symmetry_plane.hpp"
#include "objectives/quantity/quantity.hpp"

namespace strake {

/// Mass properties of the enclosed solid at density one, in this order: name.centroid_x, _y, _z (length); the inertia
/// tensor about the centroid, name.ixx, .iyy, .izz, .ixy, .iyz, .izx (length^5; ixx = int (y^2 + z^2), ixy = - int x
/// y); its principal moments name.principal_1 <= _2 <= _3; and their axes name.axis_1_x ... name.axis_3_z, unit vectors
/// whose largest component at the start is positive.
///   int x x^T = sum V_t/20 (a a^T + b b^T + c c^T + s s^T),  s = a + b + c,  over the cones from a fixed point
/// With `symmetry`: those of the whole body. Kinks: principal moments where two are equal; their axes are undefined
/// there (a failure of kind `undefined` when requested). Cost: one pass over the triangles.
/// @throws InvalidInput for an open surface or one without volume.
Quantity mass_properties(const std::string& name, const TriMesh& start,
                         const std::optional<SymmetryPlane>& symmetry = {});

/// Names of the values, after the dot.
std::vector<std::string> mass_property_values();

}  // namespace strake
