#include "core/patches/parts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <queue>
#include <set>
#include <tuple>

namespace strake {
namespace {

constexpr int outside = -1, unassigned = -2;

/// A number that distinguishes places and rotates with the body. It breaks exact ties (a strip midway between the two
/// sides of a symmetric wing) independently of the numbering.
double tie_breaker(const Body& body, const Eigen::Vector3d& place) {
    return (body.axes.transpose() * (place - body.centre)).dot(Eigen::Vector3d(0.27, 0.41, 0.87));
}

struct Part {
    double area = 0;
    Eigen::Vector3d moment = Eigen::Vector3d::Zero();
    std::map<int, double> border;  ///< neighbour, length of the shared border weighted by its smoothness
    Eigen::Vector3d place() const { return area > 0 ? Eigen::Vector3d(moment / area) : moment; }
};

/// The part that absorbs part `s`: longest common border, else nearest; ties within 1e-6 by place.
int taker(const Body& body, const std::vector<Part>& parts, const std::set<std::tuple<double, int>>& alive, int s) {
    int best = -1;
    double best_score = -std::numeric_limits<double>::infinity();
    const auto offer = [&](int c, double score) {
        const double slack = 1e-6 * (std::abs(score) + std::abs(best_score));
        const bool better = best < 0 || score > best_score + slack ||
                            (score > best_score - slack &&
                             tie_breaker(body, parts[c].place()) > tie_breaker(body, parts[best].place()));
        if (better) best = c, best_score = score;
    };
    if (!parts[s].border.empty())
        for (const auto& [c, length] : parts[s].border) offer(c, length);
    else
        for (const auto& [area, c] : alive)
            if (c != s) offer(c, -(parts[c].place() - parts[s].place()).norm());
    return best;
}

/// Gives `label` to `seed` and to all unassigned triangles reached from it by `crosses(from, edge, to)`.
template <class Crosses>
void flood_fill(const Adjacency& adjacent, int seed, int label, const Crosses& crosses, std::vector<int>& labels) {
    labels[seed] = label;
    std::vector<int> stack{seed};
    while (!stack.empty()) {
        const int t = stack.back();
        stack.pop_back();
        for (int k = 0; k < 3; ++k) {
            const int e = adjacent.triangle_edges(t, k);
            for (const int n : adjacent.edge_triangles[e])
                if (labels[n] == unassigned && crosses(t, e, n)) labels[n] = label, stack.push_back(n);
        }
    }
}

/// Unassigned triangles by their distance from the parts (Dijkstra); a crease counts as far as the whole body.
struct Frontier {
    const Body& body;
    const Creases& creases;
    const std::vector<int>& label;
    std::vector<double>& reached;                ///< least distance so far, per triangle
    double size;                                 ///< of the body
    using Entry = std::tuple<double, int, int>;  ///< distance, label, triangle
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue = {};

    void spread(int t, double distance, int to_label) {
        for (int k = 0; k < 3; ++k) {
            const int e = body.adjacent().triangle_edges(t, k);
            for (const int n : body.adjacent().edge_triangles[e]) {
                if (label[n] != unassigned) continue;
                const double step = (body.centroids.row(n) - body.centroids.row(t)).norm();
                const double to = distance + step + (creases.edge[e] ? size : 0.0);
                if (!(to < reached[n])) continue;
                reached[n] = to;
                queue.push({to, to_label, n});
            }
        }
    }
};

}  // namespace

Parts::Parts(const Body& body, const Creases& creases)
    : body_(body),
      creases_(creases),
      label_(body.mesh().num_triangles(), outside),
      key_(body.mesh().num_triangles(), outside),
      reached_(body.mesh().num_triangles()) {}

double Parts::area(const TriangleSet& set) const {
    double sum = 0;
    for (const int t : set) sum += body_.features.areas[t];
    return sum;
}

std::vector<TriangleSet> Parts::split(const TriangleSet& set, const std::vector<int>& key, bool at_creases,
                                      double min_area) {
    int count = flood(set, key, at_creases);
    count = grow(set, count);
    absorb(set, count, min_area);
    std::vector<TriangleSet> pieces;
    std::vector<int> number(count, -1);
    for (const int t : set) {
        int& p = number[label_[t]];
        if (p < 0) p = static_cast<int>(pieces.size()), pieces.emplace_back();
        pieces[p].push_back(t);
        label_[t] = outside;
    }
    return pieces;
}

/// Labels edge-connected parts of equal key >= 0; returns their number.
int Parts::flood(const TriangleSet& set, const std::vector<int>& key, bool at_creases) {
    const Adjacency& adjacent = body_.adjacent();
    for (std::size_t i = 0; i < set.size(); ++i) key_[set[i]] = key[i], label_[set[i]] = unassigned;
    const auto crosses = [&](int from, int e, int to) {
        return !(at_creases && creases_.edge[e]) && key_[to] == key_[from];
    };
    int count = 0;
    for (const int seed : set)
        if (label_[seed] == unassigned && key_[seed] >= 0) flood_fill(adjacent, seed, count++, crosses, label_);
    for (const int t : set) key_[t] = outside;
    return count;
}

/// Assigns unassigned triangles to the nearest part along the surface, across a crease only if there is no other way.
/// Components without any part become parts. Returns the number of parts.
int Parts::grow(const TriangleSet& set, int count) {
    std::vector<Part> parts(count);
    for (const int t : set)
        if (label_[t] >= 0) {
            parts[label_[t]].area += body_.features.areas[t];
            parts[label_[t]].moment += body_.features.areas[t] * body_.centroids.row(t).transpose();
        }
    const double size = std::sqrt(body_.area);
    for (const int t : set) reached_[t] = std::numeric_limits<double>::infinity();
    Frontier frontier{body_, creases_, label_, reached_, size};
    for (const int t : set)
        if (label_[t] >= 0) {
            const double tie = tie_breaker(body_, parts[label_[t]].place());
            frontier.spread(t, 1e-6 * (size - tie), label_[t]);
        }
    while (!frontier.queue.empty()) {
        const auto [d, label, t] = frontier.queue.top();
        frontier.queue.pop();
        if (label_[t] != unassigned) continue;
        label_[t] = label;
        frontier.spread(t, d, label);
    }
    const auto everywhere = [](int, int, int) { return true; };
    for (const int seed : set)
        if (label_[seed] == unassigned) flood_fill(body_.adjacent(), seed, count++, everywhere, label_);
    return count;
}

/// Merges parts smaller than `min_area`; labels become those of the survivors.
void Parts::absorb(const TriangleSet& set, int count, double min_area) {
    const Adjacency& adjacent = body_.adjacent();
    std::vector<Part> parts(count);
    for (const int t : set) {
        Part& part = parts[label_[t]];
        part.area += body_.features.areas[t];
        part.moment += body_.features.areas[t] * body_.centroids.row(t).transpose();
        for (int k = 0; k < 3; ++k) {
            const int e = adjacent.triangle_edges(t, k);
            const double smooth = creases_.edge[e] ? 0.01 : 0.5 * (1 + std::cos(body_.features.dihedral[e]));
            for (const int n : adjacent.edge_triangles[e])
                if (label_[n] >= 0 && label_[n] != label_[t]) part.border[label_[n]] += smooth * body_.edge_length[e];
        }
    }
    std::set<std::tuple<double, int>> alive;
    std::vector<int> into(count);
    for (int p = 0; p < count; ++p) into[p] = p, alive.insert({parts[p].area, p});
    while (alive.size() > 1 && std::get<0>(*alive.begin()) < min_area) {
        const int s = std::get<1>(*alive.begin()), t = taker(body_, parts, alive, s);
        alive.erase(alive.begin());
        alive.erase({parts[t].area, t});
        into[s] = t;
        parts[t].area += parts[s].area;
        parts[t].moment += parts[s].moment;
        for (const auto& [n, length] : parts[s].border) {
            parts[n].border.erase(s);
            if (n == t) continue;
            parts[n].border[t] += length;
            parts[t].border[n] += length;
        }
        alive.insert({parts[t].area, t});
    }
    for (const int t : set)
        while (into[label_[t]] != label_[t]) label_[t] = into[label_[t]] = into[into[label_[t]]];
}

}  // namespace strake
