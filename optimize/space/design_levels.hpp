#pragma once
#include "optimize/space/design_space.hpp"

/// How the space of a level is made. Internal.
namespace strake {

/// The space of patches and fields with x = 0: which variables there are, their units, metric and bounds. With a parent
/// its strain cores are the child's parts of the parent's; nothing else is inherited.
DesignSpace make_space(std::shared_ptr<const RestFacts> rest, int level, const LevelSet& set,
                       const DesignSpace* parent);

}  // namespace strake
