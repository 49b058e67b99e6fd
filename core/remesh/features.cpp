#include "core/remesh/features.hpp"

#include "core/mesh/geometry.hpp"
#include "core/remesh/working_mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>

namespace strake {
namespace {

using Eigen::Vector3d;

/// Kind per half-edge, as `int`; -1: no feature.
class Kinds {
public:
    Kinds(const TriMesh& mesh, const Adjacency& adjacent, const std::vector<VertexFeature>& tensor, double angle,
          const std::vector<char>& frozen, BaseSurface& base)
        : mesh_(mesh),
          adjacent_(adjacent),
          tensor_(tensor),
          angle_(angle),
          cos_flat_(std::cos(0.99 * angle)),
          frozen_(frozen),
          base_(base),
          kind_(base.twin.size(), -1),
          count_(base.points.size(), 0) {}

    std::vector<int> run() {
        const int halves = static_cast<int>(kind_.size());
        for (int h = 0; h < halves; ++h) {
            const int g = base_.twin[h];
            if (g < 0) {
                const bool open = adjacent_.edge_triangles[adjacent_.triangle_edges(h / 3, h % 3)].size() == 1;
                set(h, open ? FeatureKind::boundary : FeatureKind::kept);
            } else if (h < g) {
                if (!is_flat(h) && turn(h) >= angle_ - angle_slack)
                    set(h, FeatureKind::crease);
                else if (!mesh_.group.empty() && mesh_.group[h / 3] != mesh_.group[g / 3])
                    set(h, FeatureKind::border);
            }
        }
        for (int h = 0; h < halves; ++h)
            if (kind_[h] == static_cast<int>(FeatureKind::crease) && h < base_.twin[h]) go_on(h), go_on(base_.twin[h]);
        hold_ends();
        keep_coincident();
        for (int h = 0; h < halves; ++h)
            if (!frozen_.empty() && frozen_[h / 3]) keep(h);
        std::vector<char> is_feature(halves);
        for (int h = 0; h < halves; ++h) is_feature[h] = kind_[h] >= 0;
        for (const int h : rounded_edges(is_feature, angle_, base_)) set(h, FeatureKind::rounded);
        return std::move(kind_);
    }

private:
    double turn(int h) const { return dihedral(base_.normal[h / 3], base_.normal[base_.twin[h] / 3]); }
    /// Certainly no crease, like most edges.
    bool is_flat(int h) const { return base_.normal[h / 3].dot(base_.normal[base_.twin[h] / 3]) > cos_flat_; }
    int to(int h) const { return base_.from(base_.next(h)); }
    void set(int h, FeatureKind kind) {
        mark(h, kind);
        ++count_[base_.from(h)];
        ++count_[to(h)];
    }
    void keep(int h) { mark(h, FeatureKind::kept); }
    void hold(int h) {
        if (kind_[h] < 0) mark(h, FeatureKind::held);
        if (kind_[h] == static_cast<int>(FeatureKind::crease)) mark(h, FeatureKind::held_crease);
    }
    void mark(int h, FeatureKind kind) {
        kind_[h] = static_cast<int>(kind);
        if (base_.twin[h] >= 0) kind_[base_.twin[h]] = kind_[h];
    }
    /// At an open end of a crease, only the two triangles beside its last edge define its sharpness: they stay
    /// unchanged if acceptable in the result.
    void hold_ends() {
        std::vector<int> ends;
        for (int h = 0; h < static_cast<int>(kind_.size()); ++h)
            if (kind_[h] == static_cast<int>(FeatureKind::crease) && h < base_.twin[h] &&
                std::min(count_[base_.from(h)], count_[to(h)]) == 1 && turn(h) >= angle_ - angle_slack &&
                may_stay(h / 3) && may_stay(base_.twin[h] / 3))
                ends.push_back(h);
        for (const int h : ends)
            for (const int t : {h / 3, base_.twin[h] / 3})
                for (int k = 3 * t; k < 3 * t + 3; ++k) hold(k);
    }
    bool may_stay(int t) const {
        const auto& [a, b, c] = base_.tri[t];
        const Vector3d &x = base_.points[a], &y = base_.points[b], &z = base_.points[c];
        const auto [shortest, longest] = std::minmax({(y - x).norm(), (z - y).norm(), (x - z).norm()});
        constexpr double min_quality = 0.7, min_length = 0.6, max_length = 1.5;
        return shape_quality(x, y, z) > min_quality && shortest > min_length * base_.edge_length &&
               longest < max_length * base_.edge_length;
    }
    /// Parts that touch along coinciding edges, without sharing them, would otherwise separate or overlap.
    void keep_coincident() {
        const std::vector<int> place = places();
        if (place.empty()) return;
        std::map<std::array<int, 2>, int> first;  // feature edges by the places of their ends
        for (int h = 0; h < static_cast<int>(kind_.size()); ++h) {
            if (kind_[h] < 0 || base_.twin[h] > h) continue;
            const int a = place[base_.from(h)], b = place[to(h)];
            const auto [known, is_new] = first.insert({{std::min(a, b), std::max(a, b)}, h});
            if (!is_new) keep(known->second), keep(h);
        }
    }
    /// Number of the place of each point on a feature; empty: no two of them are at one place.
    std::vector<int> places() const {
        std::vector<int> order, place(base_.points.size(), -1);
        for (int h = 0; h < static_cast<int>(kind_.size()); ++h)
            if (kind_[h] >= 0)
                for (const int v : {base_.from(h), to(h)})
                    if (place[v] < 0) {
                        place[v] = 0;
                        order.push_back(v);
                    }
        const auto before = [&](int u, int v) {
            const Eigen::Vector3d &p = base_.points[u], &q = base_.points[v];
            return std::lexicographical_compare(p.data(), p.data() + 3, q.data(), q.data() + 3);
        };
        std::sort(order.begin(), order.end(), before);
        int count = 0;
        for (std::size_t i = 0; i < order.size(); ++i) {
            if (i > 0 && before(order[i - 1], order[i])) ++count;
            place[order[i]] = count;
        }
        if (order.empty() || count + 1 == static_cast<int>(order.size())) place.clear();
        return place;
    }
    bool is_weak(int h) const {
        return base_.twin[h] >= 0 && kind_[h] < 0 && turn(h) >= 0.5 * angle_ - angle_slack &&
               is_nonsmooth(tensor_[base_.origin[base_.from(h)]], angle_) &&
               is_nonsmooth(tensor_[base_.origin[to(h)]], angle_);
    }
    /// From the end of half-edge h, as long as the chain would end there.
    void go_on(int h) {
        while (count_[to(h)] == 1) {
            const Eigen::Vector3d along = base_.points[to(h)] - base_.points[base_.from(h)];
            int best = -1;
            const int first = base_.twin[h];
            for (int g = base_.twin[base_.prev(first)]; g >= 0 && g != first; g = base_.twin[base_.prev(g)]) {
                if (!is_weak(g)) continue;
                const Eigen::Vector3d on = base_.points[to(g)] - base_.points[base_.from(g)];
                if (dihedral(along, on) >= angle_) continue;
                if (best < 0 || turn(g) > turn(best)) best = g;
            }
            if (best < 0) return;
            set(best, FeatureKind::crease);
            h = best;
        }
    }

    const TriMesh& mesh_;
    const Adjacency& adjacent_;
    const std::vector<VertexFeature>& tensor_;
    double angle_, cos_flat_;
    const std::vector<char>& frozen_;
    BaseSurface& base_;
    std::vector<int> kind_, count_;  ///< count_: features at a point
};

/// Joins features to curves between fixed points, and to closed curves.
class CurveWalk {
public:
    CurveWalk(BaseSurface& base, const std::vector<int>& half_of)
        : base_(base), half_of_(half_of), at_(base.points.size(), {-1, -1}) {
        for (int f = 0; f < static_cast<int>(base.features.size()); ++f)
            for (const int v : base.features[f].v) (at_[v][0] < 0 ? at_[v][0] : at_[v][1]) = f;
    }
    void run() {
        used_.assign(base_.features.size(), 0);
        for (const bool closed : {false, true})
            for (int f = 0; f < static_cast<int>(base_.features.size()); ++f)
                for (int end = 0; end < 2; ++end)
                    if (!used_[f] && (closed || base_.role[base_.features[f].v[end]] == VertexRole::fixed))
                        walk(f, end);
    }

private:
    void walk(int f, int end) {
        int v = base_.features[f].v[end];
        const int start = v;
        std::vector<Vector3d> points{base_.points[v]};
        std::vector<int> edges, halves;
        std::vector<double> folds;
        while (true) {
            used_[f] = 1;
            FeatureEdge& edge = base_.features[f];
            if (edge.v[0] != v) std::swap(edge.v[0], edge.v[1]);
            edges.push_back(f);
            const int half = half_of_[f], other = base_.twin[half];
            halves.push_back(half);
            folds.push_back(other >= 0 ? dihedral(area_vector(half / 3), area_vector(other / 3)) : 0);
            v = edge.v[1];
            points.push_back(base_.points[v]);
            if (base_.role[v] == VertexRole::fixed || v == start) break;
            f = at_[v][0] == f ? at_[v][1] : at_[v][0];
        }
        const bool closed = v == start && base_.role[v] != VertexRole::fixed;
        const int curve = base_.curves.add(points, halves, folds, closed);
        double s = 0;
        for (std::size_t i = 0; i < edges.size(); ++i) {
            FeatureEdge& edge = base_.features[edges[i]];
            edge.curve = curve;
            edge.s[0] = s;
            s += (points[i + 1] - points[i]).norm();
            edge.s[1] = s;
        }
    }

    Vector3d area_vector(int t) const {
        const auto& [a, b, c] = base_.tri[t];
        return (base_.points[b] - base_.points[a]).cross(base_.points[c] - base_.points[a]);
    }

    BaseSurface& base_;
    const std::vector<int>& half_of_;     ///< a half-edge of each feature
    std::vector<std::array<int, 2>> at_;  ///< features at a ridge point
    std::vector<char> used_;
};

/// @return a half-edge of each feature.
std::vector<int> collect_features(const std::vector<int>& kind, BaseSurface& base) {
    const int halves = static_cast<int>(base.twin.size());
    base.feature_of.assign(halves, -1);
    base.barrier.assign(halves, 0);
    std::vector<int> half_of;
    for (int h = 0; h < halves; ++h) {
        const int k = kind[h];
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

/// Corners by the tensor, ends and meetings of features, kinks of curves, and vertices at kept edges or with several
/// fans are fixed.
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
            if (is_rigid(edge.kind)) stays[v] = 1;
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
            const bool is_rounded = kinds[v][0] == static_cast<int>(FeatureKind::rounded);
            fixed = kinds[v][0] != kinds[v][1] || (!is_rounded && dihedral(before, after) >= angle - angle_slack);
        }
        base.role[v] = fixed ? VertexRole::fixed : count[v] == 2 ? VertexRole::ridge : VertexRole::free;
    }
}

}  // namespace

void find_features(const TriMesh& mesh, const Adjacency& adjacent, const Points& angles, double angle,
                   const std::vector<char>& frozen, BaseSurface& base) {
    Points normals(mesh.num_triangles(), 3);  // those of slivers would make corners
    for (int t = 0; t < mesh.num_triangles(); ++t) normals.row(t) = base.normal[t];
    const std::vector<VertexFeature> tensor = quadric_metric_tensor(mesh, adjacent, normals, angles, angle);
    const std::vector<int> half_of = collect_features(Kinds(mesh, adjacent, tensor, angle, frozen, base).run(), base);
    assign_roles(tensor, angle, base);
    CurveWalk(base, half_of).run();
}

}  // namespace strake
