#pragma once
#include "core/patches/body.hpp"

#include <vector>

namespace strake {

/// Appends the next automatic level: the chosen patches (flags by id) of the last level are cut as
/// `segment_automatically` says, the others carried over. The step by which a run chooses its patches as it goes.
/// @param due areas meant for the patches of the last level (start: the whole area); replaced by those of the new one.
/// @pre `options` would pass `segment_automatically` and names a number for this level.
void refine_automatically(PatchHierarchy& tree, const Body& body, std::vector<double>& due,
                          const std::vector<char>& chosen, const AutomaticLevels& options);

}  // namespace strake
