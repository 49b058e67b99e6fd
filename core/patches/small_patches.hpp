#pragma once
#include "core/patches/hierarchy.hpp"

#include <vector>

namespace strake {

/// Step 6: merges patches of fewer than `percent` of all triangles into neighbours of the same parent, smallest first.
/// `root` holds per triangle the smallest triangle of its patch and is updated; `patch_class` is read and written at
/// these roots. `parent` is the label of the level above. Cost: O(m log m).
void merge_small_patches(const Adjacency& adjacent, const std::vector<int>& parent, double percent,
                         std::vector<int>& root, std::vector<PatchClass>& patch_class);

}  // namespace strake
