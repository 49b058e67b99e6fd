#pragma once
#include "core/mesh/mesh.hpp"

/// A waverider of this project's own design, triangulated as structured grids of flow solvers are: cells crowd towards
/// the sharp leading edges, so that triangles are up to 300 times as long as wide (of 80 000, where it narrows to the
/// nose).
namespace strake::example {

struct WaveriderShape {
    double length = 10;
    double half_span = 2.5;  ///< at the base
    double height = 0.9;     ///< of the base, on the plane of symmetry
    double anhedral = 0.35;  ///< how far the leading edges droop, over the half span
    double crowding = 3;     ///< widest over narrowest cell across, in [1, 1e4]
};

/// Closed surface, symmetric in y bit for bit, with vertices on y = 0; normals point outward; x downstream from the
/// pointed nose, z up; base in the plane x = length. Creases along the leading edges and the rim of the base.
/// @param triangles wanted, 1 000 to 5 000 000; met within 5 %. @throws InvalidInput outside of it.
TriMesh waverider(int triangles, const WaveriderShape& shape = {});

}  // namespace strake::example
