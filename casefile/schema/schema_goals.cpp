#include "casefile/schema/schema_parts.hpp"

namespace strake {

std::vector<Key> goal_keys() {
    return {
        {.path = "objective", .doc = "For run: exactly one of minimize, maximize."},
        {.path = "objective.minimize",
         .type = Type::text,
         .doc = "A quantity (quantity.value if it has several values), or a formula of quantities, whose value is "
                "named goal."},
        {.path = "objective.maximize", .type = Type::text, .doc = "See minimize."},
        {.path = "fit",
         .type = Type::list,
         .doc = "For fit, in place of objective: quantities with residuals (target_shape, measured_points; thickness "
                "and section_area with target values).",
         .element = Type::text},
        {.path = "constraints",
         .doc = "By name of the quantity, or quantity.value. Limits of a wing's angles carry deg or rad.",
         .may_be_empty = true},
        {.path = "constraints.*", .doc = "min, max or both; or equals."},
        {.path = "constraints.*.min", .type = Type::number_or_angle, .doc = "Minimum value."},
        {.path = "constraints.*.max", .type = Type::number_or_angle, .doc = "Maximum value."},
        {.path = "constraints.*.equals", .type = Type::number_or_angle, .doc = "Required value."},
        {.path = "constraints.*.relative",
         .type = Type::flag,
         .doc = "The limits are multiples of the value at the start shape, which must not be 0. Of a negative value, "
                "too: 0.9 to 1.1 times -50 is -55 to -45.",
         .fallback = "false"},
    };
}

}  // namespace strake
