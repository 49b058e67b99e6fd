#include "casefile/schema/schema_parts.hpp"

namespace strake {

/// quantities.* of the types that depend on the shape alone.
std::vector<Key> geometry_keys() {
    return {
        {.path = "quantities.*.region",
         .type = Type::name,
         .doc = "Region to measure. Default: the whole surface. Required for edge_radius.",
         .when = "type=wall_thickness|bending_energy|fairness|creases|clearance|planarity|edge_radius|displacement"},
        {.path = "quantities.*.direction",
         .type = Type::list,
         .doc = "extent: direction of measurement; section_areas: normal of the sections.",
         .required = true,
         .element = Type::number,
         .count = 3,
         .when = "type=extent|section_areas"},
        {.path = "quantities.*.smoothing",
         .type = Type::length,
         .doc = "Length over which the extremum is smoothed, on the conservative side; 0: exact, but not "
                "differentiable everywhere.",
         .fallback = "0",
         .limits = not_negative,
         .when = "type=extent|clearance"},
        {.path = "quantities.*.side",
         .type = Type::word,
         .doc = "keep_out: the surface stays outside the other one; keep_in: inside.",
         .fallback = "keep_out",
         .words = {"keep_out", "keep_in"},
         .when = "type=clearance"},
        {.path = "quantities.*.angle",
         .type = Type::angle,
         .doc = "Dihedral angle above which an edge of the start shape is a crease.",
         .fallback = "30deg",
         .limits = {0, 180, true, true},
         .when = "type=creases"},
        {.path = "quantities.*.sharpness",
         .type = Type::number,
         .doc = "Exponent of the p-norm that approximates the minimum.",
         .fallback = "60",
         .limits = {1, 1000, false, false},
         .when = "type=wall_thickness"},
    };
}

}  // namespace strake
