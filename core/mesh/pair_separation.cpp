#include "core/mesh/pair_test.hpp"

#include <Eigen/Geometry>

#include <limits>

/// Separating planes in floating point. A plane's normal m may be any vector: rounding errors in it are harmless. Only
/// the error of m.(x - o) needs a bound: four roundings of 2^-53 each relative to sum |m_i| |x_i - o_i|, for which
/// twice as much is taken, and for underflow the smallest normal number.
namespace strake {
namespace {

using Eigen::Vector3d;

constexpr double unit_error = 1e-15;    ///< of a product of two vectors: above 2 * 4 * 2^-53
constexpr double volume_error = 2e-15;  ///< of a product of three, relative to its permanent: above 2 * 8 * 2^-53
constexpr double tiny = std::numeric_limits<double>::min();

/// Sign of m.d, or 0 where rounding might have turned it.
int side(const Vector3d& m, const Vector3d& d) {
    const double value = m.dot(d), error = unit_error * m.cwiseAbs().dot(d.cwiseAbs()) + tiny;
    return value > error ? 1 : value < -error ? -1 : 0;
}

/// Sign of a.(b x c), or 0 where rounding might have turned it.
int side_of_plane(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
    const auto p = [](const Vector3d& x, const Vector3d& y, int i, int j) {
        return std::abs(x[i] * y[j]) + std::abs(x[j] * y[i]);
    };
    const double value = a.dot(b.cross(c));
    const double size =
        std::abs(a[0]) * p(b, c, 1, 2) + std::abs(a[1]) * p(b, c, 2, 0) + std::abs(a[2]) * p(b, c, 0, 1);
    const double error = volume_error * size + tiny;
    return value > error ? 1 : value < -error ? -1 : 0;
}

/// The pair relative to the first corner of s.
struct Pair {
    std::array<Vector3d, 3> s, t;
    Vector3d reach;  ///< largest |coordinate|

    Pair(const Corners& a, const Corners& b) : reach(Vector3d::Zero()) {
        for (int k = 0; k < 3; ++k) {
            s[k] = a.at[k] - a.at[0];
            t[k] = b.at[k] - a.at[0];
            reach = reach.cwiseMax(s[k].cwiseAbs()).cwiseMax(t[k].cwiseAbs());
        }
    }
    bool separated_along(const Vector3d& m) const {
        const double s0 = m.dot(s[0]), s1 = m.dot(s[1]), s2 = m.dot(s[2]), t0 = m.dot(t[0]), t1 = m.dot(t[1]),
                     t2 = m.dot(t[2]);
        const double gap = 2 * (unit_error * m.cwiseAbs().dot(reach) + tiny);
        return std::min({t0, t1, t2}) - std::max({s0, s1, s2}) > gap ||
               std::min({s0, s1, s2}) - std::max({t0, t1, t2}) > gap;
    }
};

bool apart(const Corners& a, const Corners& b) {
    const Pair p(a, b);
    const Vector3d s_normal = p.s[1].cross(p.s[2]), t_normal = (p.t[1] - p.t[0]).cross(p.t[2] - p.t[0]);
    const Vector3d centres = (p.t[0] + p.t[1] + p.t[2]) - (p.s[0] + p.s[1] + p.s[2]);
    if (p.separated_along(s_normal) || p.separated_along(t_normal) || p.separated_along(centres)) return true;
    std::array<Vector3d, 3> s_edge, t_edge;
    for (int k = 0; k < 3; ++k) {
        s_edge[k] = p.s[(k + 1) % 3] - p.s[k];
        t_edge[k] = p.t[(k + 1) % 3] - p.t[k];
        if (p.separated_along(s_normal.cross(s_edge[k])) || p.separated_along(t_normal.cross(t_edge[k]))) return true;
    }
    for (const Vector3d& e : s_edge)
        for (const Vector3d& f : t_edge)
            if (p.separated_along(e.cross(f))) return true;
    return false;
}

/// Do the cones of (a, b) and (c, d) lie strictly on two sides of the plane with normal m through their apex?
bool cones_separated(const Vector3d& m, const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d) {
    const int of_a = side(m, a);
    return of_a != 0 && side(m, b) == of_a && side(m, c) == -of_a && side(m, d) == -of_a;
}

/// One shared corner, the apex; the other corners relative to it are a, b in one triangle, c, d in the other.
bool apart_beside_corner(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d) {
    const int of_c = side_of_plane(c, a, b);  // the other triangle meets the plane of this one in the apex only
    if (of_c != 0 && side_of_plane(d, a, b) == of_c) return true;
    const int of_a = side_of_plane(a, c, d);
    if (of_a != 0 && side_of_plane(b, c, d) == of_a) return true;
    const std::array<Vector3d, 2> s{a.normalized(), b.normalized()}, t{c.normalized(), d.normalized()};
    if (cones_separated(s[0] + s[1] - t[0] - t[1], a, b, c, d)) return true;
    // In the plane: the middle of the gap between two neighbouring edges.
    const Vector3d s_normal = a.cross(b), t_normal = c.cross(d);
    const Vector3d up = s_normal.dot(t_normal) < 0 ? Vector3d(s_normal - t_normal) : Vector3d(s_normal + t_normal);
    for (const Vector3d& e : s)
        for (const Vector3d& f : t)
            if (cones_separated(up.cross(e + f), a, b, c, d)) return true;
    return false;
}

/// A shared edge from the origin to `edge`, and the corners opposite to it.
bool apart_beside_edge(const Vector3d& edge, const Vector3d& a, const Vector3d& b) {
    if (side_of_plane(edge, a, b) != 0) return true;  // two planes
    int drop = 0;  // seen along the axis nearest to the normal they lie on two sides of the edge
    edge.cross(a).cwiseAbs().maxCoeff(&drop);
    const int x = (drop + 1) % 3, y = (drop + 2) % 3;
    const Vector3d across = Vector3d::Unit(x) * -edge[y] + Vector3d::Unit(y) * edge[x];
    return side(across, a) * side(across, b) < 0;
}

}  // namespace

bool surely_disjoint(const Corners& s, const Corners& t) {
    int num_shared = 0, s_sum = 0, t_sum = 0, s_last = 0, t_last = 0;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            if (s.id[i] == t.id[j]) {
                ++num_shared;
                s_sum += s_last = i;
                t_sum += t_last = j;
            }
    if (num_shared == 0) return apart(s, t);
    const Vector3d& o = s.at[s_last];
    if (num_shared == 1)
        return apart_beside_corner(s.at[(s_last + 1) % 3] - o, s.at[(s_last + 2) % 3] - o, t.at[(t_last + 1) % 3] - o,
                                   t.at[(t_last + 2) % 3] - o);
    return num_shared == 2 && apart_beside_edge(s.at[s_sum - s_last] - o, s.at[3 - s_sum] - o, t.at[3 - t_sum] - o);
}

}  // namespace strake
