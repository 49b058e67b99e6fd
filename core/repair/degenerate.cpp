#include "core/error.hpp"
#include "core/repair/surface_parts.hpp"

#include <Eigen/Geometry>
#include <algorithm>

namespace strake::mending {
namespace {

/// Removes triangles of zero area one by one; triangles that become degenerate follow in the next round.
class Remover {
public:
    explicit Remover(Surface& surface)
        : surface_(surface),
          points_(surface.mesh.vertices),
          diagonal_(box_diagonal(surface.mesh)),
          at_vertex_(static_cast<std::size_t>(surface.mesh.num_vertices())) {
        const TriMesh& mesh = surface.mesh;
        for (int t = 0; t < mesh.num_triangles(); ++t) {
            corners_.push_back({mesh.triangles(t, 0), mesh.triangles(t, 1), mesh.triangles(t, 2)});
            origin_.push_back(t);
            for (const int v : corners_[t]) at_vertex_[v].push_back(t);
            if (is_degenerate(t)) queue_.push_back(t);
        }
        is_gone_.assign(corners_.size(), 0);
    }

    /// In rounds, in alternating order, because the obstacle to one triangle may come before or after it. First only
    /// where triangles of positive area take over; when no such removal is possible, one in a cluster of degenerate
    /// triangles is removed anyway.
    void run() {
        std::size_t stirs = 10 + 2 * queue_.size();
        max_triangles_ = 2 * corners_.size() + 20 * queue_.size() + 1000;
        while (!queue_.empty() && work_ < max_work && corners_.size() < max_triangles_) {
            if (round(true)) continue;
            if (stirs-- == 0 || !round(false)) break;
        }
        store();
    }

private:
    Eigen::Vector3d at(int v) const { return points_.row(v); }
    /// Tries all in the queue, or up to the first success. @return whether there was any
    bool round(bool strict) {
        std::vector<int> now;
        std::swap(now, queue_);
        std::sort(now.begin(), now.end());
        now.erase(std::unique(now.begin(), now.end()), now.end());
        is_backward_ = !is_backward_;
        if (is_backward_) std::reverse(now.begin(), now.end());
        bool progress = false;
        for (const int t : now) {
            if (is_gone_[t] || !is_degenerate(t)) continue;
            const bool is_over = work_ > max_work || corners_.size() >= max_triangles_ || (!strict && progress);
            if (!is_over && remove(t, strict))
                progress = true;
            else
                queue_.push_back(t);
        }
        return progress;
    }

    double length(int a, int b) const { return (at(a) - at(b)).norm(); }

    bool is_degenerate(int t) const {
        const auto& [a, b, c] = corners_[t];
        return has_no_area(a, b, c);
    }
    bool has_no_area(int a, int b, int c) const {
        if (a == b || b == c || c == a) return true;
        const double area = 0.5 * (at(b) - at(a)).cross(at(c) - at(a)).norm();
        return !(area >= 1e-14 * diagonal_ * diagonal_);
    }

    bool remove(int t, bool strict) {
        for (const int v : corners_[t]) work_ += 1 + at_vertex_[v].size();
        const auto c = corners_[t];
        if (c[0] == c[1] || c[1] == c[2] || c[2] == c[0]) {
            note(t, "a corner twice");
            kill(t);
            return true;
        }
        int shortest = 0, longest = 0;
        for (int k = 1; k < 3; ++k) {
            if (length(c[k], c[(k + 1) % 3]) < length(c[shortest], c[(shortest + 1) % 3])) shortest = k;
            if (length(c[k], c[(k + 1) % 3]) > length(c[longest], c[(longest + 1) % 3])) longest = k;
        }
        const double short_length = length(c[shortest], c[(shortest + 1) % 3]);
        if (short_length <= 1e-7 * diagonal_) return collapse(t, c[shortest], c[(shortest + 1) % 3]);
        return remove_cap(t, c[longest], c[(longest + 1) % 3], c[(longest + 2) % 3], strict);
    }

    bool has(int t, int v) const { return std::find(corners_[t].begin(), corners_[t].end(), v) != corners_[t].end(); }

    std::vector<int> neighbours(int v) const {
        std::vector<int> found;
        for (const int t : at_vertex_[v])
            for (const int n : corners_[t])
                if (n != v) found.push_back(n);
        std::sort(found.begin(), found.end());
        found.erase(std::unique(found.begin(), found.end()), found.end());
        return found;
    }
    std::vector<int> at_edge(int a, int b) const {
        std::vector<int> found;
        const auto [few, other] = at_vertex_[a].size() <= at_vertex_[b].size() ? std::pair(a, b) : std::pair(b, a);
        for (const int t : at_vertex_[few])
            if (has(t, other)) found.push_back(t);
        std::sort(found.begin(), found.end());
        found.erase(std::unique(found.begin(), found.end()), found.end());
        return found;
    }
    bool is_open(int v) const {
        for (const int n : neighbours(v))
            if (at_edge(v, n).size() == 1) return true;
        return false;
    }

    /// Merges the two ends if the topology stays the same (link condition); an open edge's vertex stays.
    bool collapse(int t, int a, int b) {
        const std::vector<int> faces = at_edge(a, b);
        const bool a_open = is_open(a), b_open = is_open(b);
        if (a_open && b_open && faces.size() != 1) return false;
        int kept = std::min(a, b), gone = std::max(a, b);
        if (a_open != b_open) kept = a_open ? a : b, gone = a_open ? b : a;
        std::vector<int> apexes, common;
        for (const int f : faces)
            for (const int v : corners_[f])
                if (v != a && v != b) apexes.push_back(v);
        std::sort(apexes.begin(), apexes.end());
        apexes.erase(std::unique(apexes.begin(), apexes.end()), apexes.end());
        const auto na = neighbours(a), nb = neighbours(b);
        std::set_intersection(na.begin(), na.end(), nb.begin(), nb.end(), std::back_inserter(common));
        if (common != apexes) return false;
        for (const int f : at_vertex_[gone])
            if (!has(f, kept) && is_there(f, gone, kept)) return false;
        note(t, "its shortest edge collapsed");
        for (const int f : faces) kill(f);
        for (const int f : std::vector<int>(at_vertex_[gone])) {
            std::replace(corners_[f].begin(), corners_[f].end(), gone, kept);
            at_vertex_[kept].push_back(f);
            if (is_degenerate(f)) queue_.push_back(f);
        }
        at_vertex_[gone].clear();
        return true;
    }
    /// Whether f with `kept` for `gone` would be a copy of another triangle.
    bool is_there(int f, int gone, int kept) const {
        std::array<int, 3> moved = corners_[f];
        std::replace(moved.begin(), moved.end(), gone, kept);
        std::sort(moved.begin(), moved.end());
        for (const int other : at_vertex_[kept]) {
            std::array<int, 3> key = corners_[other];
            std::sort(key.begin(), key.end());
            if (key == moved) return true;
        }
        return false;
    }

    /// Apex c lies on the edge a-b: the triangles on the other side of it get c as a vertex.
    bool remove_cap(int t, int a, int b, int c, bool strict) {
        std::vector<int> others;
        for (const int f : at_edge(a, b))
            if (f != t) others.push_back(f);
        for (const int f : others)
            if (has(f, c)) {  // two of them back to back
                note(t, "together with its copy");
                kill(t);
                kill(f);
                return true;
            }
        if (!is_progress(others, a, b, c, strict)) return false;
        for (const int f : others)
            for (const int d : corners_[f])
                if (d != a && d != b && !at_edge(c, d).empty()) return false;  // that edge would have more than two
        note(t, others.empty() ? "at an open edge" : "the triangle across its longest edge split at its corner");
        kill(t);
        for (const int f : others) split(f, a, b, c);
        return true;
    }
    /// Without end, triangles that are all nearly on one line could be cut by each other in a circle, more of them
    /// each time where an edge has more than two. So either fewer of zero area are left, or the edge gets shorter.
    bool is_progress(const std::vector<int>& others, int a, int b, int c, bool strict) const {
        for (const int f : others) {
            if ((strict || others.size() > 1) && is_degenerate(f)) return false;
            for (const int d : corners_[f])
                if (d != a && d != b && (has_no_area(a, c, d) || has_no_area(c, b, d)) &&
                    (others.size() > 1 || !(length(c, d) < length(a, b))))
                    return false;
        }
        return true;
    }
    void split(int f, int a, int b, int c) {
        const int fresh = static_cast<int>(corners_.size());
        corners_.push_back(corners_[f]);
        origin_.push_back(origin_[f]);
        is_gone_.push_back(0);
        std::replace(corners_[f].begin(), corners_[f].end(), b, c);
        std::replace(corners_[fresh].begin(), corners_[fresh].end(), a, c);
        std::erase(at_vertex_[b], f);
        for (const int v : corners_[fresh]) at_vertex_[v].push_back(fresh);
        at_vertex_[c].push_back(f);
        for (const int part : {f, fresh})
            if (is_degenerate(part)) queue_.push_back(part);
    }

    void kill(int t) {
        is_gone_[t] = 1;
        for (const int v : corners_[t]) std::erase(at_vertex_[v], t);
    }

    void note(int t, const char* how) {
        const int input = surface_.source[origin_[t]];
        Eigen::Vector3d center = Eigen::Vector3d::Zero();
        for (const int v : corners_[t]) center += at(v) / 3;
        surface_.items.push_back(
            {RepairKind::degenerate, -1, input, center, 0, 1, text("triangle ", input, ", ", how)});
    }

    void store() {
        TriMesh& mesh = surface_.mesh;
        const int before = mesh.num_triangles();
        for (int t = 0; t < before; ++t)
            for (int k = 0; k < 3; ++k) mesh.triangles(t, k) = corners_[t][k];
        std::vector<std::array<int, 3>> fresh;
        std::vector<int> source, group;
        for (std::size_t t = before; t < corners_.size(); ++t) {
            fresh.push_back(corners_[t]);
            source.push_back(surface_.source[origin_[t]]);
            if (!mesh.group.empty()) group.push_back(mesh.group[origin_[t]]);
        }
        surface_.append(fresh, source, group);
        surface_.remove(is_gone_);
    }

    static constexpr std::size_t max_work = 1'000'000'000;  ///< limit of triangles visited: seconds of work

    Surface& surface_;
    const Points points_;
    double diagonal_;
    std::vector<std::array<int, 3>> corners_;
    std::vector<int> origin_;  ///< triangle of the mesh that it is part of
    std::vector<char> is_gone_;
    std::vector<std::vector<int>> at_vertex_;  ///< live triangles
    std::vector<int> queue_;
    bool is_backward_ = true;
    std::size_t work_ = 0, max_triangles_ = 0;
};

}  // namespace

void remove_degenerate(Surface& surface) { Remover(surface).run(); }

}  // namespace strake::mending
