#pragma once
#include "core/primo/shell.hpp"
#include "objectives/quantity.hpp"

/// Built-in measures of the surface, each with exact vertex sensitivities.
namespace strake {

/// Enclosed volume, 1/6 sum (a - o) . (b - a) x (c - a), length cubed; o is any fixed point, of the plane for a half
/// model. Positive at the start whichever way the triangles run; dJ/dv is n x 3.
/// The surface must be closed, or closed together with `symmetry` (boundary edges with both ends within 1e-6 of the
/// diagonal of the plane; then it is the half model's volume).
/// @throws InvalidInput naming the first open or misoriented edge and where it is, or when the volume is zero.
/// A surface that is not finite gives a failure of kind `undefined`.
Quantity volume(const TriMesh& start, const std::optional<SymmetryPlane>& symmetry = {});

/// Surface area, length squared; a half model's is that of the half. Failure of kind `undefined` when sensitivities
/// are wanted and a triangle has area zero (the area is not differentiable there), or when it is not finite.
Quantity area();

}  // namespace strake
