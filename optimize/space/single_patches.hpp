#pragma once
#include "optimize/space/refinement.hpp"

/// Patches beside fields, one by one: of all levels of the tree those that promise most for each of their variables get
/// variables, and those beside them rest. Internal.
namespace strake {

/// The prospect of a space where patches are taken one by one (`RestFacts::takes_single_patches`): patches at rest, or
/// parts of them on any level, can be taken, those that have variables be split, fields be added.
/// @returns without `metric`, `inherited` and `known`.
/// @pre has_finer(space)
Prospect prospect_of_single_patches(const DesignSpace& space, const Eigen::VectorXd& x, bool offers_fields);

/// The space with these of its prospect: patches at rest are split as far as the taken ones need, what is beside these
/// rests on.
LevelSet with_single_patches(const DesignSpace& space, const std::vector<const SplitDecrease*>& chosen,
                             const std::vector<int>& fields);

}  // namespace strake
