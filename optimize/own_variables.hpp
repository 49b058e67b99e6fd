#pragma once
#include "optimize/design_space.hpp"

/// Design variables that are not shape (DESIGN section 6). They stand behind the shape variables of every level and
/// are the same on all of them. Scaled so that x = 0 is the start and a change of x by 1 is half of what the bounds
/// allow: value = start + x (max - min) / 2. In the metric each has size 1 and no part in the others.
namespace strake {

/// @throws InvalidInput: a name twice, empty or with a dot; not finite; not min <= start <= max with min < max.
void check_own(const std::vector<OwnVariable>& own);

/// Appends the own variables to a space that has none yet.
void append_own(DesignSpace& space);

/// Names and physical values, never outside of the bounds.
std::vector<std::pair<std::string, double>> own_values(const DesignSpace& space, const Eigen::VectorXd& x);

/// Change of the physical value per change of x (num_own()).
Eigen::VectorXd own_units(const DesignSpace& space);

}  // namespace strake
