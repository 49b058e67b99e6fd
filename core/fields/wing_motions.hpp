#pragma once
#include "core/fields/field_functions.hpp"
#include "core/fields/wing_coordinates.hpp"

/// What displacement fields of a wing do, in the order in which they are tried. Internal to core/fields.
namespace strake {

/// The axes of a wing: outboard, downstream, up; with the box of the surface along them.
/// @param is_half the surface ends on the plane: extents are those of the whole.
/// @throws InvalidInput: a plane that is not normal to the span.
FieldFrame wing_frame(const TriMesh& rest, const WingLines& lines, const std::optional<SymmetryPlane>& plane,
                      bool is_half);

/// Motions by functions of a wing's coordinates (numbers as `WingCoordinates` says). Sections are moved up, aft and
/// out, turned and stretched, by amounts that are polynomials along the span; mixed with these, from the start, their
/// shapes: camber.k raises both sides by the function k along the chord, thickness.k parts them by it. Of a wing that
/// keeps its planform only what keeps both edges.
/// @param is_symmetric both sides alike; else first such motions, then those that are opposite.
/// @param motions none given: any
std::vector<FieldCandidate> wing_candidates(const WingCoordinates& wing, bool is_symmetric, bool keeps_planform,
                                            int count, const std::vector<std::string>& motions);

}  // namespace strake
