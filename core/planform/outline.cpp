#include "core/planform/outline.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>

namespace strake {

std::vector<int> part_of(const TriMesh& mesh, std::vector<int> listed, const std::string& part) {
    if (listed.empty()) {
        listed.resize(static_cast<std::size_t>(mesh.num_triangles()));
        std::iota(listed.begin(), listed.end(), 0);
    }
    std::sort(listed.begin(), listed.end());
    if (listed.empty() || listed.front() < 0 || listed.back() >= mesh.num_triangles())
        throw InvalidInput(text(part, ": triangles must be in [0, ", mesh.num_triangles(), "), and at least one"));
    return listed;
}

Varying component(const TriMesh& mesh, int v, const Eigen::Vector3d& n, bool sensitivities) {
    Varying result(n.dot(mesh.vertices.row(v)));
    for (int c = 0; sensitivities && c < 3; ++c)
        if (n[c] != 0) result.slope.emplace_back(3 * v + c, n[c]);
    return result;
}

namespace {

using Eigen::Vector3d;
using Edge = std::pair<int, int>;

constexpr double repeated_rel = 1e-7;  ///< of the outline's size
constexpr double sheet_length = 1.5;   ///< over its size: an outline that is longer goes around something
constexpr double rear_share = 0.05;    ///< of the outline's length along the stream: a trailing edge may be open there

/// The cut edges in the order in which triangles join them.
class Chains {
public:
    void add(const Edge& a, const Edge& b) {
        const int i = number(a), j = number(b);
        links_[static_cast<std::size_t>(i)].push_back(j);
        links_[static_cast<std::size_t>(j)].push_back(i);
    }
    struct Chain {
        std::vector<int> edges;
        bool is_closed;
    };
    std::vector<Chain> all() {
        std::vector<char> used(links_.size(), 0);
        drop_tails(used);
        std::vector<Chain> found;
        // Open chains begin at an end; what is left are loops.
        for (const bool ends : {true, false})
            for (std::size_t i = 0; i < links_.size(); ++i)
                if (!used[i] && (!ends || links_[i].size() == 1)) found.push_back(from(static_cast<int>(i), used));
        return found;
    }
    const Edge& edge(int i) const { return edges_[static_cast<std::size_t>(i)]; }

private:
    int number(const Edge& edge) {
        const auto [at, is_new] = number_.try_emplace(edge, static_cast<int>(edges_.size()));
        if (is_new) edges_.push_back(edge), links_.emplace_back();
        return at->second;
    }
    /// Sheets that end at an outline and at nothing else (a wake at a trailing edge) are no part of it: from each free
    /// end up to where more than two meet.
    void drop_tails(std::vector<char>& used) const {
        for (std::size_t end = 0; end < links_.size(); ++end) {
            if (links_[end].size() != 1) continue;
            std::vector<int> tail{static_cast<int>(end)};
            int before = -1;
            while (true) {
                const auto& at = links_[static_cast<std::size_t>(tail.back())];
                if (at.size() > 2) {
                    tail.pop_back();
                    for (const int i : tail) used[static_cast<std::size_t>(i)] = 1;
                    break;
                }
                const int next = at.front() != before ? at.front() : at.back();
                if (next == before || tail.size() > links_.size()) break;
                before = tail.back();
                tail.push_back(next);
            }
        }
    }
    Chain from(int first, std::vector<char>& used) const {
        Chain chain{{first}, false};
        used[static_cast<std::size_t>(first)] = 1;
        for (int at = first, next = first; next >= 0; at = next) {
            next = -1;
            for (const int other : links_[static_cast<std::size_t>(at)])
                if (!used[static_cast<std::size_t>(other)]) {
                    next = other;
                    break;
                }
            if (next < 0) {
                const auto& last = links_[static_cast<std::size_t>(at)];
                chain.is_closed = chain.edges.size() > 2 && std::find(last.begin(), last.end(), first) != last.end();
                break;
            }
            used[static_cast<std::size_t>(next)] = 1;
            chain.edges.push_back(next);
        }
        return chain;
    }
    std::map<Edge, int> number_;
    std::vector<Edge> edges_;
    std::vector<std::vector<int>> links_;
};

PlanePoint crossing(const TriMesh& mesh, const Edge& edge, const SectionFrame& frame, bool sensitivities) {
    const auto along = [&](int v, const Vector3d& n) { return component(mesh, v, n, sensitivities); };
    const Varying low = along(edge.first, frame.normal), high = along(edge.second, frame.normal);
    const Varying t = (frame.offset - low) / (high - low);
    const Varying x = along(edge.first, frame.downstream), z = along(edge.first, frame.up);
    return {x + t * (along(edge.second, frame.downstream) - x), z + t * (along(edge.second, frame.up) - z)};
}

double apart(const PlanePoint& a, const PlanePoint& b) {
    return std::hypot(a.x.value - b.x.value, a.z.value - b.z.value);
}

/// Where the plane passes through a vertex, all edges there are cut in one place: one point stays.
void drop_repeated(Outline& outline) {
    double size = 0;
    for (const PlanePoint& p : outline.points) size = std::max(size, apart(p, outline.points.front()));
    std::vector<PlanePoint> kept;
    for (PlanePoint& p : outline.points)
        if (kept.empty() || apart(p, kept.back()) > repeated_rel * size) kept.push_back(std::move(p));
    while (outline.is_closed && kept.size() > 1 && apart(kept.front(), kept.back()) <= repeated_rel * size)
        kept.pop_back();
    outline.points = std::move(kept);
}

/// Two ends of different outlines.
struct EndPair {
    std::size_t i, j;
    bool at_front_i, at_front_j;
    double gap;
};

/// Of two outlines the nearest ends.
EndPair nearest_ends(const std::vector<Outline>& outlines, std::size_t i, std::size_t j) {
    EndPair best{i, j, true, true, std::numeric_limits<double>::infinity()};
    for (const bool a : {true, false})
        for (const bool b : {true, false}) {
            const PlanePoint& p = a ? outlines[i].points.front() : outlines[i].points.back();
            const PlanePoint& q = b ? outlines[j].points.front() : outlines[j].points.back();
            if (apart(p, q) < best.gap) best = {i, j, a, b, apart(p, q)};
        }
    return best;
}

/// The nearest ends of all open outlines, not farther than `reach`.
std::optional<EndPair> nearest_ends(const std::vector<Outline>& outlines, double reach) {
    std::optional<EndPair> best;
    for (std::size_t i = 0; i < outlines.size(); ++i)
        for (std::size_t j = i + 1; j < outlines.size(); ++j) {
            if (outlines[i].is_closed || outlines[j].is_closed) continue;
            const EndPair one = nearest_ends(outlines, i, j);
            if (one.gap <= (best ? best->gap : reach)) best = one;
        }
    return best;
}

/// Joins open outlines end to end, nearest first, where the gap is at most `reach`. Both ends of one outline are not
/// joined where they are the corners of an open trailing edge.
void join_ends(std::vector<Outline>& outlines, double reach) {
    while (const auto meeting = nearest_ends(outlines, reach)) {
        auto &first = outlines[meeting->i].points, &second = outlines[meeting->j].points;
        if (meeting->at_front_i) std::reverse(first.begin(), first.end());
        if (!meeting->at_front_j) std::reverse(second.begin(), second.end());
        // Equal ends are one point.
        first.insert(first.end(), second.begin() + (meeting->gap <= 1e-9 * reach ? 1 : 0), second.end());
        outlines.erase(outlines.begin() + static_cast<std::ptrdiff_t>(meeting->j));
    }
}

/// Closes an outline whose ends meet elsewhere than at its rear.
void close_at_nose(Outline& outline, double reach) {
    const PlanePoint &first = outline.points.front(), &last = outline.points.back();
    if (outline.is_closed || outline.points.size() < 3 || apart(first, last) > reach) return;
    double low = first.x.value, high = low;
    for (const PlanePoint& p : outline.points) low = std::min(low, p.x.value), high = std::max(high, p.x.value);
    if (std::max(first.x.value, last.x.value) > high - rear_share * (high - low)) return;
    outline.is_closed = true;
    drop_repeated(outline);
}

/// Whether an open outline goes there and not back: a wake, or a plate without thickness.
bool is_sheet(const Outline& outline) {
    double length = 0, low[2] = {outline.points[0].x.value, outline.points[0].z.value}, high[2] = {low[0], low[1]};
    for (std::size_t i = 0; i < outline.points.size(); ++i) {
        const PlanePoint& p = outline.points[i];
        if (i > 0) length += apart(p, outline.points[i - 1]);
        low[0] = std::min(low[0], p.x.value), high[0] = std::max(high[0], p.x.value);
        low[1] = std::min(low[1], p.z.value), high[1] = std::max(high[1], p.z.value);
    }
    return length < sheet_length * std::hypot(high[0] - low[0], high[1] - low[1]);
}

}  // namespace

std::vector<Outline> cut(const TriMesh& mesh, const std::vector<int>& triangles, const SectionFrame& frame,
                         const CutOptions& options) {
    Chains chains;
    const auto above = [&](int v) { return frame.normal.dot(mesh.vertices.row(v)) >= frame.offset.value; };
    for (const int t : triangles) {
        const auto corner = mesh.triangles.row(t);
        const std::array<bool, 3> is{above(corner[0]), above(corner[1]), above(corner[2])};
        if (is[0] == is[1] && is[1] == is[2]) continue;
        const int alone = is[0] == is[1] ? 2 : is[0] == is[2] ? 1 : 0;
        const auto edge = [&](int k) {
            // From below to above, so that both triangles at it name it alike.
            return is[alone] ? Edge(corner[k], corner[alone]) : Edge(corner[alone], corner[k]);
        };
        chains.add(edge((alone + 1) % 3), edge((alone + 2) % 3));
    }
    std::vector<Outline> found;
    for (const auto& chain : chains.all()) {
        Outline outline{{}, chain.is_closed};
        for (const int e : chain.edges)
            outline.points.push_back(crossing(mesh, chains.edge(e), frame, options.sensitivities));
        drop_repeated(outline);
        if (outline.points.size() > 1) found.push_back(std::move(outline));
    }
    if (options.join > 0) {
        join_ends(found, options.join);
        for (Outline& outline : found) close_at_nose(outline, options.join);
    }
    // Beside closed outlines open ones that go one way are sheets: a wake that has vertices of its own.
    if (std::any_of(found.begin(), found.end(), [](const Outline& o) { return o.is_closed; }))
        std::erase_if(found, [](const Outline& o) { return !o.is_closed && is_sheet(o); });
    return found;
}

}  // namespace strake
