#pragma once
#include "core/patches/hierarchy.hpp"

namespace strake {

/// The tree on another surface: triangle t of `mesh` is in the patches of triangle from[t] of the tree's own. Ids,
/// names and parents stay; a patch may hold no triangle there.
PatchHierarchy carried(const PatchHierarchy& tree, const std::vector<int>& from, const TriMesh& mesh);
/// The same of labels alone.
std::vector<int> carried(const std::vector<int>& label, const std::vector<int>& from);

}  // namespace strake
