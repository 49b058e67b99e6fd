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

/// Volume of any surface, length cubed: the integral of its winding number. What pierces itself counts as often as it
/// is enclosed, what faces inward counts negatively. Open edges are closed by cones: those that are connected (over
/// vertices) share an apex, the mean of their ends weighted by their lengths at the start. The same as `volume` where
/// that is defined. @throws InvalidInput when the volume is zero at the start.
Quantity closed_volume(const TriMesh& start, const std::optional<SymmetryPlane>& symmetry = {});

/// Surface area, length squared; for a half model, the area of the half. Fails with kind `undefined` when sensitivities
/// are requested and a triangle has zero area (the area is not differentiable there), or when the area is not finite.
/// @param zero_areas triangles of zero area are allowed; their derivative is taken as zero, a subgradient.
Quantity area(bool zero_areas = false);

}  // namespace strake
