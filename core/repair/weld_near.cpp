#include "core/error.hpp"
#include "core/mesh/point_tree.hpp"
#include "core/mesh/weld.hpp"
#include "core/repair/surface_parts.hpp"

#include <numeric>

namespace strake::mending {
namespace {

std::vector<int> equal_vertices(const Points& points, const std::vector<char>& marked) {
    const std::vector<int> number = equal_points(points);
    std::vector<int> first(number.size(), -1), representative(number.size());
    for (std::size_t v = 0; v < number.size(); ++v) {
        representative[v] = static_cast<int>(v);
        if (!marked.empty() && !marked[v]) continue;
        int& seen = first[number[v]];
        if (seen < 0) seen = static_cast<int>(v);
        representative[v] = seen;
    }
    return representative;
}

/// Triangles that have lost a corner.
std::vector<char> collapsed_triangles(const Triangles& triangles) {
    std::vector<char> is_gone(static_cast<std::size_t>(triangles.rows()));
    for (int t = 0; t < triangles.rows(); ++t)
        is_gone[t] = triangles(t, 0) == triangles(t, 1) || triangles(t, 1) == triangles(t, 2) ||
                     triangles(t, 2) == triangles(t, 0);
    return is_gone;
}

}  // namespace

std::vector<int> near_vertices(const Points& points, double tolerance, const std::vector<char>& marked) {
    if (!(tolerance > 0)) return equal_vertices(points, marked);
    std::vector<int> representative(static_cast<std::size_t>(points.rows()), -1), chosen, found;
    for (int v = 0; v < points.rows(); ++v)
        if (marked.empty() || marked[v]) chosen.push_back(v);
    Points some(static_cast<Eigen::Index>(chosen.size()), 3);
    for (std::size_t i = 0; i < chosen.size(); ++i) some.row(static_cast<Eigen::Index>(i)) = points.row(chosen[i]);
    const PointTree tree(some);
    for (const int v : chosen) {
        if (representative[v] >= 0) continue;
        representative[v] = v;
        tree.within(points.row(v), tolerance, found);
        for (const int i : found)
            if (representative[chosen[i]] < 0) representative[chosen[i]] = v;
    }
    for (int v = 0; v < points.rows(); ++v)
        if (representative[v] < 0) representative[v] = v;
    return representative;
}

void weld(Surface& surface, double tolerance) {
    TriMesh& mesh = surface.mesh;
    const std::vector<int> onto = near_vertices(mesh.vertices, tolerance, {});
    std::vector<char> is_used(onto.size());
    for (int i = 0; i < mesh.triangles.size(); ++i) is_used[mesh.triangles.data()[i]] = 1;
    const std::vector<char> had_fewer = collapsed_triangles(mesh.triangles);
    for (int i = 0; i < mesh.triangles.size(); ++i) mesh.triangles.data()[i] = onto[mesh.triangles.data()[i]];
    std::vector<char> is_gone = collapsed_triangles(mesh.triangles);
    std::vector<int> lost(onto.size());
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        if (had_fewer[t]) is_gone[t] = 0;  // was so before: for `degenerate`
        if (is_gone[t]) ++lost[mesh.triangles(t, 0)];
    }
    for (std::size_t v = 0; v < onto.size(); ++v) {
        const int kept = onto[v];
        if (kept == static_cast<int>(v) || !is_used[v]) continue;
        const double apart = (mesh.vertices.row(static_cast<int>(v)) - mesh.vertices.row(kept)).norm();
        surface.items.push_back({RepairKind::weld, static_cast<int>(v), -1, mesh.vertices.row(kept), apart,
                                 std::exchange(lost[kept], 0),
                                 text("vertex ", v, " onto vertex ", kept, ", ", apart, " apart")});
    }
    surface.remove(is_gone);
}

}  // namespace strake::mending
