#pragma once
#include "core/fields/wing_coordinates.hpp"
#include "core/planform/wing.hpp"

namespace strake {

/// The wing by its sections at the start, for displacement fields: those of its first side, evenly along the span.
/// @throws InvalidInput: a wing with a winglet, whose planes are not all streamwise; fewer than four sections.
WingLines wing_lines(const TriMesh& start, const Wing& wing);

}  // namespace strake
