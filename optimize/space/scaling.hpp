#pragma once
#include "optimize/space/design_space.hpp"

namespace strake {

/// Sets the units of the listed variables: x = 1 moves the surface by `variable_scale`. Those that move nothing, and
/// dependent ones, are dropped with a note. Then metric and bounds. Internal.
void scale_variables(DesignSpace& space);

}  // namespace strake
