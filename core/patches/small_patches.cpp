#include "core/patches/small_patches.hpp"

#include <algorithm>
#include <set>
#include <tuple>
#include <utility>

namespace strake {
namespace {

/// The patches of a level during merging, by number; the survivor keeps its number.
struct Merging {
    std::vector<int> count, first, into;  ///< triangles, smallest triangle, what it was merged into (or itself)
    std::vector<PatchClass> patch_class;
    std::vector<std::set<int>> neighbours;  ///< of the same parent

    /// The neighbour that absorbs patch `s`, or -1.
    int taker(int s) const {
        int best = -1;
        bool best_same = false;
        for (const int c : neighbours[s]) {
            const bool same = patch_class[c] == patch_class[s];
            const bool better = best < 0 || std::make_tuple(!same, -count[c], first[c]) <
                                                std::make_tuple(!best_same, -count[best], first[best]);
            if (better) best = c, best_same = same;
        }
        return best;
    }

    void merge(int s, int t) {
        into[s] = t;
        count[t] += count[s];
        first[t] = std::min(first[t], first[s]);
        for (const int n : neighbours[s]) {
            neighbours[n].erase(s);
            if (n == t) continue;
            neighbours[n].insert(t);
            neighbours[t].insert(n);
        }
        neighbours[s].clear();
    }

    int survivor(int p) {
        while (into[p] != p) p = into[p] = into[into[p]];
        return p;
    }
};

Merging start(const Adjacency& adjacent, const std::vector<int>& parent, const std::vector<int>& root,
              const std::vector<PatchClass>& class_at_root, std::vector<int>& number) {
    Merging m;
    number.assign(root.size(), -1);
    for (std::size_t t = 0; t < root.size(); ++t) {
        if (root[t] == static_cast<int>(t)) {
            number[t] = static_cast<int>(m.count.size());
            m.count.push_back(0);
            m.first.push_back(static_cast<int>(t));
            m.into.push_back(number[t]);
            m.patch_class.push_back(class_at_root[t]);
        } else {
            number[t] = number[root[t]];
        }
        ++m.count[number[t]];
    }
    m.neighbours.resize(m.count.size());
    for (int e = 0; e < adjacent.num_edges(); ++e)
        for (const int a : adjacent.edge_triangles[e])
            for (const int b : adjacent.edge_triangles[e])
                if (number[a] != number[b] && parent[a] == parent[b]) m.neighbours[number[a]].insert(number[b]);
    return m;
}

}  // namespace

void merge_small_patches(const Adjacency& adjacent, const std::vector<int>& parent, double percent,
                         std::vector<int>& root, std::vector<PatchClass>& patch_class) {
    // Products instead of a quotient: a count of exactly p percent is not small, despite the rounding of p/100.
    const auto is_small = [&](int count) { return 100.0 * count < percent * static_cast<double>(root.size()); };
    std::vector<int> number;
    Merging m = start(adjacent, parent, root, patch_class, number);
    std::set<std::tuple<int, int, int>> small;  // count, first triangle, patch
    const auto key = [&](int p) { return std::make_tuple(m.count[p], m.first[p], p); };
    for (int p = 0; p < static_cast<int>(m.count.size()); ++p)
        if (is_small(m.count[p])) small.insert(key(p));
    while (!small.empty()) {
        const int s = std::get<2>(*small.begin());
        small.erase(small.begin());
        const int t = m.taker(s);
        if (t < 0) continue;  // an island: it never gets neighbours
        small.erase(key(t));
        m.merge(s, t);
        if (is_small(m.count[t])) small.insert(key(t));
    }
    for (std::size_t t = 0; t < root.size(); ++t) root[t] = m.first[number[t] = m.survivor(number[t])];
    for (std::size_t t = 0; t < root.size(); ++t) patch_class[root[t]] = m.patch_class[number[t]];
}

}  // namespace strake
