#include "casefile/schema/quantity_types.hpp"
#include "casefile/schema/schema_parts.hpp"

namespace strake {

std::vector<Key> quantity_keys() {
    return {
        {.path = "quantities",
         .doc = "Quantities of interest. The built-in volume and area need no entry.",
         .may_be_empty = true},
        {.path = "quantities.*", .doc = "Exactly one of type (built in), command or plugin (programs), expression."},
        {.path = "quantities.*.type",
         .type = Type::word,
         .doc = "Built-in quantity; docs/objectives.md describes them.",
         .words = quantity_type_words()},
        {.path = "quantities.*.expression",
         .type = Type::text,
         .doc = "Formula of other quantities, of formulas above it and of `variables`; docs/objectives.md has the "
                "syntax."},
        {.path = "quantities.*.file",
         .type = Type::file,
         .doc = "target_shape: the target surface; measured_points: rows x,y,z[,weight]; clearance: the closed surface "
                "to keep clear of.",
         .required = true,
         .when = "type=target_shape|measured_points|clearance"},
        {.path = "quantities.*.match",
         .type = Type::word,
         .doc = "same: vertex by vertex on the same triangulation; closest: to the closest point of any triangulation.",
         .fallback = "closest",
         .words = {"same", "closest"},
         .when = "type=target_shape"},
        {.path = "quantities.*.at",
         .type = Type::file,
         .doc = "Measurement lines, rows x,y,z,dx,dy,dz[,target]: a point, a direction and, for fits, the target "
                "thickness.",
         .required = true,
         .when = "type=thickness"},
        {.path = "quantities.*.values",
         .type = Type::word,
         .doc = "each: one value per line, named quantity.1, quantity.2 and so on; smallest: only the minimum, named "
                "like the quantity.",
         .fallback = "each",
         .words = {"each", "smallest"},
         .when = "type=thickness"},
        {.path = "quantities.*.plane",
         .doc = "The cutting plane or plane of symmetry. edge_radius without it fits a sphere in place of a circle.",
         .when = "type=section_area|edge_radius|symmetry_error"},
        {.path = "quantities.*.plane.normal",
         .type = Type::list,
         .doc = "Normal of the plane; its length has no effect.",
         .required = true,
         .element = Type::number,
         .count = 3},
        {.path = "quantities.*.plane.at",
         .type = Type::coordinate,
         .doc = "Distance of the plane from the origin along the unit normal.",
         .required = true},
        {.path = "quantities.*.target",
         .type = Type::number,
         .doc = "Target area for fits, in the square of the surface's unit.",
         .limits = positive,
         .when = "type=section_area"},
    };
}

}  // namespace strake
