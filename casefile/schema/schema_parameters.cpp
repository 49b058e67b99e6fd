#include "casefile/schema/schema_parts.hpp"

namespace strake {
namespace {

std::vector<Key> level_keys() {
    return {
        {.path = "parameters", .doc = "Patches and design variables.", .fallback = "{}"},
        {.path = "parameters.levels",
         .type = Type::word,
         .doc = "Crease angles are chosen for about 4^k patches on level k.",
         .fallback = "auto",
         .words = {"auto"}},
        {.path = "parameters.levels",
         .type = Type::list,
         .doc = "Crease angle of each level, descending.",
         .limits = {0, 90, true, false},
         .element = Type::angle},
        {.path = "parameters.min_patch",
         .type = Type::fraction,
         .doc = "Minimum patch size as a share of all triangles; smaller patches are merged into neighbors.",
         .fallback = "0%",
         .limits = {0, 1, false, true},
         .when = "levels=[]"},
        {.path = "parameters.patches_per_level",
         .type = Type::list,
         .doc = "Target number of patches on each level, ascending.",
         .fallback = "[4, 16, 64]",
         .limits = at_least_one,
         .element = Type::integer,
         .when = "levels=auto"},
        {.path = "parameters.sharp_angle",
         .type = Type::angle,
         .doc = "Where every vertex lies on a crease, faces that meet at a smaller angle stay in one patch.",
         .fallback = "40deg",
         .limits = {0, 180, true, false}},
    };
}

std::vector<Key> kind_keys() {
    return {
        {.path = "parameters.variables",
         .type = Type::list,
         .doc = "Design variables of each patch: load (traction vector), normal (traction along the normals), strain "
                "(rigid motion of the patch core), strain_rotation or strain_translation (half of it), stiffness "
                "(logarithm of the thickness). []: no shape variables, for cases with only `given` or `variables`. "
                "Where fields come by default to a run by values alone: [normal], unless directions are stated.",
         .fallback = "[load]",
         .words = {"load", "normal", "strain", "strain_rotation", "strain_translation", "stiffness"},
         .element = Type::word,
         .may_be_empty = true},
        {.path = "parameters.directions",
         .type = Type::list,
         .doc = "Traction directions of load variables, one variable per direction; they need not be orthogonal. "
                "Default: x, y, z.",
         .element = Type::list,
         .when = "variables[]=load"},
        {.path = "parameters.directions[]",
         .type = Type::list,
         .doc = "A direction; its length has no effect.",
         .element = Type::number,
         .count = 3},
        {.path = "parameters.free_border",
         .type = Type::fraction,
         .doc = "Width of the border inside each patch that a strain leaves free, as a share of the inradius.",
         .fallback = "40%",
         .limits = {0, 1, true, true},
         .when = "variables[]=strain|strain_rotation|strain_translation"},
        {.path = "parameters.max_displacement",
         .type = Type::length,
         .doc =
             "The motion limit: the farthest that any point of the surface may be from its datum, in every shape that "
             "a run evaluates. The datum is the surface under the given loads and strains, all variables at zero. "
             "`fit` and `sweep` have a limit only where one is written. `deform`, `apply` and `mix` give what they are "
             "asked for.",
         .fallback = "5%",
         .limits = positive},
        {.path = "parameters.max_displacement",
         .doc = "The motion limit by region: `default` and names of regions. Where regions overlap, the smaller limit "
                "holds."},
        {.path = "parameters.max_displacement.default",
         .type = Type::length,
         .doc = "The limit outside the named regions.",
         .fallback = "5%",
         .limits = positive},
        {.path = "parameters.max_displacement.*",
         .type = Type::length,
         .doc = "The limit in this region.",
         .limits = not_negative},
        {.path = "parameters.max_displacement.*",
         .doc =
             "Different limits of the part of the displacement along the datum's normal and against it. The distance "
             "from the datum is at most the larger one."},
        {.path = "parameters.max_displacement.*.inward",
         .type = Type::length,
         .doc = "Against the normal. Default: the limit outside the named regions.",
         .limits = not_negative},
        {.path = "parameters.max_displacement.*.outward",
         .type = Type::length,
         .doc = "Along the normal. Default: the limit outside the named regions.",
         .limits = not_negative},
        {.path = "parameters.variable_scale",
         .type = Type::length,
         .doc = "Displacement by a variable of 1, in its linear response: the unit of scaled variables, in which steps "
                "and differences are measured. Default: the motion limit.",
         .limits = positive},
    };
}

std::vector<Key> split_keys() {
    return {
        {.path = "parameters.split",
         .type = Type::word,
         .doc = "Patches that the next level splits: all; sensitivity: those with the largest expected decrease, from "
                "the sensitivities of their potential children (beside fields, by exact gradients and of loads, single "
                "patches of any level, and those beside them have no variables); gradient: those with the largest "
                "integral of the objective's gradient (the paper's rule).",
         .fallback = "all",
         .words = {"all", "sensitivity", "gradient"}},
        {.path = "parameters.split", .doc = "Exactly one of largest, containing."},
        {.path = "parameters.split.largest",
         .type = Type::integer,
         .doc = "Number of patches to split, by triangle count.",
         .limits = at_least_one},
        {.path = "parameters.split.containing",
         .type = Type::list,
         .doc = "The patches that contain these triangles.",
         .element = Type::integer},
        {.path = "parameters.split.containing[]",
         .type = Type::integer,
         .doc = "Triangle number in the surface file, counted from 0.",
         .limits = not_negative},
        {.path = "parameters.split.containing[]", .doc = "The triangle nearest to a point."},
        {.path = "parameters.split.containing[].near",
         .type = Type::list,
         .doc = "The point.",
         .required = true,
         .element = Type::coordinate,
         .count = 3},
        {.path = "parameters.marking_fraction",
         .type = Type::fraction,
         .doc = "Patches are marked for splitting until they account for this share of the total expected decrease; "
                "with sensitivity displacement fields are taken until 99% (not of splines).",
         .fallback = "90%",
         .limits = {0, 1, true, false},
         .when = "split=sensitivity|gradient"},
        {.path = "parameters.max_variable_ratio",
         .type = Type::number,
         .doc = "Maximum number of variables of a level, relative to the previous level.",
         .fallback = "8",
         .limits = {1, no_limit, true, false},
         .when = "split=sensitivity|gradient"},
    };
}

std::vector<Key> place_keys() {
    return {
        {.path = "parameters.variables_on",
         .type = Type::list,
         .doc = "Regions or patches that may carry design variables. Default: the whole surface.",
         .element = Type::text},
        {.path = "parameters.frozen",
         .type = Type::list,
         .doc = "Regions or patches that get no new variables and keep their inherited values.",
         .element = Type::text},
        {.path = "parameters.groups",
         .type = Type::list,
         .doc = "Groups of regions or patches; the patches of a group share their values.",
         .element = Type::list},
        {.path = "parameters.groups[]", .type = Type::list, .doc = "A group.", .element = Type::text},
        {.path = "parameters.mirror",
         .type = Type::flag,
         .doc = "Full models with a plane of symmetry: patches that mirror each other share their values, and the "
                "patches of one side become mirror images of those of the other.",
         .fallback = "false"},
    };
}

}  // namespace

std::vector<Key> parameter_keys() { return in_order({level_keys(), kind_keys(), split_keys(), place_keys()}); }

}  // namespace strake
