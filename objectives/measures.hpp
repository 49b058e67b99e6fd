#pragma once
#include "core/primo/shell.hpp"
#include "objectives/quantity.hpp"

/// Built-in measures of the surface, each with exact vertex sensitivities.
namespace strake {

/// Enclosed volume, 1/6 sum v0 . (v1 x v2), length cubed. The surface must be closed, or closed together with
/// `symmetry` (then the half model's volume, measured from a point of the plane): @throws InvalidInput naming a
/// boundary edge.
Quantity volume(const TriMesh& start, const std::optional<SymmetryPlane>& symmetry = {});

/// Surface area, length squared.
Quantity area();

}  // namespace strake
