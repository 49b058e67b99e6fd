#include "cases/schema_parts.hpp"

namespace strake {

/// quantities.* of the types that are about the shape alone.
std::vector<Key> form_keys() {
    return {
        {.path = "quantities.*.region",
         .type = Type::name,
         .doc = "Region that it is about; without it all of the surface. edge_radius needs it.",
         .when = "type=wall_thickness|bending_energy|fairness|creases|clearance|planarity|edge_radius|displacement"},
        {.path = "quantities.*.direction",
         .type = Type::list,
         .doc = "Along which the extent is measured, or the sections follow each other.",
         .required = true,
         .element = Type::number,
         .count = 3,
         .when = "type=extent|section_areas"},
        {.path = "quantities.*.smoothing",
         .type = Type::length,
         .doc = "Over which the extreme is smoothed, on the safe side; 0: exact, with kinks.",
         .fallback = "0",
         .limits = not_negative,
         .when = "type=extent|clearance"},
        {.path = "quantities.*.side",
         .type = Type::word,
         .doc = "Where the surface has to stay: outside of the other one, or inside.",
         .fallback = "keep_out",
         .words = {"keep_out", "keep_in"},
         .when = "type=clearance"},
        {.path = "quantities.*.angle",
         .type = Type::angle,
         .doc = "From which dihedral on an edge of the start is a crease.",
         .fallback = "30deg",
         .limits = {0, 180, true, true},
         .when = "type=creases"},
        {.path = "quantities.*.sharpness",
         .type = Type::number,
         .doc = "Exponent of the norm that stands for the minimum.",
         .fallback = "60",
         .limits = {1, 1000, false, false},
         .when = "type=wall_thickness"},
    };
}

}  // namespace strake
