#pragma once
#include "core/mesh/mesh.hpp"

/// A hypersonic lifting body of this project's own design: blunt nose, sharp chines, canopy, flat belly and base, and
/// winglets that grow out of the chines. x downstream from the nose, y to the right, z up; one length unit long times
/// `length`.
namespace strake::example {

struct LiftingBodyShape {
    double length = 8;             ///< nose to base
    double nose_radius = 0.03;     ///< in plan, over the length
    double half_width = 0.30;      ///< of the body at the base, over the length
    double canopy_height = 0.05;   ///< above the deck, over the length
    double winglet_span = 0.19;    ///< along the winglet, over the length
    double winglet_cant_deg = 68;  ///< from the horizontal
};

/// Closed surface, symmetric in y bit for bit, with vertices on y = 0; normals point outward; creases along the chines
/// (aft of the nose) and the rim of the base, which lies in the plane x = length.
///
/// Every cross-section is a camber line, flat inside and bent up to the winglet's cant outside, with a thickness set
/// off on both sides along its normal. Upper and lower side share the chine, and the base closes the last section.
/// @param triangles wanted, 1 500 to 5 000 000; met within 5 %. @throws InvalidInput outside of it.
TriMesh lifting_body(int triangles, const LiftingBodyShape& shape = {});

/// The same family with a slender fuselage and a wing that grows out of it: a winged hypersonic vehicle.
LiftingBodyShape winged_vehicle();

}  // namespace strake::example
