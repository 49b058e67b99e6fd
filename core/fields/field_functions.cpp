#include "core/fields/field_functions.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <cmath>

namespace strake {
namespace {

constexpr int max_degree = 40;
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

class Listing {
public:
    Listing(const FieldFrame& frame, bool is_symmetric) : frame_(frame), is_symmetric_(is_symmetric) {
        for (int k = 1; k < 3; ++k)
            reach_[k] = frame.half[k] > 0 ? std::clamp(std::sqrt(frame.half[0] / frame.half[k]), 1.0, 6.0) : 1;
    }

    /// All motions of order up to `last`.
    std::vector<FieldCandidate> up_to(double last) {
        found_.clear();
        last_ = last;
        for (int i = 0; i <= std::min<double>(last, max_degree); ++i) {
            moves(i);
            sections(i);
            for (int j = 0; order_of({i, j, 0}) <= last && j <= max_degree; ++j)
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
        if (order > last_) return;
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
    double last_ = 0;
    std::array<double, 3> reach_{1, 1, 1};
    std::vector<Ordered> found_;
};

}  // namespace

std::vector<FieldCandidate> field_candidates(const FieldFrame& frame, bool is_symmetric, int count) {
    Listing listing(frame, is_symmetric);
    std::vector<FieldCandidate> candidates;
    for (double last = 3; last <= max_degree; last *= 1.25) {
        candidates = listing.up_to(last);
        if (static_cast<int>(candidates.size()) >= count) break;
    }
    return candidates;
}

std::vector<FieldCandidate> rigid_candidates(const FieldFrame& frame, bool is_symmetric) {
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
    std::erase_if(candidates, [&](const FieldCandidate& candidate) {
        return candidate.terms.empty() || (is_symmetric && !is_even(frame, candidate));
    });
    return candidates;
}

LegendreValues::LegendreValues(double s, int degree) : value(degree + 1, 1), slope(degree + 1, 0) {
    if (degree >= 1) value[1] = s, slope[1] = 1;
    for (int n = 1; n < degree; ++n) {
        value[n + 1] = ((2 * n + 1) * s * value[n] - n * value[n - 1]) / (n + 1);
        slope[n + 1] = slope[n - 1] + (2 * n + 1) * value[n];
    }
}

}  // namespace strake
