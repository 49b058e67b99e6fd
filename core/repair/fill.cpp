#include "core/formats/ear_clipping.hpp"
#include "core/repair/surface_parts.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <queue>

namespace strake::mending {
namespace {

using Triple = std::array<int, 3>;

/// Least bending, then least area, over all triangulations: P. Liepa, "Filling holes in meshes", SGP 2003; O(n^3).
class MinBendingFill {
public:
    MinBendingFill(const Points& polygon, const Points& normals, const IsTaken& is_taken)
        : p_(polygon), normals_(normals), is_taken_(is_taken), n_(static_cast<int>(polygon.rows())) {
        best_.resize(static_cast<std::size_t>(n_) * n_);
    }

    std::vector<Triple> run() {
        for (int i = 0; i + 1 < n_; ++i) {
            at(i, i + 1).bend = at(i, i + 1).area = 0;
            at(i, i + 1).normal = normals_.row(i);
        }
        for (int width = 2; width < n_; ++width)
            for (int i = 0; i + width < n_; ++i) choose(i, i + width);
        std::vector<Triple> triangles;
        if (at(0, n_ - 1).middle >= 0) collect(0, n_ - 1, triangles);
        return triangles;
    }

private:
    static constexpr double none = std::numeric_limits<double>::infinity();
    struct Best {
        double bend = none, area = none;
        int middle = -1;
        Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< of the triangle at the diagonal
    };
    Best& at(int i, int k) { return best_[static_cast<std::size_t>(i) * n_ + k]; }

    void choose(int i, int k) {
        const bool is_last = i == 0 && k == n_ - 1;
        if (!is_last && is_taken_(i, k)) return;
        Best best;
        for (int m = i + 1; m < k; ++m) {
            const Best &left = at(i, m), &right = at(m, k);
            if (left.area == none || right.area == none) continue;
            const Eigen::Vector3d area = (p_.row(m) - p_.row(k)).transpose().cross((p_.row(i) - p_.row(k)).transpose());
            const double size = area.norm();
            const Eigen::Vector3d normal = size > 0 ? Eigen::Vector3d(area / size) : area;
            double bend = std::max({left.bend, right.bend, 1 - normal.dot(left.normal), 1 - normal.dot(right.normal)});
            if (is_last) bend = std::max(bend, 1 - normal.dot(normals_.row(n_ - 1)));
            bend = std::round(bend * 1e6) / 1e6;  // the area then decides between equal ones
            const double total = left.area + right.area + size;
            if (bend < best.bend || (bend == best.bend && total < best.area)) best = {bend, total, m, normal};
        }
        at(i, k) = best;
    }
    void collect(int i, int k, std::vector<Triple>& triangles) {
        std::vector<std::array<int, 2>> stack{{i, k}};
        while (!stack.empty()) {
            const auto [a, c] = stack.back();
            stack.pop_back();
            if (c - a < 2) continue;
            const int m = at(a, c).middle;
            triangles.push_back({c, m, a});
            stack.push_back({m, c});
            stack.push_back({a, m});
        }
    }

    const Points &p_, &normals_;
    const IsTaken& is_taken_;
    int n_;
    std::vector<Best> best_;
};

/// Polygons too long for that: always the shortest diagonal.
std::vector<Triple> shortest_diagonals(const Points& p, const IsTaken& is_taken) {
    const int n = static_cast<int>(p.rows());
    std::vector<int> before(static_cast<std::size_t>(n)), after(before), version(before);
    using Ear = std::tuple<double, int, int>;  // length, vertex, version
    std::priority_queue<Ear, std::vector<Ear>, std::greater<>> ears;
    const auto offer = [&](int v) {
        if (!is_taken(before[v], after[v])) ears.push({(p.row(before[v]) - p.row(after[v])).norm(), v, ++version[v]});
    };
    for (int i = 0; i < n; ++i) before[i] = (i + n - 1) % n, after[i] = (i + 1) % n;
    for (int i = 0; i < n; ++i) offer(i);
    std::vector<Triple> triangles;
    for (int left = n; left > 3;) {
        if (ears.empty()) return {};
        const auto [length, v, v_version] = ears.top();
        ears.pop();
        if (v_version != version[v]) continue;
        const int a = before[v], b = after[v];
        triangles.push_back({b, v, a});
        after[a] = b;
        before[b] = a;
        version[v] = -1;
        for (const int w : {a, b}) {
            ++version[w];
            offer(w);
        }
        if (--left == 3) triangles.push_back({b, a, before[a]});
    }
    return triangles;
}

}  // namespace

std::vector<Triple> fill_polygon(const Points& polygon, const Points& normals, double flat, const IsTaken& is_taken) {
    const int n = static_cast<int>(polygon.rows());
    if (n == 3) return {{2, 1, 0}};
    const Eigen::Vector3d normal = polygon_area_vector(polygon).normalized();
    const Eigen::RowVector3d center = polygon.colwise().mean();
    const bool is_flat = normal.norm() > 0.5 && ((polygon.rowwise() - center) * normal).cwiseAbs().maxCoeff() <= flat;
    std::vector<Triple> triangles;
    if (is_flat && n <= 5000) triangles = clip_ears(polygon, normal, is_taken);
    for (Triple& t : triangles) std::swap(t[0], t[2]);  // a fill runs opposite to its loop
    if (triangles.empty() && n <= 250) triangles = MinBendingFill(polygon, normals, is_taken).run();
    if (triangles.empty()) triangles = shortest_diagonals(polygon, is_taken);
    flip_to_delaunay([&](int v) -> Eigen::Vector3d { return polygon.row(v); }, triangles, is_taken);
    return triangles;
}

namespace {

using Sides = std::map<std::array<int, 2>, std::vector<int>>;  ///< triangles at a pair of vertices

std::array<int, 2> sorted(int a, int b) { return {std::min(a, b), std::max(a, b)}; }

int apex_of(const Triple& t, int a, int b) {
    for (const int v : t)
        if (v != a && v != b) return v;
    return -1;
}

double angle_at(const Eigen::Vector3d& apex, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    const Eigen::Vector3d u = a - apex, w = b - apex;
    return std::atan2(u.cross(w).norm(), u.dot(w));
}

Eigen::Vector3d normal_of(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
    return (b - a).cross(c - a).normalized();
}

bool runs(const Triple& triangle, int a, int b) {
    for (int k = 0; k < 3; ++k)
        if (triangle[k] == a && triangle[(k + 1) % 3] == b) return true;
    return false;
}

/// Whether edge cd is better than edge ab of the triangles abc and bad: Delaunay, and without a bend of the normals.
bool flip_improves(const Eigen::Vector3d& pa, const Eigen::Vector3d& pb, const Eigen::Vector3d& pc,
                   const Eigen::Vector3d& pd) {
    if (!(angle_at(pc, pa, pb) + angle_at(pd, pa, pb) > 3.14159265358979 + 1e-9)) return false;
    const Eigen::Vector3d n1 = normal_of(pa, pb, pc), n2 = normal_of(pb, pa, pd), m1 = normal_of(pc, pa, pd),
                          m2 = normal_of(pd, pb, pc);
    const double least = std::min({m1.dot(n1), m1.dot(n2), m2.dot(n1), m2.dot(n2)});
    return (least > 0.5 || (n1.norm() < 0.5 || n2.norm() < 0.5)) && !(m1.norm() < 0.5) && !(m2.norm() < 0.5);
}

}  // namespace

void flip_to_delaunay(const std::function<Eigen::Vector3d(int)>& at, std::vector<Triple>& triangles,
                      const IsTaken& is_taken) {
    Sides sides;
    for (int t = 0; t < static_cast<int>(triangles.size()); ++t)
        for (int k = 0; k < 3; ++k) sides[sorted(triangles[t][k], triangles[t][(k + 1) % 3])].push_back(t);
    std::vector<std::array<int, 2>> queue;
    for (const auto& [side, at_side] : sides) queue.push_back(side);
    std::size_t allowed = 20 * queue.size();
    for (std::size_t i = 0; i < queue.size() && allowed > 0; ++i) {
        int a = queue[i][0], b = queue[i][1];
        const auto found = sides.find({a, b});
        if (found == sides.end() || found->second.size() != 2) continue;
        const int s = found->second[0], t = found->second[1];
        if (!runs(triangles[s], a, b)) std::swap(a, b);  // s runs a to b, t back
        const int c = apex_of(triangles[s], a, b), d = apex_of(triangles[t], a, b);
        if (c == d || c < 0 || d < 0 || sides.count(sorted(c, d)) || is_taken(c, d)) continue;
        if (!flip_improves(at(a), at(b), at(c), at(d))) continue;
        --allowed;
        sides.erase(found);
        triangles[s] = {c, a, d};
        triangles[t] = {d, b, c};
        sides[sorted(c, d)] = {std::min(s, t), std::max(s, t)};
        std::replace(sides[sorted(a, d)].begin(), sides[sorted(a, d)].end(), t, s);
        std::replace(sides[sorted(b, c)].begin(), sides[sorted(b, c)].end(), s, t);
        for (const auto& side : {sorted(a, d), sorted(b, d), sorted(b, c), sorted(a, c)}) queue.push_back(side);
    }
}

}  // namespace strake::mending
