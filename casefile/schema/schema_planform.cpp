#include "casefile/schema/schema_parts.hpp"

namespace strake {
namespace {

std::vector<Key> shape_keys() {
    return {
        {.path = "planform",
         .doc = "Wings, and bodies by their length. Values of wings (area, span, aspect_ratio, taper, sweep, dihedral, "
                "mean_chord, box_volume; chord, "
                "twist, thickness_to_chord, camber, leading_edge_radius, trailing_edge_angle, trailing_edge_thickness "
                "at a fraction of the semispan, for example wing.twist@0.37; sweep and dihedral there of the panel "
                "between two stations; thickness at fractions of semispan and "
                "chord, wing.thickness@0.37@0.15; gap and overlap behind another wing, flap.gap@0.37) and of bodies "
                "(length; width, height, camber at a fraction of the "
                "length, for "
                "example fuselage.width@0.5) are quantities: docs/planform.md.",
         .may_be_empty = true},
        {.path = "planform.*", .doc = "A wing (span) or a body (length), by its name."},
        {.path = "planform.*.on",
         .type = Type::text,
         .doc = "Names joined by signs, as in the text of a region: the triangles of the wing or the body. Where those "
                "of a "
                "wing border on others is its root. Default: the whole surface."},
        {.path = "planform.*.span",
         .type = Type::word,
         .doc = "Of a wing: direction of the span, perpendicular to axes.downstream and axes.up.",
         .words = {"x", "y", "z", "+x", "-x", "+y", "-y", "+z", "-z"}},
        {.path = "planform.*.span",
         .type = Type::list,
         .doc = "Any direction; its length has no effect.",
         .element = Type::number,
         .count = 3},
        {.path = "planform.*.length",
         .type = Type::word,
         .doc = "Of a body, in place of span: direction of its length, from nose to tail, perpendicular to axes.up.",
         .words = {"x", "y", "z", "+x", "-x", "+y", "-y", "+z", "-z"}},
        {.path = "planform.*.length",
         .type = Type::list,
         .doc = "Any direction; its length has no effect.",
         .element = Type::number,
         .count = 3},
        {.path = "planform.*.stations",
         .type = Type::word,
         .doc =
             "Where sections are listed. kinks: at root and tip and where the edges change their direction; of a body "
             "at [0, 25%, 50%, 75%, 100%] of its length.",
         .fallback = "kinks",
         .words = {"kinks"}},
        {.path = "planform.*.stations",
         .type = Type::list,
         .doc = "Fractions of the semispan (of a body: of its length), ascending, from 0 at the root (nose) to 1 at "
                "the tip "
                "(tail).",
         .element = Type::fraction},
        {.path = "planform.*.axis",
         .type = Type::text,
         .doc = "Fraction of the chord whose line gives sweep and dihedral, for example 25% chord.",
         .fallback = "25% chord",
         .when = "span"},
        {.path = "planform.*.behind",
         .type = Type::name,
         .doc = "The wing ahead of it, whose trailing edge its gap and overlap are measured from: behind: main for a "
                "flap, behind: slat for a main wing.",
         .when = "span"},
        {.path = "planform.*.keep",
         .type = Type::word,
         .doc =
             "What of the wing loads, strains and displacement fields leave as it is. outline: leading and trailing "
             "edge, and with them chord and twist of all sections, sweep, dihedral and span; they change thickness and "
             "camber. none: nothing. Changes under parameters.planform are made in either case.",
         .fallback = "outline",
         .words = {"outline", "none"},
         .when = "span"},
    };
}

/// What is recorded, and where.
std::vector<Key> value_keys() {
    return {
        {.path = "planform.*.values",
         .type = Type::list,
         .doc = "Values to record in history.csv beside those that objective, constraints and formulas use, for "
                "example [area, twist@0.5].",
         .element = Type::text,
         .may_be_empty = true},
        {.path = "planform.*.grid",
         .doc = "Places of thickness_grid, twist_step_grid and others: a constraint on it is one on the value at each "
                "of them.",
         .fallback = "{}",
         .when = "span"},
        {.path = "planform.*.grid.span",
         .type = Type::list,
         .doc = "Fractions of the semispan.",
         .fallback = "[10%, 30%, 50%, 70%, 90%]",
         .element = Type::fraction},
        {.path = "planform.*.grid.chord",
         .type = Type::list,
         .doc = "Fractions of the chord.",
         .fallback = "[15%, 25%, 40%, 55%, 70%]",
         .element = Type::fraction},
        {.path = "planform.*.box",
         .doc = "The box between two spars, for box_volume.",
         .fallback = "{}",
         .when = "span"},
        {.path = "planform.*.box.chord",
         .type = Type::list,
         .doc = "Fractions of the chord of the front and the rear spar.",
         .fallback = "[15%, 65%]",
         .element = Type::fraction,
         .count = 2},
        {.path = "planform.*.box.span",
         .type = Type::list,
         .doc = "Fractions of the semispan of the first and the last rib.",
         .fallback = "[0%, 95%]",
         .element = Type::fraction,
         .count = 2},
    };
}

}  // namespace

std::vector<Key> planform_keys() { return in_order({shape_keys(), value_keys()}); }

/// Regions of a declared wing.
std::vector<Key> wing_region_keys() {
    return {
        {.path = "regions.*.of",
         .type = Type::name,
         .doc = "A wing of the block planform: triangles whose three vertices lie in the ranges of chord and span, "
                "ends included."},
        {.path = "regions.*.chord",
         .type = Type::list,
         .doc = "Fractions of the local chord. Default: all of it.",
         .element = Type::fraction,
         .count = 2,
         .when = "of"},
        {.path = "regions.*.span",
         .type = Type::list,
         .doc = "Fractions of the semispan. Default: all of it.",
         .element = Type::fraction,
         .count = 2,
         .when = "of"},
        {.path = "regions.*.edge",
         .type = Type::word,
         .doc = "In place of chord: the triangles with a vertex within 1 % of the chord of this edge.",
         .words = {"leading", "trailing"},
         .when = "of"},
    };
}

}  // namespace strake
