#include "core/error.hpp"
#include "core/mesh/point_tree.hpp"
#include "core/repair/open_vertices.hpp"
#include "core/repair/surface_parts.hpp"

#include <algorithm>
#include <map>

namespace strake::mending {
namespace {

/// A vertex that lies on an open edge between its ends.
struct Junction {
    double along;  ///< in (0, 1) from the edge's first vertex
    int vertex;
    double distance;
};

/// Per triangle and side the junctions on it.
using Junctions = std::map<std::pair<int, int>, std::vector<Junction>>;

Junctions find_junctions(const TriMesh& mesh, const Adjacency& adjacent, double tolerance) {
    const OpenVertices open = open_vertices(mesh, adjacent);
    const PointTree tree(open.points);
    std::vector<int> found;
    Junctions junctions;
    std::size_t left = most_looked_at_for_cracks;
    for (int t = 0; t < mesh.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k) {
            if (adjacent.edge_triangles[adjacent.triangle_edges(t, k)].size() != 1) continue;
            const int a = mesh.triangles(t, k), b = mesh.triangles(t, (k + 1) % 3), c = mesh.triangles(t, (k + 2) % 3);
            const Eigen::Vector3d pa = mesh.vertices.row(a), pb = mesh.vertices.row(b), side = pb - pa;
            if (!(side.norm() > 2 * tolerance)) continue;
            tree.within(0.5 * (pa + pb), 0.5 * side.norm() + tolerance, found);
            if (found.size() > left) return junctions;
            left -= found.size();
            for (const int i : found) {
                const int v = open.numbers[i];
                const Eigen::Vector3d p = mesh.vertices.row(v);
                if (v == a || v == b || v == c || (p - pa).norm() <= tolerance || (p - pb).norm() <= tolerance)
                    continue;
                const double along = (p - pa).dot(side) / side.squaredNorm();
                const double distance = (p - pa - along * side).norm();
                if (along > 0 && along < 1 && distance <= tolerance) junctions[{t, k}].push_back({along, v, distance});
            }
        }
    return junctions;
}

/// Cuts one side of a triangle at its junctions: a fan from the opposite corner.
void cut_sides(Surface& surface, Junctions& junctions) {
    TriMesh& mesh = surface.mesh;
    std::vector<std::array<int, 3>> fresh;
    std::vector<int> source, group;
    std::vector<char> is_cut(static_cast<std::size_t>(mesh.num_triangles()));
    for (auto& [side, on] : junctions) {
        const int t = side.first, k = side.second;
        if (std::exchange(is_cut[t], 1)) continue;  // another side of it: in the next round
        std::sort(on.begin(), on.end(), [](const Junction& x, const Junction& y) {
            return std::tie(x.along, x.vertex) < std::tie(y.along, y.vertex);
        });
        int from = mesh.triangles(t, k);
        const int to = mesh.triangles(t, (k + 1) % 3), apex = mesh.triangles(t, (k + 2) % 3);
        const auto triangle = [&](int a, int b) {  // the corners in the places of the old ones
            std::array<int, 3> corners{};
            corners[k] = a, corners[(k + 1) % 3] = b, corners[(k + 2) % 3] = apex;
            return corners;
        };
        for (std::size_t i = 0; i < on.size(); ++i) {
            const int next = on[i].vertex;
            if (i == 0)
                mesh.triangles(t, (k + 1) % 3) = next;
            else
                fresh.push_back(triangle(from, next));
            surface.items.push_back({RepairKind::crack, surface.input_vertex(next), surface.source[t],
                                     mesh.vertices.row(next), on[i].distance, 1,
                                     text("triangle ", surface.source[t], " split at vertex ", next, ", ",
                                          on[i].distance, " beside its edge")});
            from = next;
        }
        fresh.push_back(triangle(from, to));
        for (std::size_t i = 0; i < on.size(); ++i) {
            source.push_back(surface.source[t]);
            if (!mesh.group.empty()) group.push_back(mesh.group[t]);
        }
    }
    surface.append(fresh, source, group);
}

/// Open vertices within the tolerance become one, unless an edge joins them: that would take triangles away.
bool merge_vertices(Surface& surface, double tolerance) {
    TriMesh& mesh = surface.mesh;
    const Adjacency adjacent = adjacency(mesh);
    std::vector<int> onto = near_vertices(mesh.vertices, tolerance, open_vertices(mesh, adjacent).is_open);
    std::vector<char> refused(onto.size());
    for (int t = 0; t < mesh.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k) {
            const int a = mesh.triangles(t, k), b = mesh.triangles(t, (k + 1) % 3);
            if (a != b && onto[a] == onto[b]) refused[onto[a] == a ? b : a] = 1;
        }
    bool any = false;
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        if (refused[v]) onto[v] = v;
        if (onto[v] == v) continue;
        any = true;
        const double apart = (mesh.vertices.row(v) - mesh.vertices.row(onto[v])).norm();
        surface.items.push_back({RepairKind::crack, surface.input_vertex(v), -1, mesh.vertices.row(onto[v]), apart, 0,
                                 text("vertex ", v, " onto vertex ", onto[v], ", ", apart, " apart")});
    }
    for (int i = 0; i < mesh.triangles.size(); ++i) mesh.triangles.data()[i] = onto[mesh.triangles.data()[i]];
    return any;
}

}  // namespace

void close_cracks(Surface& surface, double tolerance) {
    merge_vertices(surface, tolerance);
    for (int round = 0; round < 20; ++round) {
        const Adjacency adjacent = adjacency(surface.mesh);
        Junctions junctions = find_junctions(surface.mesh, adjacent, tolerance);
        if (junctions.empty()) return;
        cut_sides(surface, junctions);
    }
}

}  // namespace strake::mending
