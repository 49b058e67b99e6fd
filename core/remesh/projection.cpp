#include "core/remesh/base_surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>

/// Points on the input surface nearest to those beside it.
namespace strake {

using Eigen::Vector3d;

std::array<double, 3> weights_at(const BaseSurface& base, int t, const Vector3d& x) {
    const Vector3d &a = base.points[base.tri[t][0]], &b = base.points[base.tri[t][1]], &c = base.points[base.tri[t][2]];
    const Vector3d n = (b - a).cross(c - a);
    const double whole = n.squaredNorm();
    if (!(whole > 0)) return {1, 0, 0};
    const double wb = std::clamp((c - a).cross(a - x).dot(n) / whole, 0.0, 1.0),
                 wc = std::clamp((a - x).cross(b - a).dot(n) / whole, 0.0, 1.0 - wb);
    return {1 - wb - wc, wb, wc};
}

namespace {

Vector3d weighted_normal(const BaseSurface& base, int t, double wa, double wb, double wc) {
    const Vector3d n =
        wa * base.corner_normal[3 * t] + wb * base.corner_normal[3 * t + 1] + wc * base.corner_normal[3 * t + 2];
    const double length = n.norm();
    return length > 1e-3 ? Vector3d(n / length) : base.normal[t];
}

}  // namespace

Vector3d normal_at(const BaseSurface& base, int t, const Vector3d& x) {
    const auto [wa, wb, wc] = weights_at(base, t, x);
    return weighted_normal(base, t, wa, wb, wc);
}

Vector3d normal_at(const BaseSurface& base, const Foot& foot) {
    return weighted_normal(base, foot.triangle, 1 - foot.wb - foot.wc, foot.wb, foot.wc);
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
    if (arrived && at.distance2 <= reach * reach) return {at.at.point, at.triangle, at.distance2, at.at.wb, at.at.wc};
    const int t = base.tree.closest(base.points, base.tri, base.patch, base.patch[hint], x, at.distance2);
    if (t >= 0) {
        const TrianglePoint p = closest_of(base, t, x);
        const double d2 = (p.point - x).squaredNorm();
        if (d2 < at.distance2) return {p.point, t, d2, p.wb, p.wc};
    }
    return {at.at.point, at.triangle, at.distance2, at.at.wb, at.at.wc};
}

}  // namespace strake
