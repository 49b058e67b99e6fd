#pragma once
#include "core/mesh/symmetry_plane.hpp"
#include "objectives/quantity/quantity.hpp"

/// Curvature energies of the surface.
namespace strake {

/// Willmore energy int H^2 dA, H the mean curvature; dimensionless, 4 pi for every sphere:
///   W = sum over vertices |g_k|^2 / (4 a_k),   g_k = dA/dv_k,   a_k a third of the areas of the triangles at k
/// (g_k / a_k is twice H times the normal, by the cotangent formula). Boundary vertices do not count. `region`: only
/// vertices with all triangles marked; empty: all. With `symmetry`: half the energy of the whole body; vertices in the
/// plane count with the part of g_k in the plane. The discretization error is O(edge^2) on even triangles and O(1) on
/// uneven ones; gradients are exact.
/// @throws InvalidInput for a triangle of area zero, or when no vertex is left.
Quantity bending_energy(const std::string& name, const TriMesh& start, const std::vector<char>& region = {},
                        const std::optional<SymmetryPlane>& symmetry = {});

/// Fairness relative to the start: int |Laplacian of the displacement|^2 dA over the start surface, dimensionless:
///   sum_k |(L d)_k|^2 / a_k,   L the cotangent matrix of the start, d the displacements
/// Zero for every translation (and every affine motion of a flat part), large for short waves: keeps the bumps of the
/// start and adds none. Quadratic in the vertices. Boundary vertices, regions and symmetry as above.
Quantity fairness(const std::string& name, const TriMesh& start, const std::vector<char>& region = {},
                  const std::optional<SymmetryPlane>& symmetry = {});

}  // namespace strake
