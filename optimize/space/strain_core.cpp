#include "optimize/space/strain_core.hpp"

#include "core/mesh/geometry.hpp"
#include "core/primo/shell.hpp"

#include <limits>
#include <queue>

namespace strake {
namespace {

constexpr double unreached = std::numeric_limits<double>::infinity();

/// The triangle across edge k of t within the same patch and free, or -1.
int across(const Adjacency& adjacent, const std::vector<int>& label, const std::vector<int>& pin, int t, int k) {
    const int e = adjacent.triangle_edges(t, k);
    if (adjacent.edge_triangles[e].size() != 2) return -1;
    const int other =
        adjacent.edge_triangles[e][0] == t ? adjacent.edge_triangles[e][1] : adjacent.edge_triangles[e][0];
    return label[other] == label[t] && pin[other] == free_prism ? other : -1;
}

/// Distance of every free triangle's centre from the border of its patch (Dijkstra; tie: the smaller triangle).
std::vector<double> border_distances(const TriMesh& mesh, const Adjacency& adjacent, const PatchLevel& level,
                                     const std::vector<int>& pin, bool open_edges_count) {
    const Points centre = triangle_centroids(mesh);
    std::vector<double> distance(mesh.num_triangles(), unreached);
    using Item = std::pair<double, int>;
    std::priority_queue<Item, std::vector<Item>, std::greater<>> queue;
    const auto reach = [&](int t, double d) {
        if (d < distance[t]) queue.emplace(distance[t] = d, t);
    };
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        if (pin[t] != free_prism) continue;
        for (int k = 0; k < 3; ++k) {
            const bool open = adjacent.edge_triangles[adjacent.triangle_edges(t, k)].size() == 1;
            if (open ? !open_edges_count : across(adjacent, level.label, pin, t, k) >= 0) continue;
            const int a = mesh.triangles(t, k), b = mesh.triangles(t, (k + 1) % 3);
            reach(t, (0.5 * (mesh.vertices.row(a) + mesh.vertices.row(b)) - centre.row(t)).norm());
        }
    }
    while (!queue.empty()) {
        const auto [d, t] = queue.top();
        queue.pop();
        if (d > distance[t]) continue;
        for (int k = 0; k < 3; ++k)
            if (const int other = across(adjacent, level.label, pin, t, k); other >= 0)
                reach(other, d + (centre.row(t) - centre.row(other)).norm());
    }
    return distance;
}

}  // namespace

std::vector<std::vector<int>> strain_cores(const TriMesh& mesh, const Adjacency& adjacent, const PatchLevel& level,
                                           const std::vector<int>& pin, bool open_edges_count, double share) {
    const std::vector<double> distance = border_distances(mesh, adjacent, level, pin, open_edges_count);
    std::vector<std::vector<int>> core(level.patches.size());
    for (std::size_t p = 0; p < level.patches.size(); ++p) {
        double inradius = 0;
        for (const int t : level.patches[p].triangles)
            if (pin[t] == free_prism) inradius = std::max(inradius, distance[t]);
        for (const int t : level.patches[p].triangles)
            if (pin[t] == free_prism && (inradius == unreached || distance[t] > share * inradius)) core[p].push_back(t);
    }
    return core;
}

}  // namespace strake
