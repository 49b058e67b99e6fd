#include "core/patches/creases.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <queue>
#include <tuple>

namespace strake {
namespace {

/// Drops creases whose connected chain is shorter than `shortest`.
void drop_short_chains(const Body& body, double shortest, std::vector<char>& crease) {
    const Adjacency& adjacent = body.adjacent();
    std::vector<int> up(body.mesh().num_vertices());
    std::iota(up.begin(), up.end(), 0);
    const auto find = [&](int v) {
        while (up[v] != v) v = up[v] = up[up[v]];
        return v;
    };
    std::vector<double> length(up.size(), 0);
    for (int e = 0; e < adjacent.num_edges(); ++e)
        if (crease[e]) up[find(adjacent.edges[e][0])] = find(adjacent.edges[e][1]);
    for (int e = 0; e < adjacent.num_edges(); ++e)
        if (crease[e]) length[find(adjacent.edges[e][0])] += body.edge_length[e];
    for (int e = 0; e < adjacent.num_edges(); ++e)
        if (crease[e] && adjacent.is_regular(e) && length[find(adjacent.edges[e][0])] < shortest) crease[e] = 0;
}

double distance_to_edge(const Body& body, int t, int e) {
    const Eigen::Vector3d p = body.centroids.row(t), a = body.mesh().vertices.row(body.adjacent().edges[e][0]),
                          b = body.mesh().vertices.row(body.adjacent().edges[e][1]);
    const double l2 = (b - a).squaredNorm();
    const double s = l2 > 0 ? std::clamp((p - a).dot(b - a) / l2, 0.0, 1.0) : 0.0;
    return (p - a - s * (b - a)).norm();
}

/// Straight distance to the nearest crease, propagated from triangle to triangle without crossing one.
std::vector<char> strip_beside(const Body& body, const std::vector<char>& crease, double reach) {
    const Adjacency& adjacent = body.adjacent();
    std::vector<double> distance(body.mesh().num_triangles(), std::numeric_limits<double>::infinity());
    using Entry = std::tuple<double, int, int>;  // distance, triangle, crease edge
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    const auto offer = [&](int t, int e) {
        const double d = distance_to_edge(body, t, e);
        if (d > reach || !(d < distance[t])) return;
        distance[t] = d;
        queue.push({d, t, e});
    };
    for (int e = 0; e < adjacent.num_edges(); ++e)
        if (crease[e])
            for (const int t : adjacent.edge_triangles[e]) offer(t, e);
    while (!queue.empty()) {
        const auto [d, t, source] = queue.top();
        queue.pop();
        if (d > distance[t]) continue;
        for (int k = 0; k < 3; ++k) {
            const int e = adjacent.triangle_edges(t, k);
            if (crease[e]) continue;
            for (const int n : adjacent.edge_triangles[e]) offer(n, source);
        }
    }
    std::vector<char> near(distance.size());
    for (std::size_t t = 0; t < near.size(); ++t) near[t] = distance[t] <= reach;
    return near;
}

}  // namespace

Creases persistent_creases(const Body& body, double tau, double reach) {
    const Adjacency& adjacent = body.adjacent();
    Creases creases;
    creases.edge.resize(adjacent.num_edges());
    for (int e = 0; e < adjacent.num_edges(); ++e)
        creases.edge[e] = adjacent.is_regular(e) ? body.features.dihedral[e] >= tau - angle_slack
                                                 : adjacent.edge_triangles[e].size() > 1;
    drop_short_chains(body, 4 * reach, creases.edge);
    creases.near = strip_beside(body, creases.edge, reach);
    return creases;
}

}  // namespace strake
