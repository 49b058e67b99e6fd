#include "core/remesh/base_surface.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "core/patches/features.hpp"

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

/// Unit normals; of a triangle without a reliable one that of the neighbour across its longest edge.
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
    for (int round = 0; round < 8 && !flat.empty(); ++round) {
        std::vector<int> left;
        for (const int t : flat) {
            int longest = 3 * t;
            const auto length2 = [&](int h) {
                return (base.points[base.from(base.next(h))] - base.points[base.from(h)]).squaredNorm();
            };
            for (int h = 3 * t + 1; h < 3 * t + 3; ++h)
                if (length2(h) > length2(longest)) longest = h;
            const int beside = base.twin[longest] >= 0 ? base.twin[longest] / 3 : -1;
            if (beside >= 0 && known[beside]) {
                base.normal[t] = base.normal[beside];
                known[t] = 1;
            } else {
                left.push_back(t);
            }
        }
        flat.swap(left);
    }
}

/// Kind per edge of the input, as `int`; -1: no feature.
std::vector<int> feature_kinds(const TriMesh& mesh, const Adjacency& adjacent, const std::vector<VertexFeature>& tensor,
                               const BaseSurface& base, double angle) {
    std::vector<int> kind(adjacent.num_edges(), -1);
    for (int h = 0; h < static_cast<int>(base.twin.size()); ++h) {
        const int e = adjacent.triangle_edges(h / 3, h % 3);
        if (base.twin[h] < 0) {
            const bool open = adjacent.edge_triangles[e].size() == 1;
            kind[e] = static_cast<int>(open ? FeatureKind::boundary : FeatureKind::kept);
            continue;
        }
        if (h > base.twin[h]) continue;
        const double turn = dihedral(base.normal[h / 3], base.normal[base.twin[h] / 3]);
        const auto [a, b] = adjacent.edges[e];
        const bool is_crease = turn >= angle - angle_slack;
        if (is_crease)
            kind[e] = static_cast<int>(FeatureKind::crease);
        else if (!mesh.group.empty() && mesh.group[h / 3] != mesh.group[base.twin[h] / 3])
            kind[e] = static_cast<int>(FeatureKind::border);
        (void)a, (void)b, (void)tensor;
    }
    return kind;
}

/// Strings features to curves between the points that stay, and closed ones.
class CurveWalk {
public:
    explicit CurveWalk(BaseSurface& base) : base_(base), at_(base.points.size(), {-1, -1}) {
        for (int f = 0; f < static_cast<int>(base.features.size()); ++f)
            for (const int v : base.features[f].v) (at_[v][0] < 0 ? at_[v][0] : at_[v][1]) = f;
    }
    void run() {
        std::vector<char>& used = used_;
        used.assign(base_.features.size(), 0);
        for (const bool closed : {false, true})
            for (int f = 0; f < static_cast<int>(base_.features.size()); ++f)
                for (int end = 0; end < 2; ++end)
                    if (!used[f] && (closed || base_.role[base_.features[f].v[end]] == VertexRole::fixed)) walk(f, end);
    }

private:
    void walk(int f, int end) {
        int v = base_.features[f].v[end];
        const int start = v;
        std::vector<Vector3d> points{base_.points[v]};
        std::vector<int> edges, triangles;
        while (true) {
            used_[f] = 1;
            FeatureEdge& edge = base_.features[f];
            if (edge.v[0] != v) std::swap(edge.v[0], edge.v[1]);
            edges.push_back(f);
            triangles.push_back(half_of_[f] / 3);
            v = edge.v[1];
            points.push_back(base_.points[v]);
            if (base_.role[v] == VertexRole::fixed || v == start) break;
            f = at_[v][0] == f ? at_[v][1] : at_[v][0];
        }
        const bool closed = v == start && base_.role[v] != VertexRole::fixed;
        const int curve = base_.curves.add(points, triangles, closed);
        double s = 0;
        for (std::size_t i = 0; i < edges.size(); ++i) {
            FeatureEdge& edge = base_.features[edges[i]];
            edge.curve = curve;
            edge.s[0] = s;
            s += (points[i + 1] - points[i]).norm();
            edge.s[1] = s;
        }
    }

    BaseSurface& base_;
    std::vector<std::array<int, 2>> at_;  ///< features at a ridge point
    std::vector<char> used_;

public:
    std::vector<int> half_of_;  ///< a half-edge of each feature
};

std::vector<int> collect_features(const Adjacency& adjacent, const std::vector<int>& kind, BaseSurface& base) {
    const int halves = static_cast<int>(base.twin.size());
    base.feature_of.assign(halves, -1);
    base.barrier.assign(halves, 0);
    std::vector<int> half_of;
    for (int h = 0; h < halves; ++h) {
        const int k = kind[adjacent.triangle_edges(h / 3, h % 3)];
        if (k < 0) continue;
        base.barrier[h] = 1;
        if (base.twin[h] >= 0 && base.twin[h] < h) {
            base.feature_of[h] = base.feature_of[base.twin[h]];
            continue;
        }
        base.feature_of[h] = static_cast<int>(base.features.size());
        base.features.push_back({-1, static_cast<FeatureKind>(k), {base.from(h), base.from(base.next(h))}, {0, 0}});
        half_of.push_back(h);
    }
    return half_of;
}

/// Corners by the tensor, ends and meetings of features, kinks of curves, and whatever lies at a kept edge or in
/// several fans stays.
void assign_roles(const std::vector<VertexFeature>& tensor, double angle, BaseSurface& base) {
    const std::size_t n = base.points.size();
    base.role.assign(n, VertexRole::free);
    std::vector<int> count(n, 0);
    std::vector<std::array<int, 2>> beside(n, {-1, -1}), kinds(n, {-1, -1});
    std::vector<char> stays(n, 0);
    for (std::size_t v = tensor.size(); v < n; ++v) stays[v] = stays[base.origin[v]] = 1;
    for (const FeatureEdge& edge : base.features)
        for (int end = 0; end < 2; ++end) {
            const int v = edge.v[end];
            if (edge.kind == FeatureKind::kept) stays[v] = 1;
            if (count[v] < 2) {
                beside[v][count[v]] = edge.v[1 - end];
                kinds[v][count[v]] = static_cast<int>(edge.kind);
            }
            ++count[v];
        }
    for (std::size_t v = 0; v < n; ++v) {
        const bool is_corner = classify(tensor[base.origin[v]], angle) == VertexClass::corner;
        bool fixed = stays[v] || is_corner || (count[v] != 0 && count[v] != 2);
        if (count[v] == 2 && !fixed) {
            const Vector3d before = base.points[v] - base.points[beside[v][0]],
                           after = base.points[beside[v][1]] - base.points[v];
            fixed = kinds[v][0] != kinds[v][1] || dihedral(before, after) >= angle - angle_slack;
        }
        base.role[v] = fixed ? VertexRole::fixed : count[v] == 2 ? VertexRole::ridge : VertexRole::free;
    }
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
            sum += std::atan2(u.cross(w).norm(), u.dot(w)) * base.normal[h / 3];
            done[h] = 1;
        });
        const double length = sum.norm();
        walk([&](int h) { base.corner_normal[h] = length > 1e-3 ? Vector3d(sum / length) : base.normal[h / 3]; });
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

BaseSurface base_surface(const TriMesh& given, double angle) {
    check(given);
    const TriMesh mesh = without_repeated_corners(given);
    const Adjacency adjacent = adjacency(mesh);
    const std::vector<VertexFeature> tensor = quadric_metric_tensor(mesh, adjacent);
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
    const std::vector<int> half_of =
        collect_features(adjacent, feature_kinds(mesh, adjacent, tensor, base, angle), base);
    assign_roles(tensor, angle, base);
    CurveWalk walk(base);
    walk.half_of_ = half_of;
    walk.run();
    number_patches(base);
    find_corner_normals(base);
    base.tree = TriangleTree(base.points, base.tri, 4 * base.mean_edge);
    return base;
}

std::array<double, 3> weights_at(const BaseSurface& base, int t, const Vector3d& x) {
    const Vector3d &a = base.points[base.tri[t][0]], &b = base.points[base.tri[t][1]], &c = base.points[base.tri[t][2]];
    const Vector3d n = (b - a).cross(c - a);
    const double whole = n.squaredNorm();
    if (!(whole > 0)) return {1, 0, 0};
    const double wb = std::clamp((c - a).cross(a - x).dot(n) / whole, 0.0, 1.0),
                 wc = std::clamp((a - x).cross(b - a).dot(n) / whole, 0.0, 1.0 - wb);
    return {1 - wb - wc, wb, wc};
}

Vector3d normal_at(const BaseSurface& base, int t, const Vector3d& x) {
    const auto [wa, wb, wc] = weights_at(base, t, x);
    const Vector3d n =
        wa * base.corner_normal[3 * t] + wb * base.corner_normal[3 * t + 1] + wc * base.corner_normal[3 * t + 2];
    const double length = n.norm();
    return length > 1e-3 ? Vector3d(n / length) : base.normal[t];
}

namespace {

TrianglePoint closest_of(const BaseSurface& base, int t, const Vector3d& x) {
    return closest_on_triangle(base.points[base.tri[t][0]], base.points[base.tri[t][1]], base.points[base.tri[t][2]],
                               x);
}

/// The best of the triangles around corner `half`, turning both ways until a feature.
struct Step {
    TrianglePoint at;
    int triangle;
    double distance2;
};
void look_around(const BaseSurface& base, const Vector3d& x, int half, Step& best) {
    const auto look = [&](int t) {
        const TrianglePoint p = closest_of(base, t, x);
        const double d2 = (p.point - x).squaredNorm();
        if (d2 < best.distance2) best = {p, t, d2};
    };
    int h = half;
    while (!base.barrier[base.prev(h)]) {
        h = base.twin[base.prev(h)];
        if (h == half) return;
        look(h / 3);
    }
    for (h = half; !base.barrier[h];) {
        h = base.next(base.twin[h]);
        look(h / 3);
    }
}

}  // namespace

Foot project(const BaseSurface& base, const Vector3d& x, int hint, double reach) {
    Step at{closest_of(base, hint, x), hint, 0};
    at.distance2 = (at.at.point - x).squaredNorm();
    bool arrived = false;
    for (int step = 0; step < 40 && !arrived; ++step) {
        if (at.at.side < 0) {
            arrived = true;
        } else if (at.at.side < 3) {
            const int h = 3 * at.triangle + at.at.side;
            if (base.barrier[h]) {
                arrived = true;
            } else {
                const int t = base.twin[h] / 3;
                const TrianglePoint p = closest_of(base, t, x);
                const double d2 = (p.point - x).squaredNorm();
                if (d2 < at.distance2)
                    at = {p, t, d2};
                else
                    arrived = true;
            }
        } else {
            const double before = at.distance2;
            look_around(base, x, 3 * at.triangle + at.at.side - 3, at);
            arrived = !(at.distance2 < before);
        }
    }
    if (arrived && at.distance2 <= reach * reach) return {at.at.point, at.triangle, at.distance2};
    const int t = base.tree.closest(base.points, base.tri, base.patch, base.patch[hint], x, at.distance2);
    if (t >= 0) {
        const Vector3d p = closest_of(base, t, x).point;
        const double d2 = (p - x).squaredNorm();
        if (d2 < at.distance2) return {p, t, d2};
    }
    return {at.at.point, at.triangle, at.distance2};
}

}  // namespace strake
