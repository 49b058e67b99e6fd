#include "core/remesh/curves.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace strake {
namespace {

using Eigen::Vector3d;

double angle_between(const Vector3d& u, const Vector3d& v) { return std::atan2(u.cross(v).norm(), u.dot(v)); }

double distance_to_segment(const Vector3d& a, const Vector3d& b, const Vector3d& x) {
    const Vector3d e = b - a;
    const double e2 = e.squaredNorm();
    const double t = e2 > 0 ? std::clamp((x - a).dot(e) / e2, 0.0, 1.0) : 0.0;
    return (x - a - t * e).norm();
}

}  // namespace

int Curves::add(const std::vector<Vector3d>& points, const std::vector<int>& halves, const std::vector<double>& folds,
                bool closed) {
    const int n = static_cast<int>(points.size());
    double s = 0;
    for (int i = 0; i < n; ++i) {
        if (i > 0) s += (points[i] - points[i - 1]).norm();
        points_.push_back(points[i]);
        arc_.push_back(s);
        halves_.push_back(halves[std::min(i, n - 2)]);
        folds_.push_back(folds[std::min(i, n - 2)]);
        const bool inner = i > 0 && i + 1 < n;
        const Vector3d before = inner ? points[i] - points[i - 1] : Vector3d(points[n - 1] - points[n - 2]);
        const Vector3d after = inner ? points[i + 1] - points[i] : Vector3d(points[1] - points[0]);
        turn_.push_back(inner || closed ? angle_between(before, after) : 0.0);
    }
    begin_.push_back(static_cast<int>(points_.size()));
    closed_.push_back(closed);
    return size() - 1;
}

Curves::Place Curves::place(int curve, double s) const {
    double offset = 0;
    if (closed_[curve]) {
        const double period = length(curve);
        offset = period * std::floor(s / period);
        s -= offset;
    }
    const auto first = arc_.begin() + begin_[curve], last = arc_.begin() + begin_[curve + 1];
    const auto after = std::upper_bound(first + 1, last - 1, s);
    return {static_cast<int>(after - arc_.begin()) - 1, offset};
}

Vector3d Curves::at(int curve, double s) const {
    const auto [i, offset] = place(curve, s);
    const double whole = arc_[i + 1] - arc_[i];
    const double t = whole > 0 ? std::clamp((s - offset - arc_[i]) / whole, 0.0, 1.0) : 0.0;
    if (t == 0) return points_[i];
    if (t == 1) return points_[i + 1];
    return points_[i] + t * (points_[i + 1] - points_[i]);
}

int Curves::half_at(int curve, double s) const { return halves_[place(curve, s).segment]; }

Curves::Fold Curves::largest_fold(int curve, double s0, double s1) const {
    const double tiny = 1e-9 * length(curve);
    auto [i, offset] = place(curve, s0 + tiny);
    Fold largest{-1, s0};
    for (double from = s0; from < s1 - tiny;) {
        const double to = std::min(s1, arc_[i + 1] + offset);
        if (folds_[i] > largest.angle) largest = {folds_[i], 0.5 * (from + to)};
        from = to;
        if (++i + 1 < begin_[curve + 1]) continue;
        if (!closed_[curve]) break;
        i = begin_[curve];
        offset += length(curve);
    }
    return largest;
}

double Curves::nearest_vertex(int curve, double s) const {
    const auto [i, offset] = place(curve, s);
    const double before = arc_[i] + offset, after = arc_[i + 1] + offset;
    return s - before <= after - s ? before : after;
}

bool Curves::chord_fits(int curve, double s0, double s1, double slack) const {
    const double period = length(curve);
    if (s1 - s0 >= period * (closed_[curve] ? 0.6 : 2.0)) return false;
    const Vector3d a = at(curve, s0), b = at(curve, s1);
    const double tiny = 1e-12 * period;
    auto [i, offset] = place(curve, s0);
    double farthest = 0, turning = 0;
    if (s0 - offset - arc_[i] <= tiny) turning += 0.5 * turn_[i];
    for (++i; true; ++i) {
        if (i + 1 >= begin_[curve + 1] && closed_[curve]) {  // round to the first point, which is the last
            i = begin_[curve];
            offset += period;
        }
        const double s = arc_[i] + offset;
        if (s >= s1 - tiny) {
            if (s <= s1 + tiny) turning += 0.5 * turn_[i];
            break;
        }
        if (i + 1 >= begin_[curve + 1]) break;
        turning += turn_[i];
        farthest = std::max(farthest, distance_to_segment(a, b, points_[i]));
        if (turning > std::numbers::pi / 3) break;
    }
    if (farthest <= slack) return true;
    return turning <= std::numbers::pi / 3 && farthest <= 5 * slack && farthest <= 1.05 * (s1 - s0) * turning / 8;
}

}  // namespace strake
