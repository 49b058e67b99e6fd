#pragma once
#include "optimize/design_space.hpp"

namespace strake {

/// Units of the listed variables so that x = 1 moves the surface by max_displacement; those that move nothing, or do
/// the same as others, are left out with a note. Then metric and bounds. Internal.
void scale_variables(DesignSpace& space);

}  // namespace strake
