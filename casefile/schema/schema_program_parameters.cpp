#include "casefile/schema/schema_parts.hpp"

namespace strake {

std::vector<Key> program_parameter_keys() {
    return {
        {.path = "variables",
         .doc = "Parameters that do not change the shape, by name, for example an angle of attack. Programs receive "
                "their values and return derivatives. Not for fit.",
         .may_be_empty = true},
        {.path = "variables.*",
         .doc = "A parameter: start, min and max, all angles or all plain numbers. Half of the range from min to max "
                "is one unit in the optimizer."},
        {.path = "variables.*.start", .type = Type::number_or_angle, .doc = "Initial value.", .required = true},
        {.path = "variables.*.min", .type = Type::number_or_angle, .doc = "Minimum.", .required = true},
        {.path = "variables.*.max", .type = Type::number_or_angle, .doc = "Maximum.", .required = true},
    };
}

}  // namespace strake
