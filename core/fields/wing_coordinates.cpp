#include "core/fields/wing_coordinates.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace strake {
namespace {

using Eigen::Vector3d;
using Numbers = Eigen::Matrix<double, 5, 1>;

/// Legendre polynomials and their slopes.
void set_legendre(double t, std::vector<double>& value, std::vector<double>& slope) {
    value[0] = 1, slope[0] = 0;
    if (value.size() > 1) value[1] = t, slope[1] = 1;
    for (std::size_t n = 1; n + 1 < value.size(); ++n) {
        const auto d = static_cast<double>(n);
        value[n + 1] = ((2 * d + 1) * t * value[n] - d * value[n - 1]) / (d + 1);
        slope[n + 1] = slope[n - 1] + (2 * d + 1) * value[n];
    }
}

}  // namespace

WingCoordinates::WingCoordinates(WingLines lines) : lines_(std::move(lines)) {
    const auto& sections = lines_.sections;
    if (sections.size() < 2) throw InvalidInput("fields: a wing of fewer than two sections has no coordinates");
    for (std::size_t i = 0; i < sections.size(); ++i) {
        const WingLines::Section& of = sections[i];
        if (!(of.chord > 0 && of.thickness > 0) || (i > 0 && !(of.place > sections[i - 1].place)))
            throw InvalidInput(text("fields: the wing's section at ", 100 * of.place, " % of its semispan has chord ",
                                    of.chord, " and thickness ", of.thickness,
                                    "; both must be > 0, and places ascend"));
        value_.emplace_back(of.front, of.height, of.chord, of.rise, of.thickness);
    }
    // Of parabolas through three sections; a straight edge stays straight.
    const std::size_t n = sections.size();
    const auto secant = [&](std::size_t i) {
        return Numbers((value_[i + 1] - value_[i]) / (sections[i + 1].place - sections[i].place));
    };
    slope_.resize(n);
    for (std::size_t i = 1; i + 1 < n; ++i) {
        const double before = sections[i].place - sections[i - 1].place,
                     after = sections[i + 1].place - sections[i].place;
        slope_[i] = (after * secant(i - 1) + before * secant(i)) / (before + after);
    }
    slope_.front() = n > 2 ? Numbers(2 * secant(0) - slope_[1]) : secant(0);
    slope_.back() = n > 2 ? Numbers(2 * secant(n - 2) - slope_[n - 2]) : secant(0);
}

WingCoordinates::Values WingCoordinates::section_at(double s) const {
    const auto& sections = lines_.sections;
    if (s <= sections.front().place)
        return {value_.front() + (s - sections.front().place) * slope_.front(), slope_.front()};
    if (s >= sections.back().place) {
        Values beyond{value_.back() + (s - sections.back().place) * slope_.back(), slope_.back()};
        for (const int k : {2, 4})  // a chord or thickness that would vanish does not
            if (const double least = 0.5 * value_.back()[k]; beyond.value[k] < least)
                beyond.value[k] = least, beyond.slope[k] = 0;
        return beyond;
    }
    std::size_t k = 1;
    while (sections[k].place < s) ++k;
    const double h = sections[k].place - sections[k - 1].place, t = (s - sections[k - 1].place) / h;
    const Numbers &a = value_[k - 1], &b = value_[k], &da = slope_[k - 1], &db = slope_[k];
    const double t2 = t * t, t3 = t2 * t;
    return {(2 * t3 - 3 * t2 + 1) * a + (t3 - 2 * t2 + t) * h * da + (3 * t2 - 2 * t3) * b + (t3 - t2) * h * db,
            (6 * t2 - 6 * t) / h * (a - b) + (3 * t2 - 4 * t + 1) * da + (3 * t2 - 2 * t) * db};
}

WingCoordinates::At WingCoordinates::at(const Vector3d& x) const {
    At at{};
    const double along = lines_.span.dot(x) - lines_.centre;
    at.side = lines_.is_both && along < 0 ? -1 : 1;
    at.s = (at.side * along - lines_.root) / lines_.reach;
    at.by_s = at.side / lines_.reach * lines_.span;
    const Values is = section_at(at.s);
    const double front = is.value[0], height = is.value[1], chord = is.value[2], rise = is.value[3],
                 half = 0.5 * is.value[4];
    at.xi = (lines_.downstream.dot(x) - front) / chord;
    at.by_xi = (lines_.downstream - (is.slope[0] + at.xi * is.slope[2]) * at.by_s) / chord;
    at.eta = (lines_.up.dot(x) - height - at.xi * rise) / half;
    at.by_eta =
        (lines_.up - (is.slope[1] + at.xi * is.slope[3] + at.eta * 0.5 * is.slope[4]) * at.by_s - rise * at.by_xi) /
        half;
    return at;
}

WingFunctions::WingFunctions(const WingCoordinates& wing, const FieldFrame& frame,
                             const std::vector<std::array<int, 3>>& numbers)
    : wing_(wing), frame_(frame) {
    std::array<int, 3> last{0, 0, 0};
    for (const auto& number : numbers)
        for (std::size_t k = 0; k < 3; ++k) last[k] = std::max(last[k], number[k]);
    std::size_t k = 0;
    for (Along* along : {&span_, &chord_, &across_}) {
        along->value.resize(static_cast<std::size_t>(last[k]) + 1);
        along->slope.resize(static_cast<std::size_t>(last[k++]) + 1);
    }
    legendre_.value.resize(span_.value.size() / 2 + 1);
    legendre_.slope.resize(legendre_.value.size());
}

void WingFunctions::set_span() {
    set_legendre(2 * at_.s - 1, legendre_.value, legendre_.slope);
    span_.value[0] = 1, span_.slope[0] = 0;
    for (std::size_t n = 1; n < span_.value.size(); ++n) {
        const std::size_t degree = (n + 1) / 2 - 1;
        const double sign = n % 2 == 1 ? at_.side : 1, value = legendre_.value[degree];
        span_.value[n] = sign * at_.s * value;
        span_.slope[n] = sign * (value + 2 * at_.s * legendre_.slope[degree]);
    }
}

void WingFunctions::set_chord() {
    set_legendre(2 * at_.xi - 1, chord_.value, chord_.slope);
    if (chord_.slope.size() > 1) chord_.slope[1] = 2;
    for (std::size_t k = chord_.value.size(); k-- > 2;) {  // from the last: it needs the polynomials before
        chord_.slope[k] = 2 * chord_.value[k - 1];
        chord_.value[k] = (chord_.value[k] - chord_.value[k - 2]) / (2 * static_cast<double>(k) - 1);
    }
}

void WingFunctions::set(const Vector3d& x) {
    at_ = wing_.at(x);
    local_ = frame_.local(x);
    set_span();
    set_chord();
    across_.value[0] = 1, across_.slope[0] = 0;
    for (std::size_t k = 1; k < across_.value.size(); ++k) {
        across_.value[k] = across_.value[k - 1] * at_.eta;
        across_.slope[k] = static_cast<double>(k) * across_.value[k - 1];
    }
}

double WingFunctions::value(const std::array<int, 3>& number) const {
    if (number[0] < 0) return local_[-1 - number[0]];
    const auto [i, j, k] = number;
    return span_.value[static_cast<std::size_t>(i)] * chord_.value[static_cast<std::size_t>(j)] *
           across_.value[static_cast<std::size_t>(k)];
}

Vector3d WingFunctions::gradient(const std::array<int, 3>& number) const {
    if (number[0] < 0) {
        const int k = -1 - number[0];
        return frame_.half[k] > 0 ? Vector3d(frame_.axes.col(k) / frame_.half[k]) : Vector3d(Vector3d::Zero());
    }
    const auto i = static_cast<std::size_t>(number[0]), j = static_cast<std::size_t>(number[1]),
               k = static_cast<std::size_t>(number[2]);
    return span_.slope[i] * chord_.value[j] * across_.value[k] * at_.by_s +
           span_.value[i] * chord_.slope[j] * across_.value[k] * at_.by_xi +
           span_.value[i] * chord_.value[j] * across_.slope[k] * at_.by_eta;
}

}  // namespace strake
