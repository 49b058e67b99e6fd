#pragma once
#include "core/mesh/surface_map.hpp"

/// The way back: from where a `SurfaceMap` has moved points to where they were.
namespace strake {

struct Unmapped {
    Points points;         ///< P x 3, where they were
    double residual = 0;   ///< largest distance between `moved` and where the map takes `points`, length
    int num_unsolved = 0;  ///< points for which that is more than `unmap_tolerance`
    int worst = -1;        ///< the point with the residual
    int rounds = 0;
};
constexpr double unmap_tolerance = 1e-10;  ///< in diagonals of the surface

/// Solves p + u(p) = `moved` for each point by Broyden's method (J. Numer. Math. 19, 1965) from what the map about the
/// deformed surface says, which is exact on the surface. Points that are vertices of the deformed surface get the bits
/// of the vertex at rest. Where the map has folded space no point, or another one, may be found; `num_unsolved` tells.
/// @param vertices n x 3 of the deformed surface. @throws as SurfaceMap.
Unmapped unmap(const TriMesh& rest, const Points& vertices, const Points& moved, const SurfaceMapOptions& options = {});

}  // namespace strake
