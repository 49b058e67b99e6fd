#include "core/remesh/base_surface.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "core/remesh/features.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

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

/// The input without triangles that repeat a corner.
TriMesh without_repeated_corners(const TriMesh& mesh) {
    const auto is_good = [&](int t) {
        const int a = mesh.triangles(t, 0), b = mesh.triangles(t, 1), c = mesh.triangles(t, 2);
        return a != b && b != c && c != a;
    };
    TriMesh result;
    result.vertices = mesh.vertices;
    result.triangles.resize(mesh.num_triangles(), 3);
    int count = 0;
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        if (!is_good(t)) continue;
        result.triangles.row(count++) = mesh.triangles.row(t);
        if (!mesh.group.empty()) result.group.push_back(mesh.group[t]);
    }
    result.triangles.conservativeResize(count, 3);
    return result;
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

/// Of the triangles beside t whose normals are known, the one whose normal agrees best with those of the others and
/// with that of t itself, as far as that means anything; -1: none. Across a crease along its longest side, a sliver
/// would turn the crease's line to its apex.
int likest_beside(const BaseSurface& base, const std::vector<char>& known, int t, int fewest) {
    int best = -1, count = 0;
    double best_fit = 0;
    for (int h = 3 * t; h < 3 * t + 3; ++h) {
        const int beside = base.twin[h] >= 0 ? base.twin[h] / 3 : -1;
        if (beside < 0 || !known[beside]) continue;
        ++count;
        double fit = base.normal[beside].dot(base.normal[t]);
        for (int g = 3 * t; g < 3 * t + 3; ++g)
            if (g != h && base.twin[g] >= 0 && known[base.twin[g] / 3])
                fit += base.normal[beside].dot(base.normal[base.twin[g] / 3]);
        if (best >= 0 && !(fit > best_fit)) continue;
        best = beside;
        best_fit = fit;
    }
    return count >= fewest ? best : -1;
}

/// Unit normals; a triangle without a reliable one has that of one beside it.
void find_normals(BaseSurface& base) {
    const int m = static_cast<int>(base.tri.size());
    base.normal.resize(m);
    std::vector<int> flat;
    std::vector<char> known(m, 1);
    for (int t = 0; t < m; ++t) {
        const Vector3d a = base.points[base.tri[t][0]], b = base.points[base.tri[t][1]],
                       c = base.points[base.tri[t][2]];
        const Vector3d n = (b - a).cross(c - a);
        const double longest2 = std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
        const double twice_area = n.norm();
        base.area += 0.5 * twice_area;
        base.mean_edge += (b - a).norm() + (c - b).norm() + (a - c).norm();
        // Thinner than 1e-5 of the diagonal: its normal is noise, and would make a crease of each of its long sides.
        known[t] = twice_area > std::max(1e-9 * longest2, 1e-5 * base.diagonal * std::sqrt(longest2));
        base.normal[t] = twice_area > 0 ? Vector3d(n / twice_area) : Vector3d::Zero();
        if (!known[t]) flat.push_back(t);
    }
    base.mean_edge /= std::max(3 * m, 1);
    for (int fewest = 2, round = 0; round < 16 && !flat.empty() && fewest > 0; ++round) {
        std::vector<int> left;
        std::vector<std::pair<int, int>> taken;
        for (const int t : flat) {
            const int like = likest_beside(base, known, t, fewest);
            if (like >= 0)
                taken.push_back({t, like});
            else
                left.push_back(t);
        }
        for (const auto& [t, like] : taken) {
            base.normal[t] = base.normal[like];
            known[t] = 1;
        }
        fewest = taken.empty() ? fewest - 1 : 2;
        flat.swap(left);
    }
}

/// A sliver that stands off from all triangles beside it by more than these do from each other is noise, as of a scan
/// or a cut, and makes no crease: it takes the normal of one of them, too.
void level_folded_slivers(BaseSurface& base, double angle) {
    constexpr double thin = 0.05;  // of its length, and of the wanted one
    const std::vector<char> known(base.tri.size(), 1);
    std::vector<std::pair<int, int>> taken;
    for (int t = 0; t < static_cast<int>(base.tri.size()); ++t) {
        const auto& [a, b, c] = base.tri[t];
        const Vector3d u = base.points[b] - base.points[a], w = base.points[c] - base.points[a];
        const double longest2 = std::max({u.squaredNorm(), w.squaredNorm(), (u - w).squaredNorm()});
        const double height = longest2 > 0 ? u.cross(w).norm() / std::sqrt(longest2) : 0;
        if (!(height < thin * std::min(base.edge_length, std::sqrt(longest2)))) continue;
        std::vector<int> beside;
        for (int h = 3 * t; h < 3 * t + 3; ++h)
            if (base.twin[h] >= 0) beside.push_back(base.twin[h] / 3);
        if (beside.size() < 2) continue;
        double nearest = std::numbers::pi, apart = angle;
        for (std::size_t i = 0; i < beside.size(); ++i) {
            nearest = std::min(nearest, dihedral(base.normal[t], base.normal[beside[i]]));
            for (std::size_t j = 0; j < i; ++j)
                apart = std::max(apart, dihedral(base.normal[beside[i]], base.normal[beside[j]]));
        }
        if (nearest > apart) taken.push_back({t, likest_beside(base, known, t, 1)});
    }
    std::vector<Vector3d> normals;
    for (const auto& [t, like] : taken) normals.push_back(base.normal[like]);
    for (std::size_t i = 0; i < taken.size(); ++i) base.normal[taken[i].first] = normals[i];
}

/// Means of the normals around each point, weighted by angle, not across features.
void find_corner_normals(BaseSurface& base) {
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
        const Vector3d x = base.points[base.from(start)];
        const auto walk = [&](auto&& visit) {
            for (int h = first;;) {
                visit(h);
                if (base.barrier[base.prev(h)]) return;
                h = base.twin[base.prev(h)];
                if (h == first) return;
            }
        };
        walk([&](int h) {
            const Vector3d u = base.points[base.from(base.next(h))] - x, w = base.points[base.from(base.prev(h))] - x;
            const double angle = std::atan2(u.cross(w).norm(), u.dot(w));
            sum += angle * base.normal[h / 3];
            whole += angle;
            done[h] = 1;
        });
        const double length = sum.norm();
        const bool is_tip = length < 0.9 * whole;  // of a cone: the mean is the normal of none of its triangles
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
    const TriMesh mesh = without_repeated_corners(given);
    const Adjacency adjacent = adjacency(mesh);
    BaseSurface base;
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
    level_folded_slivers(base, angle);
    find_features(mesh, adjacent, angle, frozen, base);
    number_patches(base);
    find_corner_normals(base);
    base.tree = TriangleTree(base.points, base.tri, std::min(4 * base.mean_edge, 16 * base.edge_length));
    return base;
}

}  // namespace strake
