#include "core/patches/front.hpp"

#include "core/error.hpp"

#include <algorithm>

namespace strake {
namespace {

/// The finest level below `level` at which the patch of `triangle` still has the same number of triangles.
int finest_whole(const PatchHierarchy& tree, int level, int triangle) {
    const auto size_at = [&](int k) { return tree.levels[k].patches[tree.levels[k].label[triangle]].triangles.size(); };
    int depth = level;
    while (depth + 1 < static_cast<int>(tree.levels.size()) && size_at(depth + 1) == size_at(level)) ++depth;
    return depth;
}

}  // namespace

Front front_at(const PatchHierarchy& tree, int level) {
    if (level < 0 || level >= static_cast<int>(tree.levels.size()))
        throw InvalidInput(text("level ", level, " must be in [0, ", static_cast<int>(tree.levels.size()) - 1, "]"));
    Front front{tree.levels[level], {}};
    for (const Patch& patch : front.patches.patches)
        front.depth.push_back(finest_whole(tree, level, patch.triangles.front()));
    return front;
}

std::vector<int> parts_of(const PatchHierarchy& tree, const Front& front) {
    std::vector<int> parts(front.depth.size(), 1);
    for (const Patch& patch : front.patches.patches) {
        const std::size_t below = front.depth[patch.id] + 1;
        if (below >= tree.levels.size()) continue;
        std::vector<int> ids;
        for (const int t : patch.triangles) ids.push_back(tree.levels[below].label[t]);
        std::sort(ids.begin(), ids.end());
        parts[patch.id] = static_cast<int>(std::unique(ids.begin(), ids.end()) - ids.begin());
    }
    return parts;
}

Front split_front(const PatchHierarchy& tree, const Front& front, const std::vector<char>& chosen) {
    Front next;
    next.patches.angle_deg = front.patches.angle_deg;
    next.patches.label.assign(front.patches.label.size(), -1);
    // In the order of the smallest triangle, as on every level.
    for (std::size_t t = 0; t < next.patches.label.size(); ++t) {
        if (next.patches.label[t] >= 0) continue;
        const int above = front.patches.label[t];
        const int depth = front.depth[above];
        const bool split = chosen[above] && depth + 1 < static_cast<int>(tree.levels.size());
        Patch patch = front.patches.patches[above];
        if (split) patch = tree.levels[depth + 1].patches[tree.levels[depth + 1].label[t]];
        patch.id = static_cast<int>(next.patches.patches.size());
        patch.parent = above;
        for (const int u : patch.triangles) next.patches.label[u] = patch.id;
        next.depth.push_back(split ? finest_whole(tree, depth + 1, static_cast<int>(t)) : depth);
        next.patches.patches.push_back(std::move(patch));
    }
    return next;
}

}  // namespace strake
