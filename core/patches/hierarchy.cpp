#include "core/patches/hierarchy.hpp"

#include "core/error.hpp"
#include "core/text/edit_distance.hpp"

namespace strake {

PatchPlace find_patch(const PatchHierarchy& tree, const std::string& name) {
    std::string nearest;
    for (int l = static_cast<int>(tree.levels.size()) - 1; l >= 0; --l)
        for (const Patch& patch : tree.levels[l].patches) {
            if (patch.name == name) return {l, patch.id};
            if (nearest.empty() || edit_distance(name, patch.name) < edit_distance(name, nearest)) nearest = patch.name;
        }
    throw InvalidInput(text("no patch is named '", name, "'; did you mean '", nearest, "'?"));
}

}  // namespace strake
