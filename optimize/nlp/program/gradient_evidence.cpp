#include "optimize/nlp/program/gradient_evidence.hpp"

#include "optimize/nlp/program/first_order.hpp"

#include <algorithm>
#include <cmath>

namespace strake {

using Eigen::VectorXd;

namespace {

constexpr double agreement = 0.1;      ///< of the change of a value: the third order of a fair step
constexpr double cancelling = 0.01;    ///< of the sum of the entries' sizes: a slope that is their small difference
constexpr double contradiction = 0.5;  ///< of the change: no fair step bends that much
constexpr double wrong_share = 0.3;    ///< off 1, of a factor that is wrong
constexpr double same_factor = 0.1;    ///< spread of factors, as a share of their mean
constexpr std::size_t steps_for_factor = 3, kept_steps = 4, kept_deviations = 2;
constexpr std::size_t attempts_in_row = 4;
constexpr double attempts_shrink = 0.125;  ///< last length over the first: nonlinear values follow the gradient by then
constexpr double one_line = 1 - 1e-9;  ///< cosine of directions that count as the same: the slope across is no noise

/// Sum of |g_j d_j|, which a slope may be a small difference of.
double sum_of_sizes(const VectorXd& g, const VectorXd& d) { return g.cwiseProduct(d).cwiseAbs().sum(); }

VectorXd gradient_of(const Evaluation& s, Eigen::Index i) {
    return i == 0 ? s.gradient : VectorXd(s.jacobian.row(i - 1).transpose());
}

}  // namespace

void GradientEvidence::add_values(const VectorXd& x, const Evaluation& evaluation) {
    if (x_.size() == 0 || x == x_) return;
    add_attempt(x - x_, evaluation.objective - at_.objective);
}

void GradientEvidence::add_attempt(const VectorXd& d, double found) {
    const double length = d.norm(), expected = at_.gradient.dot(d);
    if (direction_.size() == 0 || direction_.dot(d) < one_line * length) noise_.begin(at_.objective);
    direction_ = d / length;
    noise_.add(length, at_.objective + found);
    const double size = std::max(std::abs(expected), std::abs(found));
    const bool is_measurable = size > 10 * resolution(at_.objective, noise());
    const bool follows = std::abs(found - expected) <= contradiction * size;
    if (is_measurable && !follows && (lengths_.empty() || length < lengths_.back()))
        lengths_.push_back(length);
    else if (is_measurable)
        lengths_.clear();
}

void GradientEvidence::add_gradients(const VectorXd& x, const Evaluation& evaluation) {
    if (x_.size() > 0 && x != x_) add_step(x, evaluation);
    if (x_.size() == 0 || x != x_) {
        lengths_.clear();
        direction_.resize(0);
    }
    x_ = x;
    at_ = evaluation;
}

void GradientEvidence::add_step(const VectorXd& x, const Evaluation& evaluation) {
    const VectorXd d = x - x_, before = values_of(at_), after = values_of(evaluation);
    const Eigen::Index rows = before.size();
    if (after.size() != rows) return;
    Step step;
    step.expected = step.found = VectorXd::Constant(rows, std::numeric_limits<double>::quiet_NaN());
    VectorXd deviation = VectorXd::Zero(rows);
    bool all_agree = true;
    for (Eigen::Index i = 0; i < rows; ++i) {
        const VectorXd g0 = gradient_of(at_, i), g1 = gradient_of(evaluation, i);
        const double here = g0.dot(d), there = g1.dot(d);
        const double expected = 0.5 * (here + there), found = after[i] - before[i];
        const double size = std::max({std::abs(here), std::abs(there), std::abs(found)});
        const double unsure = resolution(before[i], i == 0 ? noise() : 0);
        deviation[i] = std::abs(found - expected);
        if (!(size > 10 * unsure)) continue;
        const double sum = 0.5 * (sum_of_sizes(g0, d) + sum_of_sizes(g1, d));
        step.expected[i] = expected;
        step.found[i] = found;
        all_agree &= deviation[i] <= agreement * size + cancelling * sum + 3 * unsure;
        step.is_contradicted |= deviation[i] > contradiction * size && size > cancelling * sum;
    }
    step.is_confirmed = all_agree && std::isfinite(step.expected[0]);
    if (step.is_confirmed) {
        confirmed_.push_back(d);
        deviations_.push_back(deviation);
        if (deviations_.size() > kept_deviations) deviations_.erase(deviations_.begin());
    }
    steps_.push_back(step);
    if (steps_.size() > kept_steps) steps_.erase(steps_.begin());
}

bool GradientEvidence::is_contradicted() const {
    if (lengths_.size() >= attempts_in_row && lengths_.back() <= attempts_shrink * lengths_.front()) return true;
    int contradicted = 0;
    for (const Step& step : steps_) {
        if (step.is_confirmed) return false;
        contradicted += step.is_contradicted;
    }
    return contradicted >= 2;
}

std::optional<SlopeMismatch> GradientEvidence::wrong_factor() const {
    if (steps_.size() < steps_for_factor) return {};
    for (Eigen::Index i = 0; i < steps_.back().expected.size(); ++i) {
        double least = std::numeric_limits<double>::infinity(), largest = -least;
        bool is_known = true;
        for (const Step& step : steps_) {
            const double factor =
                step.expected.size() > i ? step.found[i] / step.expected[i] : std::numeric_limits<double>::quiet_NaN();
            is_known &= std::isfinite(factor);
            least = std::min(least, factor);
            largest = std::max(largest, factor);
        }
        const double mean = 0.5 * (least + largest);
        if (is_known && std::abs(mean - 1) > wrong_share && largest - least <= same_factor * std::abs(mean))
            return SlopeMismatch{static_cast<int>(i) - 1, steps_.back().expected[i], steps_.back().found[i]};
    }
    return {};
}

VectorXd GradientEvidence::deviations() const {
    if (deviations_.empty()) return {};
    VectorXd largest = deviations_[0];
    for (const VectorXd& d : deviations_) largest = largest.cwiseMax(d);
    return largest;
}

}  // namespace strake
