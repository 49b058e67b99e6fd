#pragma once
#include "core/fields/displacement_fields.hpp"

/// Motions that a designer thinks in, to ask what variables can make.
namespace strake {

struct TypicalMotion {
    std::string name;
    Points displacement;  ///< n x 3, zero on what is held; largest length 1
};

/// bend, sweep, span, twist, taper, thicken, swell, flatten and bump of the body, along the axis of its sections (the
/// frame of `DisplacementFields`). With s the place along it, r the vector from the middle of the section (a polygon
/// through the means of 16 slices), a, b, c the axes (c across the thinnest extent) and t the distance along the axis
/// from what is held over its maximum (where that holds more than half of the length: the distance from it in space):
///     bend t^2 c,  sweep t b,  span t a,  twist t a x r,  taper -t r,  thicken t^2 r_c c,
///     swell 4 t (1 - t) r,  flatten t (r_b b - r_c c),  bump (1 - d^2 / R^2)^2 n within R = 15 % of the diagonal of
///     the vertex where t is nearest to a half, d the distance from it, n the normal.
/// Where nothing is held: bend and sweep s^2, twist and taper s (s^2 where the axis is normal to the plane of
/// symmetry), thicken s^2, swell 1 - s^2, span s, flatten 1, all without the rigid part. Motions that the plane of
/// symmetry forbids are left out; of a kind of shape it is what of them keeps it, where that is more than a tenth.
/// @throws InvalidInput as `DisplacementFields`.
std::vector<TypicalMotion> typical_motions(const TriMesh& surface, const FieldConditions& conditions,
                                           const std::optional<Eigen::Vector3d>& axis = {});

/// Translations and rotations, those that keep the plane where there is one: 3 or 6 of n x 3.
std::vector<Points> rigid_motions(const TriMesh& rest, const std::optional<SymmetryPlane>& plane);

}  // namespace strake
