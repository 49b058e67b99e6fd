#pragma once
#include "core/mesh/mesh.hpp"

#include <Eigen/Geometry>
#include <map>
#include <numbers>
#include <string>

/// Is a deformed surface valid? The same promises as the library's guard, by plain loops that share nothing with it.
namespace strake::brute_force {

using V3 = Eigen::Vector3d;

inline V3 corner(const Points& v, const Triangles& f, int t, int k) { return v.row(f(t, k)); }

inline V3 twice_area(const Points& v, const Triangles& f, int t) {
    return (corner(v, f, t, 1) - corner(v, f, t, 0)).cross(corner(v, f, t, 2) - corner(v, f, t, 0));
}

/// Segment p-q against a triangle (Moeller & Trumbore 1997); what only touches within 1e-9 is left out.
inline bool pierces(const V3& p, const V3& q, const V3& a, const V3& b, const V3& c) {
    const V3 d = q - p, e1 = b - a, e2 = c - a, h = d.cross(e2);
    const double det = e1.dot(h), tolerance = 1e-9;
    if (std::abs(det) < 1e-12 * d.norm() * e1.norm() * e2.norm()) return false;
    const V3 s = p - a, k = s.cross(e1);
    const double u = s.dot(h) / det, w = d.dot(k) / det, at = e2.dot(k) / det;
    return u > tolerance && w > tolerance && u + w < 1 - tolerance && at > tolerance && at < 1 - tolerance;
}

inline bool crosses(const Points& v, const Triangles& f, int s, int t) {
    for (int k = 0; k < 3; ++k)
        if (pierces(corner(v, f, s, k), corner(v, f, s, (k + 1) % 3), corner(v, f, t, 0), corner(v, f, t, 1),
                    corner(v, f, t, 2)) ||
            pierces(corner(v, f, t, k), corner(v, f, t, (k + 1) % 3), corner(v, f, s, 0), corner(v, f, s, 1),
                    corner(v, f, s, 2)))
            return true;
    return false;
}

/// Part per triangle by shared vertices, and whether a ray from x along a skew direction leaves part `p` an odd number
/// of times.
inline std::vector<int> parts(const Triangles& f, int num_vertices) {
    std::vector<int> root(num_vertices);
    for (int v = 0; v < num_vertices; ++v) root[v] = v;
    const auto find = [&](int v) {
        while (root[v] != v) v = root[v] = root[root[v]];
        return v;
    };
    for (int t = 0; t < f.rows(); ++t)
        for (int k = 1; k < 3; ++k) root[find(f(t, k))] = find(f(t, 0));
    std::vector<int> part(f.rows());
    for (int t = 0; t < f.rows(); ++t) part[t] = find(f(t, 0));
    return part;
}

inline bool is_inside(const Points& v, const Triangles& f, const std::vector<int>& part, int p, const V3& x) {
    const V3 far = x + 1e3 * V3(0.577, 0.211, 0.789);
    int count = 0;
    for (int t = 0; t < f.rows(); ++t)
        if (part[t] == p) count += pierces(x, far, corner(v, f, t, 0), corner(v, f, t, 1), corner(v, f, t, 2));
    return count % 2 != 0;
}

inline std::string bad_triangle(const TriMesh& rest, const Points& v) {
    const Triangles& f = rest.triangles;
    std::map<std::pair<int, int>, std::vector<int>> edges;
    for (int t = 0; t < f.rows(); ++t) {
        const double before = twice_area(rest.vertices, f, t).norm(), now = twice_area(v, f, t).norm();
        if (!(now > 0.999e-3 * before)) return "collapsed " + std::to_string(t);
        for (int k = 0; k < 3; ++k) edges[std::minmax(f(t, k), f(t, (k + 1) % 3))].push_back(t);
    }
    const auto angle = [&](const Points& at, int s, int t) {
        const V3 a = twice_area(at, f, s), b = twice_area(at, f, t);
        return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / std::numbers::pi;
    };
    for (const auto& [edge, of] : edges)
        if (of.size() == 2 && angle(rest.vertices, of[0], of[1]) < 119.99 && angle(v, of[0], of[1]) > 170.01)
            return "folded between " + std::to_string(of[0]) + " and " + std::to_string(of[1]);
    return {};
}

inline bool is_closed(const Triangles& f, const std::vector<int>& part, int p) {
    std::map<std::pair<int, int>, int> runs;
    for (int t = 0; t < f.rows(); ++t)
        for (int k = 0; k < 3 && part[t] == p; ++k) ++runs[{f(t, k), f(t, (k + 1) % 3)}];
    for (const auto& [edge, n] : runs)
        if (n != 1 || !runs.count({edge.second, edge.first})) return false;
    return true;
}

inline std::string bad_part(const TriMesh& rest, const Points& v) {
    const Triangles& f = rest.triangles;
    const std::vector<int> part = parts(f, rest.num_vertices());
    std::map<int, int> first;
    for (int t = 0; t < f.rows(); ++t) first.try_emplace(part[t], t);
    const auto volume = [&](const Points& at, int p) {
        double sum = 0;
        for (int t = 0; t < f.rows(); ++t)
            if (part[t] == p) sum += corner(at, f, t, 0).dot(corner(at, f, t, 1).cross(corner(at, f, t, 2)));
        return sum;
    };
    for (const auto& [p, t] : first) {
        if (!is_closed(f, part, p)) continue;
        if (!(volume(v, p) * volume(rest.vertices, p) > 0)) return "inside out: part of " + std::to_string(t);
        for (const auto& [q, s] : first)
            if (q != p && is_inside(v, f, part, p, corner(v, f, s, 0)) !=
                              is_inside(rest.vertices, f, part, p, corner(rest.vertices, f, s, 0)))
                return "swallowed: part of " + std::to_string(s);
    }
    return {};
}

/// What is wrong, or an empty text. @param fixed triangles
inline std::string defect(const TriMesh& rest, const Points& v, const std::vector<int>& fixed) {
    const Triangles& f = rest.triangles;
    if (!v.allFinite()) return "not finite";
    for (const int t : fixed)
        for (int k = 0; k < 3; ++k)
            if (v.row(f(t, k)) != rest.vertices.row(f(t, k))) return "fixed " + std::to_string(t);
    std::string words = bad_triangle(rest, v);
    if (words.empty()) words = bad_part(rest, v);
    for (int s = 0; words.empty() && s < f.rows(); ++s)
        for (int t = s + 1; t < f.rows(); ++t) {
            bool apart = false;
            for (int c = 0; c < 3; ++c) {
                const auto x = [&](int r, int k) { return v(f(r, k), c); };
                apart = apart || std::max({x(s, 0), x(s, 1), x(s, 2)}) < std::min({x(t, 0), x(t, 1), x(t, 2)}) ||
                        std::max({x(t, 0), x(t, 1), x(t, 2)}) < std::min({x(s, 0), x(s, 1), x(s, 2)});
            }
            if (!apart && crosses(v, f, s, t) && !crosses(rest.vertices, f, s, t))
                return "crossing " + std::to_string(s) + " and " + std::to_string(t);
        }
    return words;
}

}  // namespace strake::brute_force
