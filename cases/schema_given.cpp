#include "cases/schema_parts.hpp"

namespace strake {

std::vector<Key> given_keys() {
    return {
        {.path = "parameters.given",
         .type = Type::list,
         .doc = "Shape variables of your own, beside those of the patches: there on every level, never split.",
         .element = Type::map,
         .may_be_empty = true},
        {.path = "parameters.given[]", .doc = "A variable: exactly one of load, translate, rotate, twist."},
        {.path = "parameters.given[].name", .type = Type::name, .doc = "Its name.", .required = true},
        {.path = "parameters.given[].region",
         .type = Type::text,
         .doc = "Region or patch on which it acts; only a twist may do without, and then turns the whole surface."},
        {.path = "parameters.given[].load",
         .type = Type::word,
         .doc = "Traction along each triangle's own normal.",
         .words = {"normal"}},
        {.path = "parameters.given[].load",
         .type = Type::list,
         .doc = "Uniform traction along this direction; its length does not matter.",
         .element = Type::number,
         .count = 3},
        {.path = "parameters.given[].translate",
         .type = Type::list,
         .doc = "The region is pinned and moves along this direction; its length does not matter.",
         .element = Type::number,
         .count = 3},
        {.path = "parameters.given[].rotate",
         .type = Type::list,
         .doc = "The region is pinned and turns about an axis of this direction.",
         .element = Type::number,
         .count = 3},
        {.path = "parameters.given[].twist",
         .type = Type::list,
         .doc = "The sections at several stations turn about an axis of this direction, one variable each, called "
                "name.1, name.2, ...: loads whose linear response turns the section at one station and leaves the "
                "others; linear between the stations.",
         .element = Type::number,
         .count = 3},
        {.path = "parameters.given[].about",
         .type = Type::list,
         .doc = "A point on the axis of rotate (without it the region's area centroid) or twist (which needs it).",
         .element = Type::coordinate,
         .count = 3},
        {.path = "parameters.given[].stations",
         .type = Type::integer,
         .doc = "Number of stations of a twist, evenly from end to end; 3 without it. Where the section is held there "
                "is no variable.",
         .limits = {2, no_limit, false, false}},
        {.path = "parameters.given[].stations",
         .type = Type::list,
         .doc = "Places of the stations along the axis of a twist, measured from `about`, rising.",
         .element = Type::coordinate},
        {.path = "parameters.given[].max_displacement",
         .type = Type::length,
         .doc = "How far the variable may move the surface by its linear response; without it as all others.",
         .limits = positive},
        {.path = "parameters.given[].max_angle",
         .type = Type::angle,
         .doc = "How far a twist (5deg without it) or a rotation may turn; in place of max_displacement.",
         .limits = {0, 180, true, false}},
    };
}

}  // namespace strake
