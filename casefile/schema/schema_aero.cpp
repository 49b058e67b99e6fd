#include "casefile/schema/schema_parts.hpp"

namespace strake {
namespace {

constexpr const char* with_angles = "type=newtonian|friction|projected_area";

std::vector<Key> pressure_keys() {
    return {
        {.path = "quantities.*.mach",
         .type = Type::number,
         .doc = "Mach number. newtonian: required unless cp_max is given; wave_drag: default 1 (normal sections); "
                "friction: default 0 (incompressible).",
         .limits = not_negative,
         .when = "type=newtonian|wave_drag|friction"},
        {.path = "quantities.*.gamma",
         .type = Type::number,
         .doc = "Ratio of specific heats.",
         .fallback = "1.4",
         .limits = {1, 2, true, false},
         .when = "type=newtonian|friction"},
        {.path = "quantities.*.cp_max",
         .type = Type::number,
         .doc = "Pressure coefficient at normal impact. Default: from the Mach number and gamma.",
         .limits = positive,
         .when = "type=newtonian"},
        {.path = "quantities.*.leeward",
         .type = Type::word,
         .doc = "Leeward pressure: zero (free-stream pressure) or prandtl_meyer (expansion).",
         .fallback = "zero",
         .words = {"zero", "prandtl_meyer"},
         .when = "type=newtonian"},
        {.path = "quantities.*.shadows",
         .type = Type::flag,
         .doc = "Whether triangles behind other parts of the body count as leeward.",
         .fallback = "true",
         .when = "type=newtonian"},
    };
}

std::vector<Key> stream_keys() {
    return {
        {.path = "quantities.*.alpha",
         .type = Type::angle,
         .doc = "Angle of attack, positive nose up.",
         .when = with_angles},
        {.path = "quantities.*.alpha", .doc = "The angle of attack is one of `variables`.", .when = with_angles},
        {.path = "quantities.*.alpha.variable", .type = Type::name, .doc = "Its name.", .required = true},
        {.path = "quantities.*.beta",
         .type = Type::angle,
         .doc = "Angle of sideslip, positive for wind from the right.",
         .when = with_angles},
        {.path = "quantities.*.beta", .doc = "The angle of sideslip is one of `variables`.", .when = with_angles},
        {.path = "quantities.*.beta.variable", .type = Type::name, .doc = "Its name.", .required = true},
        {.path = "quantities.*.forward",
         .type = Type::list,
         .doc = "Old name of `axes.downstream`: where the air goes, not where the nose points.",
         .element = Type::number,
         .count = 3,
         .when = "type=newtonian|wave_drag|friction|projected_area"},
        {.path = "quantities.*.up",
         .type = Type::list,
         .doc = "Old name of `axes.up`; its component along the flow has no effect.",
         .element = Type::number,
         .count = 3,
         .when = with_angles},
        {.path = "quantities.*.moment_center",
         .type = Type::list,
         .doc = "Reference point of the moments. Default: the origin.",
         .element = Type::coordinate,
         .count = 3,
         .when = "type=newtonian"},
        {.path = "quantities.*.reference_area",
         .type = Type::number,
         .doc = "Reference area of the force coefficients.",
         .fallback = "1",
         .limits = positive,
         .when = "type=newtonian|wave_drag|friction"},
        {.path = "quantities.*.reference_length",
         .type = Type::number,
         .doc = "Reference length of the moment coefficients.",
         .fallback = "1",
         .limits = positive,
         .when = "type=newtonian"},
    };
}

std::vector<Key> drag_keys() {
    return {
        {.path = "quantities.*.stations",
         .type = Type::integer,
         .doc = "Number of interior sections.",
         .fallback = "40",
         .limits = {4, 400, false, false},
         .when = "type=wave_drag|section_areas"},
        {.path = "quantities.*.angles",
         .type = Type::integer,
         .doc = "Number of roll angles of the cutting planes over a full turn, above Mach 1.",
         .fallback = "8",
         .limits = {1, 360, false, false},
         .when = "type=wave_drag"},
        {.path = "quantities.*.base",
         .type = Type::name,
         .doc = "Region of a blunt base; the body is continued downstream of it as a cylinder.",
         .when = "type=wave_drag"},
        {.path = "quantities.*.beside",
         .type = Type::file,
         .doc = "A closed surface that stays where it is, apart from the body: wings, nacelles, stores. Its areas are "
                "added to those of the surface.",
         .when = "type=wave_drag"},
        {.path = "quantities.*.reynolds",
         .type = Type::number,
         .doc = "Reynolds number per unit length of the surface.",
         .required = true,
         .limits = positive,
         .when = "type=friction"},
        {.path = "quantities.*.boundary_layer",
         .type = Type::word,
         .doc = "State of the boundary layer.",
         .fallback = "turbulent",
         .words = {"laminar", "turbulent"},
         .when = "type=friction"},
        {.path = "quantities.*.wall_temperature",
         .type = Type::number,
         .doc = "Wall temperature relative to the free stream. Default: adiabatic wall.",
         .limits = positive,
         .when = "type=friction"},
        {.path = "quantities.*.temperature",
         .type = Type::number,
         .doc = "Free-stream temperature in kelvin, for the viscosity.",
         .fallback = "216.65",
         .limits = positive,
         .when = "type=friction"},
    };
}

}  // namespace

std::vector<Key> aero_keys() { return in_order({pressure_keys(), stream_keys(), drag_keys()}); }

}  // namespace strake
