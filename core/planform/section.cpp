#include "core/planform/section.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace strake {
namespace {

constexpr double degree = std::numbers::pi / 180;
constexpr double corner_angle = 50 * degree;  ///< of a trailing edge
constexpr double round_end = 0.002;           ///< of the chord: points of a rounded trailing edge
constexpr double aft_share = 0.03;            ///< of the chord: where corners are looked for
constexpr double neighbour_rel = 2e-4;        ///< of the chord: nearer points say nothing about the curve
constexpr double nose_share = 0.04;           ///< of the chord: points of the radius
constexpr double max_nose_height = 0.3;       ///< tenths of a chord: farther from the first guess it is no nose
constexpr double end_share = 0.05;            ///< of the chord: trailing-edge angle

double distance(const PlanePoint& a, const PlanePoint& b) {
    return std::hypot(a.x.value - b.x.value, a.z.value - b.z.value);
}

/// Index of the point at least `reach` from point i, forwards or backwards; -1 beyond an open end.
int neighbour(const Outline& outline, int i, int step, double reach) {
    const int count = static_cast<int>(outline.points.size());
    for (int k = 1; k < count; ++k) {
        int j = i + step * k;
        if (outline.is_closed) j = ((j % count) + count) % count;
        if (j < 0 || j >= count) return -1;
        if (distance(outline.points[static_cast<std::size_t>(i)], outline.points[static_cast<std::size_t>(j)]) >= reach)
            return j;
    }
    return -1;
}

/// Turning of the outline at point i, in [0, pi]; pi at an open end.
double turning(const Outline& outline, int i, double reach) {
    const int before = neighbour(outline, i, -1, reach), after = neighbour(outline, i, 1, reach);
    if (before < 0 || after < 0) return std::numbers::pi;
    const auto at = [&](int k) -> const PlanePoint& { return outline.points[static_cast<std::size_t>(k)]; };
    const double ax = at(i).x.value - at(before).x.value, az = at(i).z.value - at(before).z.value;
    const double bx = at(after).x.value - at(i).x.value, bz = at(after).z.value - at(i).z.value;
    return std::atan2(std::abs(ax * bz - az * bx), ax * bx + az * bz);
}

/// Solves a x = b for a small symmetric positive definite system by elimination.
std::vector<Varying> solved(std::vector<std::vector<Varying>> a, std::vector<Varying> b) {
    const std::size_t n = b.size();
    for (std::size_t k = 0; k < n; ++k)
        for (std::size_t i = k + 1; i < n; ++i) {
            const Varying factor = a[i][k] / a[k][k];
            for (std::size_t j = k; j < n; ++j) a[i][j] = a[i][j] - factor * a[k][j];
            b[i] = b[i] - factor * b[k];
        }
    for (std::size_t k = n; k-- > 0;) {
        for (std::size_t j = k + 1; j < n; ++j) b[k] = b[k] - a[k][j] * b[j];
        b[k] = b[k] / a[k][k];
    }
    return b;
}

}  // namespace

std::optional<Airfoil> Airfoil::from(std::vector<Outline> outlines, double corner) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const Outline& outline : outlines)
        for (const PlanePoint& p : outline.points) low = std::min(low, p.x.value), high = std::max(high, p.x.value);
    if (!(high > low)) return {};
    Airfoil airfoil;
    airfoil.outlines_ = std::move(outlines);
    airfoil.corner_ = corner;
    airfoil.find_trailing_edge();
    airfoil.find_leading_edge();
    airfoil.set_chord();
    if (!(airfoil.chord_.value > 0)) return {};
    airfoil.refine_leading_edge();
    // The corners by their height above the chord line.
    if (dot(airfoil.upper_end_ - airfoil.lower_end_, airfoil.up_).value < 0)
        std::swap(airfoil.upper_end_, airfoil.lower_end_);
    return airfoil;
}

namespace {

/// The mean of the last points, with weights that fall to zero: it does not jump from one of them to the next.
PlanePoint round_trailing_edge(const Outline& outline, int aftmost, double size) {
    const Varying last = outline.points[static_cast<std::size_t>(aftmost)].x;
    std::vector<Varying> weights, x, z;
    for (const PlanePoint& p : outline.points) {
        const Varying near = 1 - (1 / (round_end * size)) * (last - p.x);
        if (!(near.value > 0)) continue;
        weights.push_back(near * near);
        x.push_back(weights.back() * p.x);
        z.push_back(weights.back() * p.z);
    }
    const Varying total = sum(weights);
    return {sum(x) / total, sum(z) / total};
}

}  // namespace

void Airfoil::find_trailing_edge() {
    const Outline* aft = nullptr;
    double low = std::numeric_limits<double>::infinity(), high = -low;
    int aftmost = 0;
    for (const Outline& outline : outlines_)
        for (std::size_t i = 0; i < outline.points.size(); ++i) {
            const double x = outline.points[i].x.value;
            low = std::min(low, x);
            if (x > high) high = x, aft = &outline, aftmost = static_cast<int>(i);
        }
    struct Corner {
        double turn;
        int at;
    };
    std::vector<Corner> corners;
    const double size = high - low;
    for (int i = 0; i < static_cast<int>(aft->points.size()); ++i)
        if (aft->points[static_cast<std::size_t>(i)].x.value >= high - aft_share * size)
            if (const double turn = turning(*aft, i, 1e-6 * size); turn > corner_angle) corners.push_back({turn, i});
    std::stable_sort(corners.begin(), corners.end(), [](const Corner& a, const Corner& b) { return a.turn > b.turn; });
    const auto at = [&](int i) -> const PlanePoint& { return aft->points[static_cast<std::size_t>(i)]; };
    upper_end_ = lower_end_ = corners.empty() ? round_trailing_edge(*aft, aftmost, size) : at(corners[0].at);
    if (corners.size() > 1) lower_end_ = at(corners[1].at);
    trailing_ = 0.5 * (upper_end_ + lower_end_);
    if (corners.size() > 1) thick_end_ = length(upper_end_ - lower_end_);
}

void Airfoil::find_leading_edge() {
    const Outline* fore = nullptr;
    int first = 0;
    double farthest = -1;
    for (const Outline& outline : outlines_)
        for (std::size_t i = 0; i < outline.points.size(); ++i)
            if (const double d = distance(outline.points[i], trailing_); d > farthest)
                farthest = d, fore = &outline, first = static_cast<int>(i);
    const auto at = [&](int i) -> const PlanePoint& { return fore->points[static_cast<std::size_t>(i)]; };
    const double reach = neighbour_rel * farthest;
    const int before = neighbour(*fore, first, -1, reach), after = neighbour(*fore, first, 1, reach);
    leading_ = at(first);
    nose_turning_ = turning(*fore, first, reach);
    sharp_nose_ = before < 0 || after < 0 || nose_turning_ > corner_;
    if (sharp_nose_) return;
    // Parameters -a, 0, b along the three points; the parabola through their squared distances is largest at t.
    const PlanePoint p = at(before), q = at(first), r = at(after);
    const Varying a = length(q - p), b = length(r - q);
    const auto square = [&](const PlanePoint& point) { return dot(point - trailing_, point - trailing_); };
    const Varying fall_a = (square(q) - square(p)) / a, fall_b = (square(r) - square(q)) / b;
    const Varying curvature = (fall_b - fall_a) / (a + b);
    const Varying slope = fall_a + a * curvature;
    const Varying t = -slope / (2 * curvature);
    leading_ =
        ((t * (t - b)) / (a * (a + b))) * p + (((t + a) * (b - t)) / (a * b)) * q + ((t * (t + a)) / (b * (a + b))) * r;
}

void Airfoil::set_chord() {
    const PlanePoint line = trailing_ - leading_;
    chord_ = length(line);
    if (!(chord_.value > 0)) return;
    along_ = {line.x / chord_, line.z / chord_};
    up_ = {-along_.z, along_.x};
}

Varying Airfoil::twist() const { return atan2(leading_.z - trailing_.z, trailing_.x - leading_.x); }

PlanePoint Airfoil::in_frame(const PlanePoint& p) const {
    const PlanePoint from = p - leading_;
    return {dot(from, along_), dot(from, up_)};
}

std::optional<Airfoil::Heights> Airfoil::heights_at(const Varying& distance) const {
    std::optional<Heights> found;
    const auto chordwise = [&](const PlanePoint& p) {
        return (p.x.value - leading_.x.value) * along_.x.value + (p.z.value - leading_.z.value) * along_.z.value;
    };
    for (const Outline& outline : outlines_) {
        const std::size_t count = outline.points.size();
        for (std::size_t i = 0; i + (outline.is_closed ? 0 : 1) < count; ++i) {
            const PlanePoint &p = outline.points[i], &q = outline.points[(i + 1) % count];
            const double a = chordwise(p), b = chordwise(q);
            if ((a < distance.value) == (b < distance.value)) continue;
            const PlanePoint from = in_frame(p), to = in_frame(q);
            const Varying z = from.z + (distance - from.x) / (to.x - from.x) * (to.z - from.z);
            if (!found) found = Heights{z, z};
            if (z.value > found->upper.value) found->upper = z;
            if (z.value < found->lower.value) found->lower = z;
        }
    }
    return found;
}

Airfoil::Heights Airfoil::heights(double chord_fraction) const {
    const auto found = heights_at(chord_fraction * chord_);
    if (!found) throw InvalidInput(text("the section has no outline at ", 100 * chord_fraction, " % of the chord"));
    return *found;
}

Varying Airfoil::thickness(double chord_fraction) const {
    const Heights at = heights(chord_fraction);
    return at.upper - at.lower;
}

/// Largest magnitude over the points of the outlines between 0.5 % and 99 % of the chord: piecewise linear curves have
/// their largest differences there.
template <class Of>
Airfoil::Extreme Airfoil::extreme(const Of& of) const {
    // First by values alone: derivatives are needed of one point only.
    std::vector<Outline> plain = outlines_;
    for (Outline& outline : plain)
        for (PlanePoint& p : outline.points) p = {p.x.value, p.z.value};
    Airfoil values = *this;
    values.outlines_ = std::move(plain);
    values.leading_ = {leading_.x.value, leading_.z.value};
    values.along_ = {along_.x.value, along_.z.value};
    values.up_ = {up_.x.value, up_.z.value};
    double best = -1;
    std::pair<std::size_t, std::size_t> where{0, 0};
    for (std::size_t o = 0; o < outlines_.size(); ++o)
        for (std::size_t i = 0; i < outlines_[o].points.size(); ++i) {
            const Varying at = values.in_frame(values.outlines_[o].points[i]).x;
            if (at.value < 0.005 * chord_.value || at.value > 0.99 * chord_.value) continue;
            const auto heights = values.heights_at(at);
            if (heights && std::abs(of(*heights).value) > best) best = std::abs(of(*heights).value), where = {o, i};
        }
    if (best < 0) return {0.5, 0};
    const Varying at = in_frame(outlines_[where.first].points[where.second]).x;
    const auto heights = heights_at(at);
    return {at.value / chord_.value, heights ? of(*heights) / chord_ : Varying(0)};
}

namespace {
Varying thickness_of(const Airfoil::Heights& h) { return h.upper - h.lower; }
Varying mean_of(const Airfoil::Heights& h) { return 0.5 * (h.upper + h.lower); }
}  // namespace

Varying Airfoil::max_thickness() const { return extreme(thickness_of).value; }
Varying Airfoil::max_camber() const { return extreme(mean_of).value; }
double Airfoil::max_thickness_at() const { return extreme(thickness_of).fraction; }
double Airfoil::max_camber_at() const { return extreme(mean_of).fraction; }

/// x = sum a_k z^k near the leading edge, x in chords, z in tenths of a chord. Nothing where too few points round no
/// nose.
std::optional<std::array<Varying, 5>> Airfoil::nose(int* num_points) const {
    constexpr int terms = 5;
    std::vector<std::vector<Varying>> a(terms, std::vector<Varying>(terms));
    std::vector<Varying> b(terms);
    int count = 0;
    for (const Outline& outline : outlines_)
        for (const PlanePoint& p : outline.points) {
            if (dot(along_, p - leading_).value > nose_share * chord_.value) continue;
            const PlanePoint in = in_frame(p);
            ++count;
            const Varying x = in.x / chord_, z = 10 * in.z / chord_;
            const Varying rest = 1 - x / nose_share, weight = rest * rest;
            std::array<Varying, 2 * terms - 1> power;
            power[0] = weight;
            for (std::size_t k = 1; k < power.size(); ++k) power[k] = power[k - 1] * z;
            for (std::size_t i = 0; i < terms; ++i) {
                for (std::size_t j = 0; j < terms; ++j) a[i][j] = a[i][j] + power[i + j];
                b[i] = b[i] + power[i] * x;
            }
        }
    if (num_points) *num_points = count;
    if (count < terms + 2) return {};
    const std::vector<Varying> fit = solved(std::move(a), std::move(b));
    if (!(fit[2].value > 0)) return {};
    return std::array<Varying, 5>{fit[0], fit[1], fit[2], fit[3], fit[4]};
}

/// To the polynomial's minimum, by Newton's method; its last step carries the derivatives.
void Airfoil::refine_leading_edge() {
    if (sharp_nose_) return;
    int count = 0;
    const auto fit = nose(&count);
    if (!fit) return;
    const std::array<Varying, 5>& a = *fit;
    double at = 0;
    const auto first = [&](double z) {
        return a[1].value + z * (2 * a[2].value + z * (3 * a[3].value + z * 4 * a[4].value));
    };
    const auto second = [&](double z) { return 2 * a[2].value + z * (6 * a[3].value + z * 12 * a[4].value); };
    for (int k = 0; k < 30 && second(at) > 0; ++k) at -= first(at) / second(at);
    if (!(second(at) > 0 && std::abs(at) < max_nose_height && std::abs(first(at)) < 1e-12)) return;
    const Varying slope = a[1] + at * (2 * a[2] + at * (3 * a[3] + (4 * at) * a[4]));
    const Varying z = at - slope / second(at);
    const Varying x = a[0] + z * (a[1] + z * (a[2] + z * (a[3] + z * a[4])));
    num_nose_points_ = count;
    leading_ = leading_ + (x * chord_) * along_ + (0.1 * z * chord_) * up_;
    set_chord();
}

std::optional<Varying> Airfoil::leading_edge_radius() const {
    if (sharp_nose_) return Varying(0);
    const auto fit = nose();
    if (!fit) return {};
    const Varying tilt = 10 * (*fit)[1], square = 1 + tilt * tilt;
    const Varying radius = square * sqrt(square) / (200 * (*fit)[2]);
    if (!(radius.value > 0) || radius.value > 1) return {};  // the points do not round a nose
    return radius;
}

Varying Airfoil::trailing_edge_angle() const {
    const Heights at = heights(1 - end_share);
    const PlanePoint above = in_frame(upper_end_), below = in_frame(lower_end_);
    const Varying start = (1 - end_share) * chord_;
    return atan2(at.upper - above.z, above.x - start) + atan2(below.z - at.lower, below.x - start);
}

Varying Airfoil::area(double from, double to) const {
    // Sum of the trapezoids under the segments, cut at both ends; what closes an open outline is vertical enough to be
    // outside of the range.
    const double low = from * chord_.value, high = to * chord_.value;
    std::vector<Varying> terms;
    for (const Outline& outline : outlines_) {
        const std::size_t count = outline.points.size();
        std::vector<Varying> own;
        double signed_area = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const PlanePoint p = in_frame(outline.points[i]), q = in_frame(outline.points[(i + 1) % count]);
            signed_area += (q.x.value - p.x.value) * (p.z.value + q.z.value) / 2;
            const bool ascends = p.x.value < q.x.value;
            const PlanePoint &a = ascends ? p : q, &b = ascends ? q : p;
            if (b.x.value <= low || a.x.value >= high || a.x.value == b.x.value) continue;
            const auto height = [&](const Varying& x) { return a.z + (x - a.x) / (b.x - a.x) * (b.z - a.z); };
            const Varying begin = a.x.value < low ? from * chord_ : a.x, end = b.x.value > high ? to * chord_ : b.x;
            const Varying one = (end - begin) * 0.5 * (height(begin) + height(end));
            own.push_back(ascends ? one : -one);
        }
        const Varying total = sum(own);
        terms.push_back(signed_area < 0 ? -total : total);
    }
    return sum(terms);
}

std::vector<std::vector<std::pair<double, double>>> Airfoil::in_chords() const {
    std::vector<std::vector<std::pair<double, double>>> all;
    for (const Outline& outline : outlines_) {
        auto& one = all.emplace_back();
        for (const PlanePoint& p : outline.points) {
            const PlanePoint at = in_frame(p);
            one.emplace_back(at.x.value / chord_.value, at.z.value / chord_.value);
        }
        if (outline.is_closed) one.push_back(one.front());
    }
    return all;
}

}  // namespace strake
