#include "core/error.hpp"
#include "core/mesh/disjoint_sets.hpp"
#include "core/repair/surface_parts.hpp"

#include <algorithm>
#include <span>

namespace strake::mending {
namespace {

/// Triangles with the same three corners, ascending.
using Copies = std::vector<int>;

std::vector<Copies> copies_of(const Triangles& triangles) {
    std::vector<std::pair<std::array<int, 3>, int>> keys;
    for (int t = 0; t < triangles.rows(); ++t) {
        std::array<int, 3> key{triangles(t, 0), triangles(t, 1), triangles(t, 2)};
        std::sort(key.begin(), key.end());
        keys.push_back({key, t});
    }
    std::sort(keys.begin(), keys.end());
    std::vector<Copies> found;
    for (std::size_t i = 0; i < keys.size();) {
        Copies copies;
        const std::size_t first = i;
        for (; i < keys.size() && keys[i].first == keys[first].first; ++i) copies.push_back(keys[i].second);
        if (copies.size() > 1) found.push_back(copies);
    }
    std::sort(found.begin(), found.end());
    return found;
}

bool runs(const Triangles& triangles, int t, int a, int b) {
    for (int k = 0; k < 3; ++k)
        if (triangles(t, k) == a && triangles(t, (k + 1) % 3) == b) return true;
    return false;
}

/// All sets of copies, and their connections.
class Sheets {
public:
    Sheets(const TriMesh& mesh, const Adjacency& adjacent, const std::vector<Copies>& sets)
        : mesh_(mesh),
          adjacent_(adjacent),
          set_of_(static_cast<std::size_t>(mesh.num_triangles()), -1),
          together_(static_cast<int>(sets.size())) {
        for (std::size_t i = 0; i < sets.size(); ++i)
            for (const int t : sets[i]) set_of_[t] = static_cast<int>(i);
        for (const Copies& copies : sets)
            for (int k = 0; k < 3; ++k)
                for (const int n : around(copies[0], k))
                    if (set_of_[n] >= 0) together_.join(set_of_[n], set_of_[copies[0]]);
        balance_.resize(sets.size());
        is_back_to_back_.assign(sets.size(), 1);
        for (const Copies& copies : sets) tally(copies);
    }

    /// Back to back on surroundings that are closed without them: a common wall of two parts that touch, or a flap.
    bool is_wall(const Copies& copies) {
        const int r = together_.root(set_of_[copies[0]]);
        return is_back_to_back_[r] && balance_[r] > 0;
    }

    /// Number of edges at which a triangle agrees with others that are no copies, minus those at which it disagrees.
    int agreement(int t) const {
        int agree = 0;
        for (int k = 0; k < 3; ++k) {
            const int a = mesh_.triangles(t, k), b = mesh_.triangles(t, (k + 1) % 3);
            for (const int n : around(t, k))
                if (set_of_[n] < 0) agree += runs(mesh_.triangles, n, b, a) ? 1 : -1;
        }
        return agree;
    }

private:
    std::span<const int> around(int t, int k) const { return adjacent_.edge_triangles[adjacent_.triangle_edges(t, k)]; }
    void tally(const Copies& copies) {
        const int r = together_.root(set_of_[copies[0]]);
        int senses = 0;
        for (const int t : copies)
            senses += runs(mesh_.triangles, t, mesh_.triangles(copies[0], 0), mesh_.triangles(copies[0], 1)) ? 1 : -1;
        if (senses != 0) is_back_to_back_[r] = 0;
        for (int k = 0; k < 3; ++k) {
            int others = 0;
            for (const int n : around(copies[0], k)) others += set_of_[n] < 0;
            if (others > 0) balance_[r] += others % 2 == 0 ? 1 : -1;
        }
    }

    const TriMesh& mesh_;
    const Adjacency& adjacent_;
    std::vector<int> set_of_;   ///< per triangle; -1: no copy
    DisjointSets together_;     ///< sets that share edges
    std::vector<int> balance_;  ///< rim edges closed without the copies, minus open ones
    std::vector<char> is_back_to_back_;
};

}  // namespace

void remove_duplicates(Surface& surface) {
    const TriMesh& mesh = surface.mesh;
    const std::vector<Copies> found = copies_of(mesh.triangles);
    if (found.empty()) return;
    const Adjacency adjacent = adjacency(mesh);
    Sheets sheets(mesh, adjacent, found);
    std::vector<char> is_gone(static_cast<std::size_t>(mesh.num_triangles()));
    for (const Copies& copies : found) {
        const auto corner = mesh.triangles.row(copies[0]);
        if (corner[0] == corner[1] || corner[1] == corner[2] || corner[2] == corner[0]) continue;  // for `degenerate`
        int kept = copies[0];
        for (const int t : copies)
            if (sheets.agreement(t) > sheets.agreement(kept)) kept = t;
        const bool is_wall = sheets.is_wall(copies);
        for (const int t : copies) {
            if (t == kept && !is_wall) continue;
            is_gone[t] = 1;
            const bool same_sense = runs(mesh.triangles, t, mesh.triangles(kept, 0), mesh.triangles(kept, 1));
            surface.items.push_back({RepairKind::duplicate, -1, surface.source[t], surface.center(t), 0, 1,
                                     is_wall ? text("triangle ", surface.source[t], ", one of two back to back")
                                             : text("triangle ", surface.source[t], ", a copy of triangle ",
                                                    surface.source[kept], same_sense ? "" : " turned over")});
        }
    }
    surface.remove(is_gone);
}

}  // namespace strake::mending
