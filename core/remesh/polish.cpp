#include "core/remesh/passes.hpp"

#include <algorithm>
#include <limits>
#include <numbers>

/// The finish: what smoothing leaves badly shaped is moved, one vertex after the other, to where the worst triangle
/// around it is best.
namespace strake {
namespace {

using Eigen::Vector3d;

constexpr double well_shaped = 0.76;  ///< no angle below 30 degrees, or above 108
constexpr int most_tries = 12;  ///< of a vertex in a sweep: where hundreds of thin triangles meet, all would ask for it

class Polish {
public:
    Polish(WorkingMesh& mesh, const StepGuard& guard) : mesh_(mesh), guard_(guard) {}

    /// @return how many vertices were moved.
    int run(double below) {
        int count = 0;
        std::vector<int> look;
        for (int t = 0; t < mesh_.num_triangles(); ++t)
            if (mesh_.is_alive(t) && mesh_.quality(t) < below) look.push_back(t);
        const auto is_hopeless = [&](int t) { return mesh_.quality(t) < 0.02; };
        if (4 * std::count_if(look.begin(), look.end(), is_hopeless) > mesh_.num_triangles()) return 0;  // wires
        const std::size_t most = mesh_.num_triangles() / 2;  // it is a finish, and takes its time
        if (look.size() > most) {
            std::stable_sort(look.begin(), look.end(),
                             [&](int t, int u) { return mesh_.quality(t) > mesh_.quality(u); });
            look.resize(most);
        }
        for (int sweep = 0; sweep < 4 && !look.empty(); ++sweep) {
            std::vector<int> tries(mesh_.num_vertices(), 0);
            for (const int t : look)
                for (int k = 0; k < 3; ++k) {
                    const int v = mesh_.corner[3 * t + k];
                    if (++tries[v] <= most_tries) count += improve(v, below);
                }
            std::erase_if(look, [&](int t) { return mesh_.quality(t) >= below; });
        }
        return count;
    }

private:
    struct Place {
        Vector3d point, normal;
        int foot;
        double s;  ///< shift along the curve
    };

    bool improve(int v, double below) {
        if (mesh_.role[v] == VertexRole::fixed || !(worst_now(v) < below)) return false;
        const double start = cost(v, here(v));
        double best = start;
        Place at = here(v);
        const bool is_free = mesh_.role[v] == VertexRole::free;
        const Vector3d n = mesh_.normal[v], u = n.unitOrthogonal(), w = n.cross(u);
        for (double step = 0.2; step > 0.02; step *= 0.5)
            for (bool better = true; better;) {
                better = false;
                for (int i = 0; i < (is_free ? 6 : 2); ++i) {
                    const double angle = i * std::numbers::pi / 3, length = step * mesh_.size[v];
                    Place next;
                    const bool is_there =
                        is_free ? on_surface(v, at, length * (std::cos(angle) * u + std::sin(angle) * w), next)
                                : on_curve(v, at.s + (i == 0 ? length : -length), next);
                    if (!is_there) continue;
                    const double c = cost(v, next);
                    if (c > 0.999 * best) continue;
                    best = c;
                    at = next;
                    better = true;
                }
            }
        if (best > 0.98 * start || (share_ > 0 && sharpens(v, at))) return false;
        put(v, at);
        return true;
    }
    double worst_now(int v) const {
        double quality = 1;
        mesh_.around(v, [&](int h) {
            quality = std::min(quality, mesh_.quality(h / 3));
            return true;
        });
        return quality;
    }

public:
    /// Flips edges that lie off the input by more than `share` of their length, or moves the vertices around them.
    /// @return how many flips and moves brought them nearer.
    int approach(double share, double most_fold) {
        share_ = share;
        cos_fold_ = std::cos(most_fold);
        const std::vector<int> far = farthest_edges();
        std::vector<int> look;
        std::vector<char> is_listed(mesh_.num_vertices(), 0);
        for (const int h : far)
            for (const int v : {mesh_.from(h), mesh_.to(h), mesh_.apex(h), mesh_.apex(mesh_.twin[h])}) {
                if (mesh_.role[v] == VertexRole::free && !is_listed[v]) look.push_back(v);
                is_listed[v] = 1;
            }
        int count = 0;
        for (const int h : far) count += flip(h);
        for (int sweep = 0; sweep < 3; ++sweep)
            for (const int v : look) count += improve(v, 2);
        return count;
    }

private:
    /// Edges of deviations above 1, as far as there are few of them; else the farthest, and the share is theirs.
    std::vector<int> farthest_edges() {
        std::vector<double> deviations(mesh_.corner.size(), 0);
        in_parts(static_cast<int>(mesh_.corner.size()), guard_.threads, [&](int begin, int end) {
            for (int h = begin; h < end; ++h)
                if (mesh_.corner[h] >= 0 && mesh_.feature[h] < 0 && mesh_.twin[h] > h && may_be_far(mesh_, h))
                    deviations[h] = deviation(mesh_.from(h), mesh_.to(h));
        });
        std::vector<int> far;
        for (int h = 0; h < static_cast<int>(deviations.size()); ++h)
            if (deviations[h] > 1) far.push_back(h);
        const std::size_t few = 16 + mesh_.num_triangles() / 1000;
        if (far.size() <= few) return far;
        std::stable_sort(far.begin(), far.end(), [&](int g, int h) { return deviations[g] > deviations[h]; });
        far.resize(few);
        share_ *= deviations[far.back()];
        return far;
    }
    /// The sharpest edge of v's triangles that is no feature, as a cosine.
    double sharpest(int v) const {
        double least = 1;
        mesh_.around(v, [&](int h) {
            for (const int side : {h, mesh_.next(h)}) {
                if (mesh_.feature[side] >= 0 || mesh_.twin[side] < 0) continue;
                const Vector3d n = mesh_.area_vector2(side / 3), m = mesh_.area_vector2(mesh_.twin[side] / 3);
                least = std::min(least, n.dot(m) / (n.norm() * m.norm()));
            }
            return true;
        });
        return least;
    }
    /// No creases may come of it.
    bool sharpens(int v, const Place& at) {
        const double before = sharpest(v);
        const Vector3d x = mesh_.pos[v];
        mesh_.pos[v] = at.point;
        const double after = sharpest(v);
        mesh_.pos[v] = x;
        return after < std::min(before, cos_fold_);
    }
    /// How far the edge between vertices a and b is off the input; 1: by the share of its wanted length.
    double deviation(int a, int b) const { return deviation(a, mesh_.pos[a], mesh_.foot[a], b); }
    double deviation(int a, const Vector3d& x, int foot, int b) const {
        const int hint = mesh_.role[a] == VertexRole::free ? foot : mesh_.foot[b];
        double farthest2 = 0;
        for (const double t : {0.5, 0.3, 0.7}) {
            const Foot there = project(*mesh_.base, x + t * (mesh_.pos[b] - x), hint, mesh_.size[b]);
            farthest2 = std::max(farthest2, there.distance2);
        }
        return std::sqrt(farthest2) / (share_ * mesh_.wanted(a, b));
    }
    static double fourth(double x) { return (x * x) * (x * x); }
    bool flip(int h) {
        const int g = mesh_.twin[h], a = mesh_.from(h), b = mesh_.to(h), c = mesh_.apex(h), d = mesh_.apex(g);
        if (mesh_.role[c] != VertexRole::free && mesh_.role[d] != VertexRole::free) return false;
        if (mesh_.valence[a] <= 4 || mesh_.valence[b] <= 4 || c == d || mesh_.are_neighbours(c, d)) return false;
        const Facing n0 = facing(mesh_, a, d, c), n1 = facing(mesh_, d, b, c);
        if (std::min(n0.quality, n1.quality) < std::min({well_shaped, mesh_.quality(h / 3), mesh_.quality(g / 3)}))
            return false;
        if (std::min(n0.dot, n1.dot) < guard_.cos_natural || n0.normal.dot(n1.normal) < guard_.cos_natural)
            return false;
        const double before =
            fourth(deviation(a, b)) + fourth(1 / mesh_.quality(h / 3)) + fourth(1 / mesh_.quality(g / 3));
        const double after = fourth(deviation(c, d)) + fourth(1 / n0.quality) + fourth(1 / n1.quality);
        if (after > 0.95 * before) return false;
        mesh_.flip(h);
        if (std::min(sharpest(c), sharpest(d)) >= cos_fold_) return true;
        mesh_.flip(WorkingMesh::next(h));  // from d to c, back
        return false;
    }

    Place here(int v) const { return {mesh_.pos[v], mesh_.normal[v], mesh_.foot[v], 0}; }

    bool on_surface(int v, const Place& from, const Vector3d& shift, Place& place) const {
        const Foot foot = project(*mesh_.base, from.point + shift, from.foot, 0.5 * mesh_.size[v]);
        place = {foot.point, normal_at(*mesh_.base, foot), foot.triangle, 0};
        return place.normal.dot(mesh_.normal[v]) > 0.5;
    }
    bool on_curve(int v, double shift, Place& place) const {
        const auto [before, after] = ridge_edges(mesh_, v);
        if (before < 0 || after < 0) return false;
        const FeatureEdge &e = mesh_.features[before], &f = mesh_.features[after];
        const Curves& curves = mesh_.base->curves;
        if (!(shift > -0.7 * (e.s[1] - e.s[0]) && shift < 0.7 * (f.s[1] - f.s[0]))) return false;
        const double s = e.s[1] + shift;
        if (!curves.chord_fits(e.curve, e.s[0], s, guard_.chord_slack) ||
            !curves.chord_fits(e.curve, f.s[0] + shift, f.s[1], guard_.chord_slack))
            return false;
        place = {curves.at(e.curve, s), mesh_.normal[v], curves.triangle_at(e.curve, s), shift};
        return true;
    }

    /// Sum of 1 / quality^4 around v were it at `place`, and of deviation^4 when these count; infinite where a triangle
    /// would face away.
    double cost(int v, const Place& place) {
        const Vector3d normal = mesh_.normal[v];
        mesh_.normal[v] = place.normal;
        double sum = 0;
        const bool is_old = place.point == mesh_.pos[v];
        mesh_.around(v, [&](int h) {
            const int p = mesh_.to(h), q = mesh_.apex(h);
            const Facing made = facing(mesh_, v, p, q, place.point, mesh_.pos[p], mesh_.pos[q]);
            if (!is_old && (made.dot <= 1 ? made.dot < guard_.cos_natural : turns(v, p, q, made)))
                sum = std::numeric_limits<double>::infinity();
            if (!is_old && share_ > 0 && made.quality < std::min(well_shaped, mesh_.quality(h / 3)))
                sum = std::numeric_limits<double>::infinity();
            const double worse = 1 / std::max(made.quality, 1e-4);
            sum += (worse * worse) * (worse * worse);
            return std::isfinite(sum);
        });
        mesh_.normal[v] = normal;
        if (share_ > 0 && std::isfinite(sum))
            mesh_.neighbours(v, [&](int u) { sum += fourth(deviation(v, place.point, place.foot, u)); });
        return sum;
    }
    bool turns(int v, int p, int q, const Facing& made) const {
        const Facing old = facing(mesh_, v, p, q);
        return old.quality > no_area && made.normal.dot(old.normal) < guard_.cos_natural;
    }

    void put(int v, const Place& place) {
        if (mesh_.role[v] == VertexRole::ridge) {
            const auto [before, after] = ridge_edges(mesh_, v);
            mesh_.features[before].s[1] += place.s;
            mesh_.features[after].s[0] += place.s;
        }
        mesh_.pos[v] = place.point;
        mesh_.normal[v] = place.normal;
        mesh_.foot[v] = place.foot;
        mesh_.wake_around(v);
    }

    WorkingMesh& mesh_;
    const StepGuard& guard_;
    double share_ = 0;  ///< of an edge's wanted length, by which it may be off the input; 0: does not count
    double cos_fold_ = 0;
};

}  // namespace

int approach(WorkingMesh& mesh, const StepGuard& guard, double share, double most_fold) {
    return Polish(mesh, guard).approach(share, most_fold);
}

int polish(WorkingMesh& mesh, const StepGuard& guard, double below) { return Polish(mesh, guard).run(below); }

}  // namespace strake
