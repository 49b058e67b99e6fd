#pragma once
#include "optimize/space/design_space.hpp"

namespace strake {

/// Sets the units of the listed variables: x = 1 moves the surface by `variable_scale`. Those that move nothing, and
/// dependent ones, are dropped with a note. Then metric and bounds. Internal.
void scale_variables(DesignSpace& space);

/// Ranges that the motion limit has given to variables become as long as any surface within it needs, by the linear
/// response: variables that hold each other back, as loads from both sides of a wing, go far beyond what one may do
/// alone. The largest motion bounds the root mean square, x.(S'S)x <= limit^2, so x_j <= limit sqrt((S'S)^-1_jj).
/// @return the largest ratio of ranges, after over before.
double widen_to_limit(DesignSpace& space);

/// Multiplies the ranges that the motion limit has given to variables (not those of users, of wings and of factors on
/// the height). False, and nothing is changed, where x is at the end of none of them.
bool widen_ranges(DesignSpace& space, const Eigen::VectorXd& x, double times);

}  // namespace strake
