#pragma once
#include "core/mesh/symmetry_plane.hpp"
#include "objectives/quantity/quantity.hpp"

/// Thickness along rays through the body, everywhere; `thickness.hpp` has that at places that the case names.
namespace strake {

struct WallThickness {
    double sharpness = 60;          ///< exponent p of the norm, in [1, 1000]
    std::vector<char> region = {};  ///< triangles from whose centroids rays start; empty: all
};

/// Thickness t_i along the ray from a triangle's centroid, against its normal, to the first triangle hit (of those
/// without a common corner). name.smooth = (sum t_i^-p)^(-1/p), which lies between min n^(-1/p) and min for n rays: a
/// lower limit on it bounds every ray and is conservative by that factor (0.86 for 10 000 rays and p = 60).
/// name.smallest is the minimum itself (tie: the smallest number), with kinks. Rays without a hit do not count.
/// The gradient is exact for the triangles hit. t is continuous where a ray passes to the next triangle across an edge
/// and jumps across the rim of a part. The thickness goes to zero at sharp edges: exclude them by `region`. With
/// `symmetry`, rays start from the half and hit its mirror image too. Cost: O(n log n). @throws InvalidInput: numbers
/// outside their limits; no hit at the start; an inside-out surface.
Quantity wall_thickness(const std::string& name, const TriMesh& start, const WallThickness& what = {},
                        const std::optional<SymmetryPlane>& symmetry = {});

inline const std::vector<std::string> wall_thickness_values{"smooth", "smallest"};

}  // namespace strake
