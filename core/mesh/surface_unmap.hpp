#pragma once
#include "core/mesh/surface_map.hpp"

/// Inverse of a `SurfaceMap`: the rest positions of moved points.
namespace strake {

struct Unmapped {
    Points points;         ///< P x 3, at rest
    double residual = 0;   ///< largest distance between `moved` and the map of `points`, length
    int num_unsolved = 0;  ///< points with a distance above `unmap_tolerance`
    int worst = -1;        ///< the point with the residual
    int rounds = 0;
};
constexpr double unmap_tolerance = 1e-10;  ///< in diagonals of the surface

/// Solves p + u(p) = `moved` for each point by Broyden's method (J. Numer. Math. 19, 1965) starting from the map of the
/// deformed surface, which is exact on it. Vertices of the deformed surface return exactly to the vertices at rest.
/// Where the map folds space, no point or another one may be found; see `num_unsolved`.
/// @param vertices n x 3 of the deformed surface. @throws as SurfaceMap.
Unmapped unmap(const TriMesh& rest, const Points& vertices, const Points& moved, const SurfaceMapOptions& options = {});

}  // namespace strake
