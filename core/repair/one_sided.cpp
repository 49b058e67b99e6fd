#include "core/repair/one_sided.hpp"

#include "core/mesh/disjoint_sets.hpp"

#include <algorithm>

namespace strake::mending {
namespace {

bool joins_two(const Adjacency& adjacent, int e) {
    const auto pair = adjacent.edge_triangles[e];
    return pair.size() == 2 && pair[0] != pair[1];
}

std::array<int, 2> ordered(int s, int t) { return {std::min(s, t), std::max(s, t)}; }

}  // namespace

Joined::Joined(const Adjacency& before) {
    for (int e = 0; e < before.num_edges(); ++e)
        if (joins_two(before, e)) pairs_.push_back(ordered(before.edge_triangles[e][0], before.edge_triangles[e][1]));
    std::sort(pairs_.begin(), pairs_.end());
}

std::vector<int> Joined::one_sided(const Adjacency& after, const std::vector<int>& parent) const {
    // 2 t: triangle t as is; 2 t + 1: reversed. Members of a class are consistent.
    DisjointSets sets(2 * static_cast<int>(parent.size()));
    std::vector<int> found;
    for (const bool looks_at_new : {false, true})
        for (int e = 0; e < after.num_edges(); ++e) {
            if (!joins_two(after, e)) continue;
            const int s = after.edge_triangles[e][0], t = after.edge_triangles[e][1];
            const auto pair = ordered(parent[s], parent[t]);
            const bool is_new = pair[0] != pair[1] && !std::binary_search(pairs_.begin(), pairs_.end(), pair);
            if (is_new != looks_at_new) continue;
            const int turned = after.misoriented[e] ? 1 : 0;
            if (is_new && sets.root(2 * s) == sets.root(2 * t + 1 - turned)) {
                found.push_back(e);
                continue;
            }
            sets.join(2 * s, 2 * t + turned);
            sets.join(2 * s + 1, 2 * t + 1 - turned);
        }
    return found;
}

}  // namespace strake::mending
