#pragma once
#include "core/patches/hierarchy.hpp"

/// A front of a patch tree: patches of different levels that cover the surface once. A run that refines adaptively
/// optimizes on it.
namespace strake {

struct Front {
    PatchLevel patches;      ///< `parent` is the id in the front before; names as in the tree
    std::vector<int> depth;  ///< per patch: the finest level of the tree on which it exists whole
};

/// The front that is one level of the tree. @throws InvalidInput: no such level.
Front front_at(const PatchHierarchy& tree, int level);

/// Number of parts of each patch of the front in the tree; 1: the tree has no finer ones.
std::vector<int> parts_of(const PatchHierarchy& tree, const Front& front);

/// The front with the chosen patches (flags by id) replaced by their parts, the others carried over.
Front split_front(const PatchHierarchy& tree, const Front& front, const std::vector<char>& chosen);

}  // namespace strake
