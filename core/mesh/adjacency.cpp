#include "core/mesh/adjacency.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace strake {
namespace {

/// A triangle's side: its vertices in ascending order, and where it comes from.
struct Side {
    int a, b, triangle, corner;
    bool forward;  ///< runs from a to b
};

/// By their first vertices, counted; each of these short lists is sorted then.
std::vector<Side> sorted_sides(const TriMesh& mesh) {
    const int m = mesh.num_triangles();
    const auto lower = [&](int t, int k) { return std::min(mesh.triangles(t, k), mesh.triangles(t, (k + 1) % 3)); };
    std::vector<int> begin(mesh.num_vertices() + 1, 0);
    for (int t = 0; t < m; ++t)
        for (int k = 0; k < 3; ++k) ++begin[lower(t, k) + 1];
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<int> next(begin.begin(), begin.end() - 1);
    std::vector<Side> sides(3 * static_cast<std::size_t>(m));
    for (int t = 0; t < m; ++t)
        for (int k = 0; k < 3; ++k) {
            const int u = mesh.triangles(t, k), v = mesh.triangles(t, (k + 1) % 3);
            sides[next[std::min(u, v)]++] = {std::min(u, v), std::max(u, v), t, k, u < v};
        }
    for (int v = 0; v < mesh.num_vertices(); ++v)
        std::sort(sides.begin() + begin[v], sides.begin() + begin[v + 1], [](const Side& x, const Side& y) {
            return std::tie(x.b, x.triangle, x.corner) < std::tie(y.b, y.triangle, y.corner);
        });
    return sides;
}

IntLists triangles_at_vertices(const TriMesh& mesh) {
    IntLists lists;
    lists.begin.assign(mesh.num_vertices() + 1, 0);
    for (int i = 0; i < mesh.triangles.size(); ++i) ++lists.begin[mesh.triangles.data()[i] + 1];
    std::partial_sum(lists.begin.begin(), lists.begin.end(), lists.begin.begin());
    lists.items.resize(lists.begin.back());
    std::vector<int> next(lists.begin.begin(), lists.begin.end() - 1);
    for (int t = 0; t < mesh.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k) lists.items[next[mesh.triangles(t, k)]++] = t;
    return lists;
}

}  // namespace

Adjacency adjacency(const TriMesh& mesh) {
    Adjacency adjacent;
    adjacent.triangle_edges.resize(mesh.num_triangles(), 3);
    const std::vector<Side> sides = sorted_sides(mesh);
    for (std::size_t i = 0; i < sides.size();) {
        const int e = adjacent.num_edges();
        adjacent.edges.push_back({sides[i].a, sides[i].b});
        const std::size_t first = i;
        for (; i < sides.size() && sides[i].a == sides[first].a && sides[i].b == sides[first].b; ++i) {
            adjacent.edge_triangles.items.push_back(sides[i].triangle);
            adjacent.triangle_edges(sides[i].triangle, sides[i].corner) = e;
        }
        adjacent.edge_triangles.begin.push_back(static_cast<int>(i));
        adjacent.misoriented.push_back(i - first == 2 && sides[first].forward == sides[first + 1].forward);
    }
    adjacent.vertex_triangles = triangles_at_vertices(mesh);
    return adjacent;
}

std::vector<int> edge_components(const TriMesh& mesh, const Adjacency& adjacent) {
    std::vector<int> component(mesh.num_triangles(), -1), stack;
    std::vector<char> is_seen(adjacent.num_edges());  // once for all triangles at it: there may be thousands
    int count = 0;
    for (int seed = 0; seed < mesh.num_triangles(); ++seed) {
        if (component[seed] >= 0) continue;
        component[seed] = count;
        stack.assign(1, seed);
        while (!stack.empty()) {
            const int t = stack.back();
            stack.pop_back();
            for (int k = 0; k < 3; ++k) {
                const int e = adjacent.triangle_edges(t, k);
                if (std::exchange(is_seen[e], 1)) continue;
                for (const int n : adjacent.edge_triangles[e])
                    if (component[n] < 0) {
                        component[n] = count;
                        stack.push_back(n);
                    }
            }
        }
        ++count;
    }
    return component;
}

}  // namespace strake
