#include "casefile/schema/schema_parts.hpp"
#include "core/fields/displacement_fields.hpp"

#include <algorithm>

namespace strake {

namespace {

/// Of both kinds of fields.
std::vector<std::string> words_of_motions() {
    std::vector<std::string> words = field_motions();
    for (const std::string& word : wing_motions())
        if (std::ranges::find(words, word) == words.end()) words.push_back(word);
    return words;
}

std::vector<Key> field_keys() {
    return {
        {.path = "parameters.fields",
         .type = Type::integer,
         .doc =
             "Displacement fields as level 0 of the design space: smooth motions of the whole body, zero on what is "
             "fixed, in front of the patches. auto: 27 at first; with split: sensitivity then those up to 192 that the "
             "gradient asks for, else 60 and 192 on the next levels; or a number. They sweep, taper, thicken, flatten "
             "and swell, which a shell resists. auto is also what a fit has that states no fields, variables, given or "
             "planform, and a run of at most 1000 evaluations by values alone (gradients: false) that states none "
             "of these, nor a method other than model, finite_differences, low_fidelity or start_from. A run by "
             "gradients (method: auto or sqp; not hold: none) has it where its parameters state nothing but "
             "max_displacement, mirror and keep, without constraints with split: sensitivity. With start_from such a "
             "case has the fields of that folder's case.",
         .fallback = "none",
         .limits = {1, 600},
         .words = {"none", "auto"}},
        {.path = "parameters.keep",
         .type = Type::word,
         .doc =
             "smooth_border: displacement fields leave what is held with no slope, and no design of a run turns "
             "normals beside what is fixed or moved by strains by more than 2 degrees, so that no crease forms there. "
             "Beside a planform and in a fit that states no max_displacement fields alone keep to it. `strake check` "
             "says by how much variables turn them. none: fields leave it with a slope, which more motions have.",
         .fallback = "none",
         .words = {"none", "smooth_border"}},
        {.path = "parameters.fields", .doc = "Displacement fields with what they act on."},
        {.path = "parameters.fields.number",
         .type = Type::integer,
         .doc = "Number of fields: 6, 12, 27, 60 or any other; the first of a larger number. auto: 27 at first; with "
                "split: sensitivity then those up to 192 that the gradient asks for, else 60 and 192 on the next "
                "levels.",
         .fallback = "auto",
         .limits = {1, 600},
         .words = {"auto"}},
        {.path = "parameters.fields.on",
         .type = Type::text,
         .doc = "Region or patch that they move; the rest stays as if it were fixed. Default: parameters.variables_on, "
                "or the whole surface."},
        {.path = "parameters.fields.axis",
         .type = Type::word,
         .doc = "Axis of the sections. Default: the longest principal axis.",
         .words = {"x", "y", "z"}},
        {.path = "parameters.fields.axis",
         .type = Type::list,
         .doc = "An axis of any direction; its length has no effect.",
         .element = Type::number,
         .count = 3},
        {.path = "parameters.fields.motions",
         .type = Type::list,
         .doc =
             "What the fields may do, by the words in their names, for example [scale] of a body of revolution, whose "
             "profile then changes and whose stations stay. out and around: of bodies that are revolved or cyclic; "
             "chord, "
             "camber, thickness, bend and stretch: of kind: wing. "
             "Default: all.",
         .words = words_of_motions(),
         .element = Type::word},
        {.path = "parameters.fields.kind",
         .type = Type::word,
         .doc = "sections: cross-sections of the body are moved, turned, scaled and sheared. wing: in the coordinates "
                "of a wing, the one under planform or else what the surface shows: its sections are moved, turned and "
                "stretched, and reshaped along the chord (camber, thickness), by amounts that are polynomials along "
                "the span; where it keeps its planform they are only reshaped, and what is not the wing stays. auto: "
                "wing where a program gives values only (gradients: false), one wing is declared that keeps its "
                "planform, nothing else can move, and the case is no fit and states no axis, motions, along or "
                "invariance; number: auto then means 24 at first. Else sections.",
         .fallback = "auto",
         .words = {"auto", "sections", "wing"}},
        {.path = "parameters.fields.along",
         .type = Type::word,
         .doc =
             "What the amounts along the axis of the sections are made of. polynomials: smooth over the whole length. "
             "splines: polynomials of degree 3, then cubic splines whose knots are halved again and again; they are "
             "local, and many of them take away a kink of the start, which polynomials keep. number: auto then means "
             "12, "
             "and 24, 48, 96, 192 and 384 on the next levels.",
         .fallback = "polynomials",
         .words = {"polynomials", "splines"}},
    };
}

std::vector<Key> planform_range_keys() {
    return {
        {.path = "parameters.planform",
         .doc =
             "What of the wings under planform may change: wing.span, wing.sweep, wing.dihedral (of the whole axis or "
             "by the panels between stations), wing.chord, wing.twist, wing.thickness, wing.camber (of all sections or "
             "by station), or one station, wing.twist@0.37; wing.aft, wing.up (all of it, as it is, for flaps and "
             "slats). What is not listed stays. The variables are the changes, "
             "wing.delta_twist@0.37, 0 at "
             "the start: docs/planform.md.",
         .may_be_empty = true},
        {.path = "parameters.planform.*", .doc = "A change of a wing."},
        {.path = "parameters.planform.*.range",
         .type = Type::list,
         .doc =
             "Smallest and largest change, around 0: with deg or rad for sweep (tip aft), dihedral (tip up) and twist "
             "(nose up), in % for span, chord and thickness (t/c), of their own values, and camber, aft and up, of the "
             "chord. "
             "max_displacement does not limit it.",
         .required = true,
         .element = Type::text,
         .count = 2},
        {.path = "parameters.planform.*.by",
         .type = Type::word,
         .doc =
             "station: one variable for each station of the wing, with straight edges between; of sweep and dihedral "
             "one for each panel, named by the station where it begins. wing: one for all.",
         .fallback = "wing",
         .words = {"wing", "station"}},
        {.path = "parameters.planform.*.root",
         .type = Type::word,
         .doc = "held: by station, the section at the root (of sweep and dihedral the panel there) keeps its value; "
                "of sections needed where the wing is joined to a body.",
         .fallback = "free",
         .words = {"free", "held"}},
        {.path = "parameters.planform.*.thickness",
         .type = Type::word,
         .doc = "Of chord: scaled, t/c stays; kept, the thickness itself stays.",
         .fallback = "scaled",
         .words = {"scaled", "kept"}},
    };
}

std::vector<Key> given_keys() {
    return {
        {.path = "parameters.given",
         .type = Type::list,
         .doc = "User-defined shape variables, in addition to those of the patches. They exist on every level and are "
                "never split.",
         .element = Type::map,
         .may_be_empty = true},
        {.path = "parameters.given[]", .doc = "A variable: exactly one of load, translate, rotate, twist."},
        {.path = "parameters.given[].name", .type = Type::name, .doc = "Name of the variable.", .required = true},
        {.path = "parameters.given[].region",
         .type = Type::text,
         .doc = "Region or patch on which it acts. Required except for a twist, which acts on the whole surface "
                "without it."},
        {.path = "parameters.given[].load",
         .type = Type::word,
         .doc = "Traction along the normal of each triangle.",
         .words = {"normal"}},
        {.path = "parameters.given[].load",
         .type = Type::list,
         .doc = "Uniform traction in this direction; its length has no effect.",
         .element = Type::number,
         .count = 3},
        {.path = "parameters.given[].translate",
         .type = Type::list,
         .doc = "The region moves rigidly in this direction; its length has no effect.",
         .element = Type::number,
         .count = 3},
        {.path = "parameters.given[].rotate",
         .type = Type::list,
         .doc = "The region rotates rigidly about an axis of this direction.",
         .element = Type::number,
         .count = 3},
        {.path = "parameters.given[].twist",
         .type = Type::list,
         .doc = "Twist distribution about an axis of this direction: one variable per station (name.1, name.2, ...). "
                "Each is a load whose linear response rotates the section at one station and none at the others, "
                "linear in between.",
         .element = Type::number,
         .count = 3},
        {.path = "parameters.given[].about",
         .type = Type::list,
         .doc = "A point on the axis of a rotation (default: the area centroid of the region) or a twist (required).",
         .element = Type::coordinate,
         .count = 3},
        {.path = "parameters.given[].stations",
         .type = Type::integer,
         .doc = "Number of stations of a twist, evenly spaced from end to end. Default: 3. A station on a held section "
                "gets no variable.",
         .limits = {2, no_limit, false, false}},
        {.path = "parameters.given[].stations",
         .type = Type::list,
         .doc = "Positions of the stations along the axis of a twist, measured from `about`, ascending.",
         .element = Type::coordinate},
        {.path = "parameters.given[].max_displacement",
         .type = Type::length,
         .doc = "Maximum displacement by this variable alone, in its linear response. Default: none of its own; the "
                "motion "
                "limit holds in any case.",
         .limits = positive},
        {.path = "parameters.given[].max_angle",
         .type = Type::angle,
         .doc = "Maximum angle of a twist (default: 5deg) or a rotation, in place of max_displacement.",
         .limits = {0, 180, true, false}},
    };
}

}  // namespace

std::vector<Key> user_variable_keys() { return in_order({planform_range_keys(), field_keys(), given_keys()}); }

}  // namespace strake
