#include "core/fields/field_functions.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <map>

namespace strake {
namespace {

constexpr int max_degree = max_polynomial_degree;
constexpr double first_nonlinear = 1;  ///< after the sections of degree two along the axis

/// A component normal to the plane is odd across it, the others are even.
bool is_even(const FieldFrame& frame, const FieldCandidate& candidate) {
    return std::all_of(candidate.terms.begin(), candidate.terms.end(), [&](const FieldCandidate::Term& term) {
        const int parity = term.powers[frame.plane_axis] % 2;
        return parity == (term.axis == frame.plane_axis ? 1 : 0);
    });
}

bool is_there(const FieldFrame& frame, const Powers& p) {
    for (int k = 0; k < 3; ++k)
        if (p[k] > 0 && frame.half[k] == 0) return false;
    return true;
}

std::string powers_name(const FieldFrame& frame, const Powers& p) {
    std::string words;
    for (int k = 0; k < 3; ++k)
        if (p[k] > 0) words += text(frame.letter[k], p[k]);
    return words;
}

/// Motions by one function; rank decides among those of the same order.
struct Ordered {
    double order;
    int rank;
    FieldCandidate candidate;
};

/// Which motions are listed: how far along the axis, and what they may do (empty: anything).
struct Wanted {
    int last_along = max_degree;
    std::vector<std::string> motions{};

    bool has(const char* motion) const {
        return motions.empty() || std::ranges::find(motions, motion) != motions.end();
    }
};

class Listing {
public:
    Listing(const FieldFrame& frame, bool is_symmetric, Wanted wanted)
        : frame_(frame), is_symmetric_(is_symmetric), wanted_(std::move(wanted)) {
        for (int k = 1; k < 3; ++k)
            reach_[k] = frame.half[k] > 0 ? std::clamp(std::sqrt(frame.half[0] / frame.half[k]), 1.0, 6.0) : 1;
    }

    /// All motions of order up to `last`.
    std::vector<FieldCandidate> up_to(double last) {
        found_.clear();
        last_ = last;
        for (int i = 0; i <= std::min<double>(last, wanted_.last_along); ++i) {
            if (wanted_.has("move")) moves(i);
            sections(i);
            for (int j = 0; wanted_.has("move") && order_of({i, j, 0}) <= last && j <= max_degree; ++j)
                for (int k = std::max(0, 2 - j); order_of({i, j, k}) <= last && k <= max_degree; ++k)
                    polynomials({i, j, k});
        }
        std::stable_sort(found_.begin(), found_.end(), [](const Ordered& a, const Ordered& b) {
            return a.order != b.order ? a.order < b.order : a.rank < b.rank;
        });
        std::vector<FieldCandidate> candidates;
        for (Ordered& one : found_) candidates.push_back(std::move(one.candidate));
        return candidates;
    }

private:
    /// Of a polynomial that no section has.
    double order_of(const Powers& p) const { return first_nonlinear + p[0] + reach_[1] * p[1] + reach_[2] * p[2]; }

    void add(double order, int rank, FieldCandidate candidate) {
        if (order > last_ || !wanted_.has(motion_of(candidate.name).c_str())) return;
        for (const FieldCandidate::Term& term : candidate.terms)
            if (!is_there(frame_, term.powers)) return;
        if (is_symmetric_ && !is_even(frame_, candidate)) return;
        found_.push_back({order, rank, std::move(candidate)});
    }
    std::string section(const char* what, int axis, int degree) const {
        return text("section.", what, frame_.letter[axis], ".", degree);
    }

    void moves(int i) {
        for (int c = 0; c < 3; ++c) add(i == 1 ? 0.9 : i, c, {{{c, {i, 0, 0}, 1}}, section("move_", c, i)});
    }

    void sections(int i) {
        const double order = i + 0.5;
        const Powers by_1{i, 1, 0}, by_2{i, 0, 1};
        add(order, 0, {{{2, by_1, frame_.half[1]}, {1, by_2, -frame_.half[2]}}, text("section.twist.", i)});
        add(order, 1, {{{1, by_1, 1}}, section("scale_", 1, i)});
        add(order, 2, {{{2, by_2, 1}}, section("scale_", 2, i)});
        add(order, 3, {{{0, by_1, 1}}, section("tilt_", 1, i)});
        add(order, 4, {{{0, by_2, 1}}, section("tilt_", 2, i)});
        add(order, 5, {{{2, by_1, frame_.half[1]}, {1, by_2, frame_.half[2]}}, text("section.shear.", i)});
        if (frame_.half[2] == 0)  // a flat body has no twist of two terms: its sections are lines
            add(order, 0, {{{2, by_1, 1}}, text("section.twist.", i)});
    }

    void polynomials(const Powers& p) {
        for (int c = 0; c < 3; ++c)
            add(order_of(p), c, {{{c, p, 1}}, text("polynomial.move_", frame_.letter[c], ".", powers_name(frame_, p))});
    }

    const FieldFrame& frame_;
    bool is_symmetric_;
    Wanted wanted_;
    double last_ = 0;
    std::array<double, 3> reach_{1, 1, 1};
    std::vector<Ordered> found_;
};

/// Neither along the last axis of the frame nor changing along it.
bool is_extruded(const FieldCandidate& candidate) {
    return std::all_of(candidate.terms.begin(), candidate.terms.end(),
                       [](const FieldCandidate::Term& term) { return term.axis != 2 && term.powers[2] == 0; });
}

/// t^n in Legendre polynomials.
std::vector<double> monomial(int n) {
    std::vector<double> by{1};
    for (int k = 0; k < n; ++k) {
        std::vector<double> next(by.size() + 1, 0);
        for (std::size_t l = 0; l < by.size(); ++l) {
            next[l + 1] += by[l] * (static_cast<double>(l) + 1) / (2.0 * static_cast<double>(l) + 1);
            if (l > 0) next[l - 1] += by[l] * static_cast<double>(l) / (2.0 * static_cast<double>(l) + 1);
        }
        by = std::move(next);
    }
    return by;
}

using Complex = std::complex<double>;

/// Coefficients of eta^(p + q - b) zeta^b in w^p w'^q.
std::vector<Complex> powers_of_w(int p, int q) {
    std::vector<Complex> by{1};
    for (int k = 0; k < p + q; ++k) {
        std::vector<Complex> next(by.size() + 1, 0);
        for (std::size_t b = 0; b < by.size(); ++b) {
            next[b] += by[b];
            next[b + 1] += by[b] * Complex(0, k < p ? 1 : -1);
        }
        by = std::move(next);
    }
    return by;
}

/// Motions about the first axis of the frame that are the same in every sector.
class RotationalListing {
public:
    RotationalListing(const FieldFrame& frame, bool is_symmetric, const ShapeKind& kind, Wanted wanted)
        : frame_(frame), is_symmetric_(is_symmetric), kind_(kind), wanted_(std::move(wanted)) {
        if (frame.half[1] > 0) reach_ = std::clamp(std::sqrt(frame.half[0] / frame.half[1]), 1.0, 6.0);
    }

    std::vector<FieldCandidate> up_to(double last) {
        found_.clear();
        last_ = last;
        for (int i = 0; i <= std::min<double>(last, wanted_.last_along); ++i)
            for (int p = 0; order_of(i, p) <= last && p <= max_degree; ++p)
                for (int q = 0; order_of(i, p + q) <= last && p + q <= max_degree; ++q) both(i, p, q);
        std::stable_sort(found_.begin(), found_.end(), [](const Ordered& a, const Ordered& b) {
            return a.order != b.order ? a.order < b.order : a.rank < b.rank;
        });
        std::vector<FieldCandidate> candidates;
        for (Ordered& one : found_) candidates.push_back(std::move(one.candidate));
        return candidates;
    }

private:
    double order_of(int i, int degree) const {
        if (degree == 0) return i == 1 ? 0.9 : i;
        return degree == 1 ? i + 0.5 : first_nonlinear + i + reach_ * degree;
    }
    bool is_same(int p_less_q) const {
        return kind_.type == ShapeKind::Type::revolved ? p_less_q == 0 : p_less_q % kind_.count == 0;
    }
    std::string name(const char* what, int i, int p, int q) const {
        if (p + q <= 1) return text("section.", what, ".", i);
        return text("polynomial.", what, ".", i > 0 ? text(frame_.letter[0], i) : "", "r", p + q,
                    p == q || p == q + 1 ? "" : text("t", p - q));
    }

    void both(int i, int p, int q) {
        const bool turns = kind_.type == ShapeKind::Type::cyclic;
        const std::string along = text("move_", frame_.letter[0]);
        if (wanted_.has("move") && is_same(p - q) && p >= q) {
            add(i, p, q, 0, axial(i, p, q, false), name(along.c_str(), i, p, q));
            if (turns && p > q) add(i, p, q, 1, axial(i, p, q, true), name((along + "_sine").c_str(), i, p, q));
        }
        if (is_same(p - q - 1)) {
            const char *out = p + q == 1 ? "scale" : "out", *around = p + q == 1 ? "twist" : "around";
            if (wanted_.has(out)) add(i, p, q, 2, across(i, p, q, Complex(1, 0)), name(out, i, p, q));
            if (turns && wanted_.has(around)) add(i, p, q, 3, across(i, p, q, Complex(0, 1)), name(around, i, p, q));
        }
    }

    void add(int i, int p, int q, int rank, std::vector<FieldCandidate::Term> terms, std::string name) {
        FieldCandidate candidate{std::move(terms), std::move(name)};
        if (candidate.terms.empty() || (is_symmetric_ && !is_even(frame_, candidate))) return;
        found_.push_back({order_of(i, p + q), rank, std::move(candidate)});
    }

    /// A motion along `axis` by the real function sum_b by[b] eta^(n - b) zeta^b, times P_i(s).
    static void add_terms(int i, int axis, const std::vector<double>& by, std::vector<FieldCandidate::Term>& terms) {
        std::map<Powers, double> sum;
        const int n = static_cast<int>(by.size()) - 1;
        for (int b = 0; b <= n; ++b) {
            if (by[static_cast<std::size_t>(b)] == 0) continue;
            const std::vector<double> eta = monomial(n - b), zeta = monomial(b);
            for (std::size_t j = 0; j < eta.size(); ++j)
                for (std::size_t k = 0; k < zeta.size(); ++k)
                    if (eta[j] * zeta[k] != 0)
                        sum[{i, static_cast<int>(j), static_cast<int>(k)}] +=
                            by[static_cast<std::size_t>(b)] * eta[j] * zeta[k];
        }
        for (const auto& [powers, factor] : sum) terms.push_back({axis, powers, factor});
    }

    static std::vector<FieldCandidate::Term> axial(int i, int p, int q, bool is_sine) {
        std::vector<double> by;
        for (const Complex& c : powers_of_w(p, q)) by.push_back(is_sine ? c.imag() : c.real());
        std::vector<FieldCandidate::Term> terms;
        add_terms(i, 0, by, terms);
        return terms;
    }

    static std::vector<FieldCandidate::Term> across(int i, int p, int q, const Complex& factor) {
        std::vector<double> eta, zeta;
        for (const Complex& c : powers_of_w(p, q)) {
            eta.push_back((factor * c).real());
            zeta.push_back((factor * c).imag());
        }
        std::vector<FieldCandidate::Term> terms;
        add_terms(i, 1, eta, terms);
        add_terms(i, 2, zeta, terms);
        return terms;
    }

    const FieldFrame& frame_;
    bool is_symmetric_;
    ShapeKind kind_;
    Wanted wanted_;
    double last_ = 0, reach_ = 1;
    std::vector<Ordered> found_;
};

/// At least `count`, unless there are no more.
template <class List>
std::vector<FieldCandidate> listed(List&& list, int count, bool is_flat, int last_along) {
    std::vector<FieldCandidate> candidates;
    for (double last = 3; last <= last_along; last *= 1.25) {
        candidates = list.up_to(last);
        if (is_flat) std::erase_if(candidates, [](const FieldCandidate& c) { return !is_extruded(c); });
        if (static_cast<int>(candidates.size()) >= count) break;
    }
    return candidates;
}

}  // namespace

std::vector<FieldCandidate> field_candidates(const FieldFrame& frame, bool is_symmetric, int count,
                                             const std::optional<ShapeKind>& kind,
                                             const std::vector<std::string>& motions, int up_to) {
    const Wanted wanted{up_to, motions};
    if (kind && kind->type != ShapeKind::Type::extruded)
        return listed(RotationalListing(frame, is_symmetric, *kind, wanted), count, false, up_to);
    return listed(Listing(frame, is_symmetric, wanted), count, kind.has_value(), up_to);
}

std::string motion_of(const std::string& name) {
    const std::size_t begin = name.find('.') + 1;
    return name.substr(begin, name.find_first_of("._", begin) - begin);
}

std::vector<FieldCandidate> rigid_candidates(const FieldFrame& frame, bool is_symmetric,
                                             const std::optional<ShapeKind>& kind) {
    std::vector<FieldCandidate> candidates;
    for (int c = 0; c < 3; ++c) candidates.push_back({{{c, {0, 0, 0}, 1}}, "move"});
    for (int c = 0; c < 3; ++c) {
        const int a = (c + 1) % 3, b = (c + 2) % 3;
        FieldCandidate turn{{}, "turn"};
        Powers by_a{0, 0, 0}, by_b{0, 0, 0};
        by_a[a] = by_b[b] = 1;
        if (frame.half[a] > 0) turn.terms.push_back({b, by_a, frame.half[a]});
        if (frame.half[b] > 0) turn.terms.push_back({a, by_b, -frame.half[b]});
        candidates.push_back(turn);
    }
    const bool is_rotational = kind && kind->type != ShapeKind::Type::extruded;
    std::size_t number = 0;  // along the first axis, and about it
    std::erase_if(candidates, [&](const FieldCandidate& candidate) {
        const bool is_about_axis = number++ % 3 == 0;
        return candidate.terms.empty() || (is_symmetric && !is_even(frame, candidate)) ||
               (is_rotational && !is_about_axis) || (kind && !is_rotational && !is_extruded(candidate));
    });
    return candidates;
}

namespace {

constexpr int first_spline = 4;  ///< those before it are polynomials

void set_legendre(double s, int last, std::vector<double>& value, std::vector<double>& slope) {
    if (last >= 1) value[1] = s, slope[1] = 1;
    for (int n = 1; n < last; ++n) {
        value[n + 1] = ((2 * n + 1) * s * value[n] - n * value[n - 1]) / (n + 1);
        slope[n + 1] = slope[n - 1] + (2 * n + 1) * value[n];
    }
}

struct SplineValue {
    double value, slope;
};

/// The cubic B-spline around 0 on knots at the whole numbers.
SplineValue cubic_spline(double t) {
    const double d = std::abs(t), sign = t < 0 ? -1 : 1;
    if (d < 1) return {2.0 / 3 - d * d + d * d * d / 2, sign * (1.5 * d * d - 2 * d)};
    if (d < 2) return {(2 - d) * (2 - d) * (2 - d) / 6, sign * -(2 - d) * (2 - d) / 2};
    return {0, 0};
}

void set_splines(double s, std::vector<double>& value, std::vector<double>& slope) {
    const std::size_t count = value.size();
    std::size_t number = first_spline;
    for (int intervals = 2; number < count; intervals *= 2) {
        const double h = 2.0 / intervals;
        for (int pair = 0; pair < std::max(1, intervals / 4) && number < count; ++pair) {
            const double place = intervals == 2 ? 0 : (2 * pair + 1) * h;
            const SplineValue right = cubic_spline((s - place) / h), left = cubic_spline((s + place) / h);
            if (intervals > 2)
                value[number] = right.value - left.value, slope[number++] = (right.slope - left.slope) / h;
            if (number < count)
                value[number] = right.value + left.value, slope[number++] = (right.slope + left.slope) / h;
        }
    }
}

}  // namespace

FunctionsAlong::FunctionsAlong(AlongAxis kind, double s, int last)
    : value(last + 1, 1), slope(last + 1, 0), kind_(kind) {
    set(s);
}

void FunctionsAlong::set(double s) {
    const int last = static_cast<int>(value.size()) - 1;
    set_legendre(s, kind_ == AlongAxis::splines ? std::min(last, first_spline - 1) : last, value, slope);
    if (kind_ == AlongAxis::splines) set_splines(s, value, slope);
}

}  // namespace strake
