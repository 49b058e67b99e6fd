#include "optimize/nlp/model/slope_check.hpp"

#include "core/error.hpp"
#include "optimize/nlp/program/first_order.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <random>

namespace strake {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double probe = 1e-3;              ///< in the metric
constexpr double rounding = 1e-9;           ///< of a variable
constexpr double max_difference = 0.2;      ///< of the slope
constexpr double max_bend = 0.1;            ///< of the slope: two steps to one side agree
constexpr double max_bend_two_sided = 0.5;  ///< of what is wrong with the slope: a kink bends by all of it
constexpr double noises = 15;               ///< 3 deviations, times what the extrapolation makes of noise
constexpr double deviations = 5;            ///< of the last confirmed steps from the rule
constexpr double repeats[] = {3, 1.0 / 3};  ///< times as far, the first that limits allow
constexpr double max_repeat_error = 0.1;    ///< of what is wrong, in proportion to the length: noise does not repeat
constexpr double cancelling = 0.02;         ///< of the sum of the entries: a slope nearly along the level set
constexpr double nearly_confirmed = 0.1;    ///< of a direction, at most this is left of it
constexpr double min_unconfirmed = 1e-6;    ///< of a random direction: less is rounding
constexpr int reflections = 4;              ///< at limits that the direction would cross

bool at_bound(const NonlinearProgram& p, const VectorXd& x, Eigen::Index j, bool upper) {
    const double range = p.upper[j] - p.lower[j];
    const double slack = 1e-7 * (std::isfinite(range) ? range : 1.0);
    return upper ? x[j] >= p.upper[j] - slack : x[j] <= p.lower[j] + slack;
}

VectorXd gradient_of(const Evaluation& s, Eigen::Index i) {
    return i == 0 ? s.gradient : VectorXd(s.jacobian.row(i - 1).transpose());
}

/// Compares values next to a differentiated point with its gradients.
class SlopeCheck {
public:
    SlopeCheck(Guard& guard, MinimizeResult& result)
        : guard_(guard), p_(guard.program), result_(result), best_feasible_(guard.best_feasible) {
        const bool has_gradient = guard.best.gradient.size() > 0;
        x_ = has_gradient ? guard.best_x : guard.evidence.base();
        at_ = has_gradient ? guard.best : guard.evidence.at_base();
    }

    void run(bool has_converged) {
        if (x_.size() == 0 || at_.gradient.size() == 0) return;
        if (const auto wrong = guard_.evidence.wrong_factor()) {
            found_ = *wrong;
            return accuse("over the last steps");
        }
        if (guard_.evaluations + 2 > guard_.limit) return;
        // Where a search has converged though more is expected along a way that its steps confirm, what they have not
        // taken may hold it back.
        const bool is_held_back = !has_converged && result_.stop == MinimizeStop::converged && is_confirmed(descent());
        if (!has_converged && !is_held_back) return check_descent();
        check_unconfirmed();
    }

    /// By what has been paid for: in all directions, or along the steepest descent.
    bool is_confirmed_by_steps() const {
        if (x_.size() == 0 || at_.gradient.size() == 0 || guard_.evidence.confirmed().empty() ||
            guard_.evidence.is_contradicted())
            return false;
        bool leaves_bounds = false;
        return unconfirmed(leaves_bounds).size() == 0 || is_confirmed(descent());
    }

private:
    double norm(const VectorXd& d) const { return metric_norm(p_, d); }
    VectorXd clamped(const VectorXd& x) const { return x.cwiseMax(p_.lower).cwiseMin(p_.upper); }
    /// Where a limit lets nothing go there, the values say nothing of the gradient.
    bool goes_to(const VectorXd& x) const {
        const VectorXd there = clamped(x);
        return (there - x).lpNorm<Eigen::Infinity>() <= rounding && guard_.inside(there) == there;
    }

    void check_descent() {
        const VectorXd d = descent();
        if (d.size() == 0 || !goes_to(x_ + d)) return;
        const bool two_sided = goes_to(x_ - d);
        if (!two_sided && !goes_to(x_ + 0.5 * d)) return;
        if (compare(d, two_sided, false)) accuse(text("along a step of length ", length_));
    }

    void check_unconfirmed() {
        bool leaves_bounds = false;
        const VectorXd d = unconfirmed(leaves_bounds);
        if (d.size() == 0) return;
        const bool two_sided = !leaves_bounds && goes_to(x_ + d) && goes_to(x_ - d);
        if (!two_sided && !(goes_to(x_ + 0.5 * d) && goes_to(x_ + d))) {
            guard_.report_event("the gradient is not confirmed in all directions: a limit lets nothing go there");
            return;
        }
        const int before = result_.confirmations;
        const bool is_wrong = compare(d, two_sided, true);
        if (has_values_)
            guard_.report_event(text(result_.confirmations - before > 2 ? "four" : "two",
                                     " evaluations in a direction that no step has taken ",
                                     is_wrong ? "contradict" : "confirm", " the gradient"));
        if (is_wrong) accuse(text("in a direction that no step has taken, along a step of length ", length_));
    }

    /// A step along the steepest descent; empty: there is none.
    VectorXd descent() const {
        VectorXd d = descent_direction(p_, x_, at_);
        if (!best_feasible_) {
            d.setZero();
            for (Eigen::Index i = 0; i < at_.constraints.size(); ++i) {
                const bool equality = i >= p_.num_inequalities;
                if ((equality ? std::abs(at_.constraints[i]) : at_.constraints[i]) >
                    guard_.options.constraint_tolerance)
                    d -= (at_.constraints[i] > 0 ? 1.0 : -1.0) * at_.jacobian.row(i).transpose();
            }
            // Into the bounds: variables at one can go nowhere else.
            for (Eigen::Index j = 0; j < d.size(); ++j)
                if (at_bound(p_, x_, j, d[j] > 0)) d[j] = -d[j];
        } else if (!(norm(d) > 0))
            d = -at_.gradient;
        d *= probe / std::max(norm(d), std::numeric_limits<double>::min());
        d = clamped(x_ + d) - x_;
        return d.allFinite() && norm(d) > 0.01 * probe ? d : VectorXd();
    }

    Eigen::LLT<MatrixXd> free_metric() const {
        return Eigen::LLT<MatrixXd>(MatrixXd(metric_of(p_)(guard_.free, guard_.free)));
    }

    /// What is left of a direction, whitened, of length 1, without those that the steps have confirmed.
    VectorXd without_confirmed(const Eigen::LLT<MatrixXd>& metric, VectorXd r) const {
        const auto& steps = guard_.evidence.confirmed();
        if (steps.empty()) return r;
        MatrixXd known(r.size(), static_cast<Eigen::Index>(steps.size()));
        for (std::size_t k = 0; k < steps.size(); ++k) {
            const VectorXd whitened = metric.matrixU() * VectorXd(steps[k](guard_.free));
            known.col(static_cast<Eigen::Index>(k)) = whitened.normalized();
        }
        Eigen::ColPivHouseholderQR<MatrixXd> qr(known);
        qr.setThreshold(1e-3);  // steps that differ by less confirm one direction
        const MatrixXd basis = MatrixXd(qr.householderQ()).leftCols(qr.rank());
        r -= basis * (basis.transpose() * r).eval();
        return r;
    }

    bool is_confirmed(const VectorXd& d) const {
        if (d.size() == 0) return false;
        const Eigen::LLT<MatrixXd> metric = free_metric();
        const VectorXd whitened = metric.matrixU() * VectorXd(d(guard_.free));
        return whitened.norm() > 0 && without_confirmed(metric, whitened.normalized()).norm() < nearly_confirmed;
    }

    /// Random, but for what the steps have confirmed: the same at every run. Empty: all directions are.
    VectorXd unconfirmed(bool& leaves_bounds) const {
        const std::vector<int>& free = guard_.free;
        const auto n = static_cast<Eigen::Index>(free.size());
        const Eigen::LLT<MatrixXd> metric = free_metric();
        std::mt19937 random(guard_.options.seed);
        VectorXd r(n);
        for (Eigen::Index j = 0; j < n; ++j) r[j] = 2 * (static_cast<double>(random()) / std::mt19937::max()) - 1;
        r.normalize();
        r = without_confirmed(metric, r);
        if (!(r.norm() > min_unconfirmed)) return {};
        VectorXd d = VectorXd::Zero(x_.size());
        d(free) = VectorXd(metric.matrixU().solve(r));
        d *= probe / norm(d);
        for (const int j : free)
            for (const bool upper : {false, true})
                if (upper ? x_[j] + std::abs(d[j]) > p_.upper[j] : x_[j] - std::abs(d[j]) < p_.lower[j]) {
                    leaves_bounds = true;
                    d[j] = upper ? -std::abs(d[j]) : std::abs(d[j]);
                }
        keep_within_limits(d);
        d = clamped(x_ + d) - x_;
        return norm(d) > 0.01 * probe ? d : VectorXd();
    }

    void keep_within_limits(VectorXd& d) const {
        const StepLimits& limits = at_.limits;
        for (int round = 0; round < reflections; ++round)
            for (Eigen::Index i = 0; i < limits.values.size(); ++i) {
                const double beyond = limits.values[i] + limits.slopes.row(i).dot(d);
                const double size = limits.slopes.row(i).squaredNorm();
                if (beyond > -std::abs(limits.slopes.row(i).dot(d)) && limits.slopes.row(i).dot(d) > 0 && size > 0)
                    d -= 2 * limits.slopes.row(i).dot(d) / size * limits.slopes.row(i).transpose();
            }
    }

    bool value_at(const VectorXd& x, VectorXd& values) {
        Evaluation s;
        ++result_.confirmations;
        if (guard_.try_at(clamped(x), false, s)) return values = values_of(s), true;
        if (guard_.cause == StopCause::failure) guard_.cause = StopCause::none;
        return false;
    }

    /// Slopes of the values along d, of two evaluations, and how much they bend. False: one failed.
    bool measure(const VectorXd& d, bool two_sided, VectorXd& slope, VectorXd& bend) {
        VectorXd first, second;
        if (!value_at(x_ + (two_sided ? 1 : 0.5) * d, first)) return false;
        if (!value_at(x_ + (two_sided ? -1 : 1) * d, second)) return false;
        has_values_ = true;
        first -= values_of(at_);
        second -= values_of(at_);
        slope = two_sided ? VectorXd(0.5 * (first - second)) : VectorXd(4 * first - second);
        bend = two_sided ? VectorXd(0.5 * (first + second)) : VectorXd(2 * second - 4 * first);
        return true;
    }

    bool compare(const VectorXd& d, bool two_sided, bool has_converged) {
        VectorXd slope, bend;
        if (!measure(d, two_sided, slope, bend)) return false;
        std::vector<SlopeMismatch> hidden;
        for (Eigen::Index i = 0; i < slope.size(); ++i) {
            const double by_gradient = gradient_of(at_, i).dot(d);
            const double size = std::max(std::abs(by_gradient), std::abs(slope[i])), off = slope[i] - by_gradient;
            const double max = two_sided ? max_bend_two_sided * std::abs(off) : 2 * max_bend * size;
            if (!(std::abs(bend[i]) < max)) continue;
            // Across a kink a convex value rises by more than its gradient says.
            if (!two_sided && has_converged && off > 0) continue;
            if (!contradicts(i, d, by_gradient, slope[i])) continue;
            found_ = {static_cast<int>(i) - 1, by_gradient, slope[i]};
            if (std::abs(off) > hiding(i)) return true;
            hidden.push_back(found_);
        }
        // A gradient that is partly of differences may be off by more than steps show.
        const bool may_repeat = !hidden.empty() && !guard_.options.trusts_long_steps && !p_.differences;
        return may_repeat && is_repeated(hidden, d, two_sided);
    }

    /// The slope is not the gradient's, by more than the resolution of the value leaves open.
    bool contradicts(Eigen::Index i, const VectorXd& d, double by_gradient, double slope) const {
        const double size = std::max(std::abs(by_gradient), std::abs(slope)), off = std::abs(slope - by_gradient);
        if (!(off > max_difference * size)) return false;
        if (size < cancelling * gradient_of(at_, i).cwiseProduct(d).cwiseAbs().sum()) return false;
        return off > noises * resolution(values_of(at_)[i], i == 0 ? guard_.evidence.noise() : 0);
    }

    /// Of what is wrong with a slope, as much as may be noise: that is not known better than by how far the last
    /// confirmed steps are from the rule, or these were long.
    double hiding(Eigen::Index i) const {
        const VectorXd known = guard_.evidence.deviations();
        return known.size() > i ? deviations * known[i] : 0;
    }

    /// What is wrong with a slope is so again, in proportion, along a longer or shorter step. Noise is not.
    bool is_repeated(const std::vector<SlopeMismatch>& hidden, const VectorXd& d, bool two_sided) {
        const auto times = std::find_if(std::begin(repeats), std::end(repeats), [&](double t) {
            return goes_to(x_ + t * d) && goes_to(x_ + t * (two_sided ? -1 : 0.5) * d);
        });
        VectorXd slope, bend;
        if (times == std::end(repeats) || guard_.evaluations + 2 > guard_.limit) return false;
        if (!measure(*times * d, two_sided, slope, bend)) return false;
        length_ = *times * probe;
        return std::any_of(hidden.begin(), hidden.end(), [&](const SlopeMismatch& one) {
            const double off = *times * (one.found - one.expected), expected = *times * one.expected;
            found_ = {one.row, expected, slope[one.row + 1]};
            return std::abs(found_.found - expected - off) < max_repeat_error * std::abs(off) &&
                   std::abs(bend[one.row + 1]) < max_bend_two_sided * std::abs(off);
        });
    }

    void accuse(const std::string& where) {
        result_.gradient_inconsistent = true;
        result_.slope_ratio = found_.ratio();
        result_.slope_of = found_.row;
        result_.slope_expected = found_.expected;
        result_.slope_found = found_.found;
        result_.slope_where = where;
        const std::string of = found_.row < 0 ? std::string("the objective") : text("constraint ", found_.row),
                          much = std::isfinite(found_.ratio())
                                     ? text(std::round(1000 * found_.ratio()) / 1000, " of what its gradient says")
                                     : text(found_.found, " where its gradient says ", found_.expected);
        result_.reason +=
            text("; the gradient is inconsistent with the values: ", where, ", ", of, " changes by ", much);
    }

    Guard& guard_;
    const NonlinearProgram& p_;
    MinimizeResult& result_;
    bool best_feasible_, has_values_ = false;
    double length_ = probe;  ///< of the step that `found_` is about
    VectorXd x_;
    Evaluation at_;
    SlopeMismatch found_;
};

}  // namespace

bool expects_more(const Guard& guard) {
    if (guard.best.gradient.size() == 0) return false;
    const NonlinearProgram& p = guard.program;
    VectorXd d = -lagrangian_gradient(p, guard.best_x, guard.best);
    for (Eigen::Index j = 0; j < d.size(); ++j)
        if (p.lower[j] == p.upper[j] || at_bound(p, guard.best_x, j, d[j] > 0)) d[j] = 0;
    const double length = metric_norm(p, d);
    return length > 0 && d.squaredNorm() / length * probe > 10 * guard.decrease_tolerance(guard.best.objective);
}

void check_slopes(Guard& guard, MinimizeResult& result) {
    if (guard.cause != StopCause::none || !guard.has_best) return;
    const bool has_converged = result.stop == MinimizeStop::converged && !expects_more(guard);
    SlopeCheck check(guard, result);
    check.run(has_converged);
    result.gradient_confirmed = !result.gradient_inconsistent && check.is_confirmed_by_steps();
}

}  // namespace strake
