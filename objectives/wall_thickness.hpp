#pragma once
#include "core/mesh/symmetry_plane.hpp"
#include "objectives/quantity.hpp"

namespace strake {

struct WallThickness {
    double sharpness = 60;          ///< p of the norm, in [1, 1000]
    std::vector<char> region = {};  ///< triangles from whose centroids rays start; empty: all
};

/// Thickness t_i along the ray from a triangle's centroid against its normal to the first triangle that it meets (of
/// those without a common corner). name.smooth = (sum t_i^-p)^(-1/p), which lies between min n^(-1/p) and min for n
/// rays: a lower limit on it holds for every ray, at the price of that factor (0.86 for 10 000 rays and p = 60).
/// name.smallest is the minimum itself (tie: the smallest number), with kinks. Rays that meet nothing do not count.
/// The gradient is exact for the triangles that are met; where a ray passes from one to the next across an edge t is
/// continuous, across the rim of a part it jumps. At sharp edges the thickness goes to zero: leave them out by region.
/// With `symmetry` rays start from the half and meet its mirror image, too.
/// Cost: O(n log n). @throws InvalidInput: numbers outside of their limits; no ray meets anything at the start; a
/// surface that is turned inside out.
Quantity wall_thickness(const std::string& name, const TriMesh& start, const WallThickness& what = {},
                        const std::optional<SymmetryPlane>& symmetry = {});

inline const std::vector<std::string> wall_thickness_values{"smooth", "smallest"};

}  // namespace strake
