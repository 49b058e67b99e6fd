#pragma once
#include "optimize/space/design_space.hpp"

namespace strake {

/// Sets the units of the listed variables: x = 1 moves the surface by `variable_scale`. Those that move nothing, and
/// dependent ones, are dropped with a note. Then metric and bounds. Internal.
void scale_variables(DesignSpace& space);

/// Multiplies the ranges that the motion limit has given to variables (not those of users, of wings and of factors on
/// the height). False, and nothing is changed, where x is at the end of none of them.
bool widen_ranges(DesignSpace& space, const Eigen::VectorXd& x, double times);

}  // namespace strake
