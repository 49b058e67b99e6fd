#include "cases/schema_parts.hpp"

namespace strake {

std::vector<Key> variable_keys() {
    return {
        {.path = "variables",
         .doc = "Design variables that are not shape, by name; programs (quantities with a command) are given their "
                "values and asked for the derivatives. Not for fit.",
         .may_be_empty = true},
        {.path = "variables.*",
         .doc = "One of them: three angles, or three plain numbers. Scaled like the others: half of the range from min "
                "to max counts as one."},
        {.path = "variables.*.start", .type = Type::number_or_angle, .doc = "Where the run begins.", .required = true},
        {.path = "variables.*.min", .type = Type::number_or_angle, .doc = "Smallest value.", .required = true},
        {.path = "variables.*.max", .type = Type::number_or_angle, .doc = "Largest value.", .required = true},
    };
}

}  // namespace strake
