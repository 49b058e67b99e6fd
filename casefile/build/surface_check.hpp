#pragma once
#include "casefile/build/build_problem.hpp"
#include "casefile/build/regions.hpp"

namespace strake {

struct SurfaceDemands {
    bool any = false;  ///< nothing but triangles and an area
    bool couple_nonmanifold = false;
    bool volume = false;  ///< closed (together with the symmetry plane) and consistently oriented
    std::optional<SymmetryPlane> symmetry;
};

/// Open edges that lie on other open edges: both ends within 1e-5 of the diagonal of the ends of another one. A
/// surface deforms apart there. Edge numbers, ascending.
std::vector<int> cracked_edges(const StartSurface& start);

/// Refuses what cannot be deformed. @throws SurfaceRefused: all that is wrong, where, and what to do.
void check_surface(const std::filesystem::path& file, const StartSurface& start, const SurfaceDemands& demands);

}  // namespace strake
