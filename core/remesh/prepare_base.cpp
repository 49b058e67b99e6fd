#include "core/remesh/prepare_base.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "core/remesh/features.hpp"
#include "core/remesh/normals.hpp"
#include "core/remesh/order.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace strake {
namespace {

using Eigen::Vector3d;

void check(const TriMesh& mesh) {
    for (int i = 0; i < mesh.triangles.size(); ++i) {
        const int v = mesh.triangles.data()[i];
        if (v < 0 || v >= mesh.num_vertices() || !mesh.vertices.row(v).allFinite())
            throw InvalidInput(text("remesh: triangle ", i / 3, " has vertex ", v, ", which is not one of ",
                                    mesh.num_vertices(), " finite vertices"));
    }
}

void join_halves(const Adjacency& adjacent, BaseSurface& base) {
    const int m = static_cast<int>(base.tri.size());
    base.twin.assign(3 * m, -1);
    std::vector<int> half(adjacent.num_edges(), -1);
    for (int h = 0; h < 3 * m; ++h) {
        const int e = adjacent.triangle_edges(h / 3, h % 3);
        if (!adjacent.is_regular(e)) continue;
        if (half[e] < 0) {
            half[e] = h;
        } else {
            base.twin[h] = half[e];
            base.twin[half[e]] = h;
        }
    }
}

/// Gives every fan of triangles around a vertex a point of its own, the first of them the vertex' number.
void separate_fans(int num_vertices, BaseSurface& base) {
    const int halves = static_cast<int>(base.twin.size());
    std::vector<char> done(halves, 0), taken(num_vertices, 0);
    base.first_half.assign(num_vertices, -1);
    for (int start = 0; start < halves; ++start) {
        if (done[start]) continue;
        int first = start;  // turn back to where the fan begins
        while (base.twin[first] >= 0) {
            first = base.next(base.twin[first]);
            if (first == start) break;
        }
        int v = base.from(start);
        if (taken[v]) {
            base.points.push_back(base.points[v]);
            base.origin.push_back(v);
            base.first_half.push_back(-1);
            v = static_cast<int>(base.points.size()) - 1;
        } else {
            taken[v] = 1;
        }
        base.first_half[v] = first;
        for (int h = first; h >= 0 && !done[h];) {
            done[h] = 1;
            base.tri[h / 3][h % 3] = v;
            h = base.twin[base.prev(h)];
        }
    }
}

/// Means of the normals around each point, weighted by angle, not across features.
void find_corner_normals(const Points& angles, BaseSurface& base) {
    const int halves = static_cast<int>(base.twin.size());
    base.corner_normal.assign(halves, Vector3d::Zero());
    std::vector<char> done(halves, 0);
    for (int start = 0; start < halves; ++start) {
        if (done[start]) continue;
        int first = start;
        while (!base.barrier[first]) {
            first = base.next(base.twin[first]);
            if (first == start) break;
        }
        Vector3d sum = Vector3d::Zero();
        double whole = 0;
        const auto walk = [&](auto&& visit) {
            for (int h = first;;) {
                visit(h);
                if (base.barrier[base.prev(h)]) return;
                h = base.twin[base.prev(h)];
                if (h == first) return;
            }
        };
        walk([&](int h) {
            const double angle = angles(h / 3, h % 3);
            sum += angle * base.normal[h / 3];
            whole += angle;
            done[h] = 1;
        });
        const double length = sum.norm();
        const bool is_tip = length < 0.9 * whole;  // of a cone: the mean differs from the normals of all its triangles
        walk([&](int h) { base.corner_normal[h] = is_tip ? base.normal[h / 3] : Vector3d(sum / length); });
    }
}

void number_patches(BaseSurface& base) {
    base.patch.assign(base.tri.size(), -1);
    std::vector<int> stack;
    int count = 0;
    for (int seed = 0; seed < static_cast<int>(base.tri.size()); ++seed) {
        if (base.patch[seed] >= 0) continue;
        base.patch[seed] = count;
        stack.assign(1, seed);
        while (!stack.empty()) {
            const int t = stack.back();
            stack.pop_back();
            for (int h = 3 * t; h < 3 * t + 3; ++h) {
                if (base.barrier[h] || base.patch[base.twin[h] / 3] >= 0) continue;
                base.patch[base.twin[h] / 3] = count;
                stack.push_back(base.twin[h] / 3);
            }
        }
        ++count;
    }
}

}  // namespace

BaseSurface base_surface(const TriMesh& given, double angle, double edge_length, const std::vector<char>& frozen) {
    check(given);
    const TriMesh mesh = in_order_of_space(given);
    const Adjacency adjacent = adjacency(mesh);
    const Points angles = corner_angles(mesh);
    BaseSurface base;
    base.points.reserve(mesh.num_vertices()), base.origin.reserve(mesh.num_vertices());
    base.tri.reserve(mesh.num_triangles());
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        base.points.emplace_back(mesh.vertices.row(v));
        base.origin.push_back(v);
    }
    for (int t = 0; t < mesh.num_triangles(); ++t)
        base.tri.push_back({mesh.triangles(t, 0), mesh.triangles(t, 1), mesh.triangles(t, 2)});
    base.group = mesh.group;
    base.diagonal = box_diagonal(mesh);
    join_halves(adjacent, base);
    separate_fans(mesh.num_vertices(), base);
    find_normals(base);
    if (!(base.area > 0) || !std::isfinite(base.area))
        throw InvalidInput(text("remesh: ", given.num_triangles(), " triangles of total area ", base.area));
    base.edge_length = edge_length > 0 ? edge_length : base.mean_edge;
    level_slivers(angle, base);
    find_features(mesh, adjacent, angles, angle, frozen, base);
    number_patches(base);
    find_corner_normals(angles, base);
    base.tree = TriangleTree(base.points, base.tri, std::min(4 * base.mean_edge, 16 * base.edge_length));
    return base;
}

}  // namespace strake
