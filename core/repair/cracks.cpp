#include "core/error.hpp"
#include "core/mesh/point_tree.hpp"
#include "core/repair/one_sided.hpp"
#include "core/repair/open_vertices.hpp"
#include "core/repair/surface_parts.hpp"

#include <algorithm>
#include <map>
#include <numeric>

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
    std::size_t left = max_looked_at_for_cracks;
    for (int t = 0; t < mesh.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k) {
            if (adjacent.edge_triangles[adjacent.triangle_edges(t, k)].size() != 1) continue;
            const int a = mesh.triangles(t, k), b = mesh.triangles(t, (k + 1) % 3), c = mesh.triangles(t, (k + 2) % 3);
            const Eigen::Vector3d pa = mesh.vertices.row(a), pb = mesh.vertices.row(b), side = pb - pa;
            if (!(side.norm() > 2 * tolerance)) continue;
            tree.near_segment(pa, pb, tolerance, found);
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

/// Cuts one side of a triangle at its junctions: a fan from the opposite corner. @return per triangle the one before.
std::vector<int> cut_sides(Surface& surface, Junctions& junctions) {
    TriMesh& mesh = surface.mesh;
    std::vector<std::array<int, 3>> fresh;
    std::vector<int> source, group, parent(static_cast<std::size_t>(mesh.num_triangles()));
    std::iota(parent.begin(), parent.end(), 0);
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
            parent.push_back(t);
            if (!mesh.group.empty()) group.push_back(mesh.group[t]);
        }
    }
    surface.append(fresh, source, group);
    return parent;
}

TriMesh with_corners_onto(const TriMesh& mesh, const std::vector<int>& onto) {
    TriMesh result = mesh;
    for (int i = 0; i < result.triangles.size(); ++i) result.triangles.data()[i] = onto[result.triangles.data()[i]];
    return result;
}

/// Undoes joins that would make a sheet one-sided, for example of two adjacent lids: no orientation would exist.
void keep_two_sides(const TriMesh& mesh, const Adjacency& adjacent, std::vector<int>& onto) {
    const Joined before(adjacent);
    std::vector<int> parent(static_cast<std::size_t>(mesh.num_triangles()));
    std::iota(parent.begin(), parent.end(), 0);
    for (int round = 0; round < 10; ++round) {
        const Adjacency after = adjacency(with_corners_onto(mesh, onto));
        const std::vector<int> bad = before.one_sided(after, parent);
        if (bad.empty()) return;
        std::vector<char> is_end(onto.size());
        for (const int e : bad)
            for (const int v : after.edges[e]) is_end[v] = 1;
        for (std::size_t v = 0; v < onto.size(); ++v)
            if (is_end[onto[v]]) onto[v] = static_cast<int>(v);
    }
}

/// Merges open vertices within the tolerance unless an edge joins them: merging these would remove triangles.
void merge_vertices(Surface& surface, double tolerance) {
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
        any = any || onto[v] != v;
    }
    if (!any) return;
    keep_two_sides(mesh, adjacent, onto);
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        if (onto[v] == v) continue;
        const double apart = (mesh.vertices.row(v) - mesh.vertices.row(onto[v])).norm();
        surface.items.push_back({RepairKind::crack, surface.input_vertex(v), -1, mesh.vertices.row(onto[v]), apart, 0,
                                 text("vertex ", v, " onto vertex ", onto[v], ", ", apart, " apart")});
    }
    mesh = with_corners_onto(mesh, onto);
}

}  // namespace

void close_cracks(Surface& surface, double tolerance) {
    merge_vertices(surface, tolerance);
    std::vector<char> is_left;  // per triangle: cut, it would join the two sides of a sheet
    for (int round = 0; round < 20; ++round) {
        const Adjacency adjacent = adjacency(surface.mesh);
        Junctions junctions = find_junctions(surface.mesh, adjacent, tolerance);
        is_left.resize(static_cast<std::size_t>(surface.mesh.num_triangles()));
        std::erase_if(junctions, [&](const auto& item) { return is_left[item.first.first] != 0; });
        if (junctions.empty()) return;
        Surface cut = surface;
        const std::vector<int> parent = cut_sides(cut, junctions);
        const Adjacency after = adjacency(cut.mesh);
        const std::vector<int> bad = Joined(adjacent).one_sided(after, parent);
        for (const int e : bad)
            for (const int t : after.edge_triangles[e]) is_left[parent[t]] = 1;
        if (bad.empty()) surface = std::move(cut);
    }
}

}  // namespace strake::mending
