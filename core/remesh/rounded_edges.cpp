#include "core/error.hpp"
#include "core/remesh/features.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <queue>

namespace strake {
namespace {

using Eigen::Vector3d;

constexpr double half_width = 0.1;      ///< of a strip, in wanted edge lengths
constexpr double min_share = 0.75;      ///< of the turning within twice the width; the rest of a bend is a curved flank
constexpr double off_middle = 0.42;     ///< of the turning: allowed deviation from half, to keep a chain straight
constexpr double min_turn = 0.05;       ///< radians; flatter edges are never a middle
constexpr double surely_flat = 0.9988;  ///< above cos(min_turn), and told without an inverse cosine
constexpr double max_turn = 1.2 * std::numbers::pi;  ///< within twice the width; larger turns are tips, not edges
constexpr double min_length = 1.0;                   ///< of a chain, in wanted edge lengths
constexpr int max_steps = 400;                       ///< of a walk; what is finer than that has no middle

/// The order must not depend on the numbering: lowest first in this direction, which is perpendicular to no symmetry
/// axis.
Vector3d order_direction() { return {0.2859, 0.5437, 0.7891}; }

/// A straight walk over the surface away from the middle of an edge, square to it.
struct Walk {
    double turn = 0, inner = 0;  ///< of the normal about the edge, radians: on twice half_width, and on half_width
    std::vector<std::pair<int, double>> triangles;  ///< on half_width, and how far away each begins
    std::vector<int> crossed;                       ///< half-edges by which it leaves these
    bool ends = false;                              ///< at twice half_width, a feature or a boundary
};

class RoundedEdges {
public:
    RoundedEdges(const std::vector<char>& is_feature, double angle, BaseSurface& base)
        : is_feature_(is_feature),
          angle_(std::max(angle, std::numbers::pi / 3)),
          base_(base),
          taken_(is_feature),
          count_(base.points.size(), 0),
          beside_feature_(base.points.size(), 0) {}

    std::vector<int> run() {
        const int halves = static_cast<int>(base_.twin.size());
        for (int h = 0; h < halves; ++h)
            if (is_feature_[h]) beside_feature_[base_.from(h)] = beside_feature_[to(h)] = 1;
        std::vector<int> middles;
        for (int h = 0; h < halves; ++h)
            if (!is_feature_[h] && h < base_.twin[h] && is_middle(h, 0)) middles.push_back(h);
        trace(middles);
        if (!chosen_.empty()) {
            middles = chosen_;
            close_gaps();
            drop_short_chains();
            std::erase_if(middles,
                          [&](int h) { return std::find(chosen_.begin(), chosen_.end(), h) == chosen_.end(); });
            level(middles);
        }
        return std::move(chosen_);
    }

private:
    int to(int h) const { return base_.from(base_.next(h)); }
    Vector3d along(int h) const { return base_.points[to(h)] - base_.points[base_.from(h)]; }
    double turn_at(int h) const {  // > 0: convex
        const Vector3d &n = base_.normal[h / 3], &m = base_.normal[base_.twin[h] / 3];
        return std::atan2(n.cross(m).dot(along(h).normalized()), n.dot(m));
    }
    void take(int h) {
        taken_[h] = taken_[base_.twin[h]] = 1;
        chosen_.push_back(h);
        ++count_[base_.from(h)];
        ++count_[to(h)];
    }

    /// From the middle of h over triangle h / 3 and on, up to the reach.
    Walk walk(int h) const {
        Walk result;
        const Vector3d axis = along(h).normalized();
        Vector3d x = 0.5 * (base_.points[base_.from(h)] + base_.points[to(h)]);
        Vector3d direction = inward(h);
        const double reach = half_width * base_.edge_length;
        double gone = 0;
        for (int step = 0; step < max_steps; ++step) {
            if (gone <= reach) result.triangles.push_back({h / 3, gone});
            double length = 0;
            const int out = exit_of(h, x, direction, length);
            result.ends = out < 0 || gone + length >= 2 * reach || is_feature_[out];
            if (result.ends || std::abs(result.turn) > max_turn) break;
            if (gone <= reach) result.crossed.push_back(out);
            gone += length;
            x += length * direction;
            const int g = base_.twin[out];
            const Vector3d &n = base_.normal[h / 3], &m = base_.normal[g / 3];
            const double turn = -std::atan2(axis.dot(n.cross(m)), n.dot(m));
            result.turn += turn;
            if (gone <= reach) result.inner += turn;
            const Vector3d u = along(out).normalized();
            direction = (direction.dot(u) * u + std::max(0.0, direction.dot(-inward(out))) * inward(g)).normalized();
            h = g;
        }
        return result;
    }
    Vector3d inward(int h) const {  // in the plane of the triangle, square to h
        const Vector3d u = along(h).normalized(), w = base_.points[base_.from(base_.prev(h))] - base_.points[to(h)];
        const Vector3d v = w - w.dot(u) * u;
        const double length = v.norm();
        return length > 0 ? Vector3d(v / length) : base_.normal[h / 3].cross(u);
    }
    /// Edge by which a ray from x, on edge h, leaves the triangle; -1: none.
    int exit_of(int h, const Vector3d& x, const Vector3d& direction, double& length) const {
        int best = -1;
        for (const int e : {base_.next(h), base_.prev(h)}) {
            const Vector3d in = inward(e);
            const double height = (x - base_.points[base_.from(e)]).dot(in), speed = -direction.dot(in);
            if (!(speed > 1e-12)) continue;
            const double s = std::max(0.0, height) / speed;
            if (best < 0 || s < length) best = e, length = s;
        }
        return best;
    }

    /// Half of the turning lies on either side of h, or at least `off` less than half.
    bool is_middle(int h, double off) const {
        if (base_.normal[h / 3].dot(base_.normal[base_.twin[h] / 3]) > surely_flat) return false;
        const double own = turn_at(h);
        if (std::abs(own) < min_turn) return false;
        const Vector3d side = order_direction();
        const bool swapped = base_.normal[h / 3].dot(side) < base_.normal[base_.twin[h] / 3].dot(side);
        const Walk first = walk(swapped ? base_.twin[h] : h), second = walk(swapped ? h : base_.twin[h]);
        const double sign = own > 0 ? 1 : -1, bend = sign * own;
        const double before = sign * first.turn, whole = before + bend + sign * second.turn;
        const double inner = bend + sign * (first.inner + second.inner), slack = 1e-6 * whole;
        return first.ends && second.ends && whole <= max_turn && inner >= angle_ - angle_slack &&
               inner >= min_share * whole && before < (0.5 + off) * whole - slack &&
               before + bend >= (0.5 - off) * whole - slack;
    }

    /// Keeps chains straight near the middle: where the middle drifts from one row of edges to the next, both would be
    /// chains with slivers between them.
    void trace(std::vector<int>& middles) {
        const Vector3d side = order_direction();
        std::stable_sort(middles.begin(), middles.end(), [&](int g, int h) {
            return side.dot(base_.points[base_.from(g)] + base_.points[to(g)]) <
                   side.dot(base_.points[base_.from(h)] + base_.points[to(h)]);
        });
        is_beside_.assign(base_.twin.size(), 0);
        for (const int middle : middles) {
            if (taken_[middle] || is_beside_[middle] || leads_beside(middle) || leads_beside(base_.twin[middle]))
                continue;
            add(middle);
            for (const int h : {middle, base_.twin[middle]})
                for (int at = h, next = -1; (next = onward(at)) >= 0; at = next) add(next);
        }
    }
    void add(int h) {
        take(h);
        for (const int from : {h, base_.twin[h]})
            for (const int g : walk(from).crossed) is_beside_[g] = is_beside_[base_.twin[g]] = 1;
    }
    /// The edge by which the chain goes on where h ends, if it does not meet anything there; or -1.
    int onward(int h) const {
        const int v = to(h);
        if (count_[v] != 1 || beside_feature_[v]) return -1;
        const Vector3d ahead = along(h).normalized();
        int best = -1;
        double most = 0.8;
        each_out_of(v, [&](int g) {
            const double cosine = ahead.dot(along(g).normalized());
            if (taken_[g] || is_beside_[g] || count_[to(g)] > 0 || cosine <= most || leads_beside(g) ||
                !is_middle(g, off_middle))
                return;
            best = g;
            most = cosine;
        });
        return best;
    }

    /// Straight ahead another chain runs alongside: close_gap() joins them and needs room.
    bool leads_beside(int h) const {
        const Vector3d ahead = along(h).normalized();
        bool found = false;
        each_out_of(to(h), [&](int g) { found = found || (is_beside_[g] && ahead.dot(along(g).normalized()) > 0.8); });
        return found;
    }

    /// Ends of chains that face each other are joined along edges.
    void close_gaps() {
        std::vector<int> ends;
        for (std::size_t i = 0, n = chosen_.size(); i < n; ++i)
            for (const int h : {chosen_[i], base_.twin[chosen_[i]]})
                if (count_[to(h)] == 1 && !beside_feature_[to(h)]) ends.push_back(h);
        for (const int h : ends)
            if (count_[to(h)] == 1) close_gap(h);
    }
    void close_gap(int h) {
        const int start = to(h);
        const Vector3d ahead = along(h).normalized();
        std::map<int, double> distance{{start, 0.0}};
        std::map<int, int> came_by;
        using Entry = std::pair<double, int>;
        std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
        queue.push({0.0, start});
        for (int seen = 0; !queue.empty() && seen < 200; ++seen) {
            const auto [d, v] = queue.top();
            queue.pop();
            if (d > distance[v]) continue;
            if (v != start && (count_[v] > 0 || beside_feature_[v])) {
                for (int at = v; at != start; at = base_.from(came_by[at])) take(came_by[at]);
                return;
            }
            each_out_of(v, [&, d = d](int g) {
                const Vector3d off = base_.points[to(g)] - base_.points[start];
                const double next = d + along(g).norm();
                if (taken_[g] || next > base_.edge_length || off.dot(ahead) < 0.8 * off.norm()) return;
                const auto known = distance.find(to(g));
                if (known != distance.end() && known->second <= next) return;
                distance[to(g)] = next;
                came_by[to(g)] = g;
                queue.push({next, to(g)});
            });
        }
    }
    template <class F>
    void each_out_of(int v, F&& f) const {
        const int first = base_.first_half[v];
        for (int h = first; h >= 0;) {
            if (base_.twin[h] >= 0) f(h);
            h = base_.twin[base_.prev(h)];
            if (h == first) return;
        }
    }

    void drop_short_chains() {
        std::vector<int> group(base_.points.size(), -1);
        const auto root = [&](int v) {
            while (group[v] >= 0) v = group[v];
            return v;
        };
        for (const int h : chosen_) {
            const int a = root(base_.from(h)), b = root(to(h));
            if (a != b) group[std::max(a, b)] = std::min(a, b);
        }
        std::map<int, double> length;
        for (const int h : chosen_) length[root(to(h))] += along(h).norm();
        std::erase_if(chosen_, [&](int h) { return length[root(to(h))] < min_length * base_.edge_length; });
    }

    /// The triangles up to the flanks count as parts of them; each belongs to the nearest edge.
    void level(const std::vector<int>& middles) {
        std::map<int, std::pair<double, Vector3d>> leveled;
        for (const int h : middles)
            for (const int side : {h, base_.twin[h]}) {
                const Walk strip = walk(side);
                const Vector3d flank = base_.normal[strip.triangles.back().first];
                for (const auto& [t, gone] : strip.triangles) {
                    const auto known = leveled.find(t);
                    if (known == leveled.end() || gone < known->second.first) leveled[t] = {gone, flank};
                }
            }
        for (const auto& [t, entry] : leveled) base_.normal[t] = entry.second;
    }

    const std::vector<char>& is_feature_;
    double angle_;
    BaseSurface& base_;
    std::vector<char> taken_;
    std::vector<int> count_;                        ///< chosen edges at a point
    std::vector<char> beside_feature_, is_beside_;  ///< points on features; half-edges in the strip of a chain
    std::vector<int> chosen_;
};

}  // namespace

std::vector<int> rounded_edges(const std::vector<char>& is_feature, double angle, BaseSurface& base) {
    return RoundedEdges(is_feature, angle, base).run();
}

}  // namespace strake
