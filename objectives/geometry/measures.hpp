#pragma once
#include "core/primo/shell.hpp"
#include "objectives/quantity/quantity.hpp"

/// Built-in measures of the surface, each with exact vertex sensitivities.
namespace strake {

/// Enclosed volume, 1/6 sum (a - o) . (b - a) x (c - a), length cubed; o is any fixed point (in the plane, for a half
/// model). Positive at the start for either orientation of the triangles; dJ/dv is n x 3. The surface must be closed,
/// or closed together with `symmetry` (boundary edges with both ends within 1e-6 diagonals of the plane), which gives
/// the volume of the half.
/// @throws InvalidInput naming the first open or misoriented edge and where it is, or when the volume is zero.
/// `evaluate` fails with kind `undefined` on a surface that is not finite.
Quantity volume(const TriMesh& start, const std::optional<SymmetryPlane>& symmetry = {});

/// Surface area, length squared; for a half model, the area of the half. Fails with kind `undefined` when sensitivities
/// are requested and a triangle has zero area (the area is not differentiable there), or when the area is not finite.
Quantity area();

}  // namespace strake
