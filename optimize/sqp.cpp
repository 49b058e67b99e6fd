#include "optimize/sqp_search.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <nlopt.hpp>

namespace strake {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double largest_radius = 2;                           // in the metric: 1 is the largest reasonable step
constexpr double careful_growth = 1.4;                         // once an evaluation has failed
constexpr double acceptable = 1e-4, good = 0.7, poor = 0.25;   // actual over predicted decrease
constexpr double nearly_met = 1e-3;                            // violation at which a finer level may take over
constexpr int most_softenings = 4;                             ///< looks at the present metric before a step is taken
constexpr double softened = 1.5;                               ///< a step so many times as long as thought is made anew
constexpr double worth_stretching = 1.5, most_stretching = 8;  ///< of a step's length
constexpr int most_stretches = 3;
constexpr double largest_correction = 0.5;  ///< share of the step: what bends more is no matter of second order
constexpr int most_corrections = 2;         ///< of a step that misses the constraints, before the next gradient is paid
constexpr int stuck_steps = 4;              ///< the same, outside of the constraints
constexpr int calm_steps = 2;               ///< small decreases in a row that mean convergence

}  // namespace

SqpEnd SqpSearch::run() {
    if (p_.start_gradient && is_dear())
        doubt_ = GradientDoubt(p_.metric, guard_.best_x == p_.start ? p_.start_gradient->doubt : MatrixXd());
    start_hessian();
    look_at_border();
    // What is known holds at the start, not where an earlier search from there has ended.
    if (p_.hessian.size() > 0 && guard_.best_x == p_.start) B_ = p_.hessian;
    if (!is_outpaced())
        while (!step()) {
        }
    restore();
    end_.radius = radius_;
    end_.accepted = accepted_;
    if (guard_.best_x == x_ && !doubt_.is_certain())
        end_.doubt = doubt_.remaining();
    else
        guard_.forget_guessed();
    // Where steps are rejected however short, what they taught of the curvature is noise.
    end_.hessian = end_.stop == MinimizeStop::roundoff && accepted_ > 0 ? of_steps_ : B_;
    return end_;
}

VectorXd SqpSearch::tightened(VectorXd constraints) const {
    constraints.head(p_.num_inequalities).array() += 0.5 * tolerance();
    return constraints;
}

void SqpSearch::start_hessian() {
    const double slope = std::max(dual_norm(p_, lagrangian_gradient()), 1e-3 * dual_norm(p_, at_.gradient));
    B_ = std::max(slope > 0 ? slope / guard_.options.first_step : 1.0, least_curvature_) * p_.metric;
    raise_penalty(2 * multipliers(p_, x_, at_).lpNorm<Eigen::Infinity>());
}

bool SqpSearch::is_outpaced() {
    if (!guard_.options.on_model || largest_violation(p_, at_.constraints) > nearly_met) return false;
    VectorXd g = lagrangian_gradient();
    const VectorXd d = -B_.llt().solve(g);
    for (Eigen::Index j = 0; j < g.size(); ++j)
        if (leaves_bounds(p_, x_, j, d[j])) g[j] = 0;
    if (guard_.options.on_model(0.5 * g.dot(B_.llt().solve(g)), B_)) return false;
    return end(MinimizeStop::outpaced, "more is expected elsewhere");
}

QuadraticModel SqpSearch::model(const VectorXd& constraints, double damping,
                                const std::optional<FailureCut>& cut) const {
    QuadraticModel m;
    m.gradient = at_.gradient;
    m.hessian = B_ + damping * p_.metric;
    m.lower = p_.lower - x_;
    m.upper = p_.upper - x_;
    m.constraints = tightened(constraints);
    m.jacobian = at_.jacobian;
    m.num_inequalities = p_.num_inequalities;
    if (cut) m.add_inequality(cut->normal, cut->normal.dot(x_) - cut->limit);
    return m;
}

VectorXd SqpSearch::model_step(const VectorXd& constraints) {
    damping_ = 0;
    VectorXd d = solve_model(model(constraints, 0));
    is_limited_ = d.size() > 0 && metric_norm(p_, d) > 1.01 * radius_;
    if (!is_limited_) return d;
    const double size = B_.trace() / p_.metric.trace();
    double low = std::log(1e-6 * size), high = std::log(1e10 * size);
    for (int i = 0; i < 30; ++i) {
        const double middle = 0.5 * (low + high);
        damping_ = std::exp(middle);
        d = solve_model(model(constraints, damping_));
        if (d.size() == 0) return d;
        const double length = metric_norm(p_, d);
        if (length > radius_)
            low = middle;
        else if (length < 0.9 * radius_)
            high = middle;
        else
            break;
    }
    return d;
}

ActiveSet SqpSearch::held(const QuadraticModel& of, const VectorXd& d) const {
    ActiveSet set = active_set(of, d);
    const Eigen::Index cut = of.constraints.size() > at_.constraints.size() ? p_.num_inequalities : -1;
    std::erase(set.rows, cut);
    for (Eigen::Index& row : set.rows)
        if (cut >= 0 && row > cut) --row;
    return set;
}

VectorXd SqpSearch::multipliers_at(const Sample& sample, const ActiveSet& set) const {
    return least_squares_multipliers(p_.metric, sample.gradient, sample.jacobian, p_.num_inequalities, set);
}

VectorXd SqpSearch::careful_step() {
    VectorXd d = model_step(at_.constraints);
    // Once per point: to come back to it after a failure costs an equilibrium.
    const int rounds = p_.present_metric && failures_ + rejections_ == 0 ? most_softenings : 0;
    for (int round = 0; round < rounds && d.size() > 0; ++round) {
        const VectorXd present = p_.present_metric(x_, d);
        if (present.size() != d.size() || !present.allFinite()) break;
        const VectorXd known = p_.metric * d;
        const double length2 = d.dot(present), known2 = d.dot(known);
        if (!(length2 > softened * softened * std::max(known2, 0.1 * radius_ * radius_)) || !(known2 > 0)) break;
        p_.metric += present * present.transpose() / length2 - known * known.transpose() / known2;
        p_.metric = 0.5 * (p_.metric + p_.metric.transpose()).eval();
        ++end_.softenings;
        d = model_step(at_.constraints);
    }
    return d;
}

bool SqpSearch::evaluate(const VectorXd& x, bool gradient, Sample& sample) {
    try {
        sample = guard_.at_all(x, gradient);
        return true;
    } catch (const nlopt::forced_stop&) {
        return false;
    }
}

bool SqpSearch::step() {
    if (needs_restoration() && guard_.evaluations + restorations >= guard_.options.max_evaluations)
        return end(MinimizeStop::evaluations,
                   text("the limit of evaluations is reached (", guard_.options.max_evaluations, ")"));
    const VectorXd d = careful_step();
    if (d.size() == 0) return model_failed();
    const ActiveSet set = held(model(at_.constraints, damping_), d);
    const double gain = -(at_.gradient.dot(d) + 0.5 * d.dot(B_ * d));
    const double relief = total_violation(p_, tightened(at_.constraints)) -
                          total_violation(p_, tightened(at_.constraints + at_.jacobian * d));
    if (relief > 0) raise_penalty(-gain / (0.7 * relief));
    const double predicted = gain + guard_.penalty * std::max(relief, 0.0);
    if (is_at_rest(d, predicted)) return ends_here() && (!is_cut_off(d) || end_at_border());
    Sample trial;
    if (!evaluate(x_ + d, false, trial)) return failed_at(d);
    double decrease = merit(at_) - merit(trial);
    VectorXd taken = d;
    if (decrease < acceptable * predicted &&
        largest_violation(p_, trial.constraints) > std::max(tolerance(), largest_violation(p_, at_.constraints))) {
        if (!correct(trial, taken)) return failed_at(d);
        decrease = merit(at_) - merit(trial);
    }
    measure_curvature(trial, taken);
    const double ratio = decrease / predicted;
    const double length = metric_norm(p_, taken);
    if (ratio < poor)  // where the parabola through the values has its least, within a tenth and a half
        radius_ = std::clamp(0.5 / (1 - std::min(ratio, 0.0)), 0.1, 0.5) * std::min(radius_, length);
    else if (ratio > good && is_limited_)
        radius_ = std::min((end_.shrinks > 0            ? careful_growth
                            : std::abs(ratio - 1) < 0.1 ? 4
                                                        : 2) *
                               radius_,
                           largest_radius);
    if (ratio < acceptable || !(decrease > 0)) {
        stiffen(trial, taken, multipliers_at(at_, set));
        return rejected(length);
    }
    if (!meet_constraints(trial, taken)) return failed_at(taken);
    stretch(trial, taken, at_.gradient.dot(d) - guard_.penalty * std::max(relief, 0.0));
    return accept(x_ + taken, trial, merit(at_) - merit(trial), set);
}

void SqpSearch::stretch(Sample& trial, VectorXd& d, double slope) {
    const double before = d.norm();
    for (int k = 0; is_dear() && k < most_stretches; ++k) {
        const double curvature = 2 * (merit(trial) - merit(at_) - slope);
        const double times = curvature > 0 ? std::min(-slope / curvature, most_stretching) : most_stretching;
        if (!(times > worth_stretching)) break;
        const VectorXd longer = (x_ + times * d).cwiseMax(p_.lower).cwiseMin(p_.upper) - x_;
        Sample further;
        if (metric_norm(p_, longer) > largest_radius) break;
        if (!evaluate(x_ + longer, false, further)) {
            if (guard_.cause == Cause::failure) guard_.cause = Cause::none;  // it was a try
            break;
        }
        if (!(merit(further) < merit(trial))) break;
        trial = further;
        d = longer;
        slope *= times;
    }
    const double all = d.norm() / before;
    if (!(all > 1)) return;
    radius_ = std::clamp(metric_norm(p_, d), radius_, largest_radius);
    if (accepted_ == 0 && p_.guessed.size() > 0) B_ -= (1 - 1 / all) * p_.guessed;
}

bool SqpSearch::meet_constraints(Sample& trial, VectorXd& d) {
    for (int k = 0; k < most_corrections && is_dear(); ++k) {
        if (largest_violation(p_, trial.constraints) <= tolerance()) break;
        const double before = merit(trial);
        if (!correct(trial, d)) {
            if (guard_.cause != Cause::failure) return false;
            guard_.cause = Cause::none;  // it was a try
            break;
        }
        if (!(merit(trial) < before)) break;
    }
    return true;
}

bool SqpSearch::correct(Sample& trial, VectorXd& d) {
    const VectorXd corrected = model_step(trial.constraints - at_.jacobian * d);
    if (corrected.size() == 0 || metric_norm(p_, corrected - d) > largest_correction * metric_norm(p_, d)) return true;
    Sample second;
    if (!evaluate(x_ + corrected, false, second)) return false;
    if (merit(second) < merit(trial)) trial = second, d = corrected;
    return true;
}

bool SqpSearch::accept(const VectorXd& x, Sample& trial, double decrease, const ActiveSet& set) {
    if (!differentiate(x, trial)) return failed_at(x - x_);
    const VectorXd lambda = multipliers_at(trial, set);
    bend(lambda);
    update(x - x_, trial.gradient - at_.gradient + (trial.jacobian - at_.jacobian).transpose() * lambda);
    of_steps_ = B_;
    adapt_penalty(1.5 * lambda.lpNorm<Eigen::Infinity>(), largest_violation(p_, trial.constraints) <= tolerance());
    const double objective = std::max(std::abs(trial.objective), guard_.options.objective_scale);
    const bool small = decrease <= guard_.options.objective_tolerance * objective && !is_limited_ &&
                       largest_violation(p_, trial.constraints) <= tolerance();
    // Far from feasible the violations are most of the merit: where it stands still, they cannot be met.
    const bool stuck = largest_violation(p_, trial.constraints) > 10 * tolerance() &&
                       decrease <= 10 * guard_.options.objective_tolerance * std::abs(merit(trial));
    calm_ = small && !cut_ ? calm_ + 1 : 0;
    stuck_ = stuck ? stuck_ + 1 : 0;
    x_ = x;
    at_ = trial;
    failures_ = rejections_ = 0;
    ++accepted_;
    look_at_border();
    if ((calm_ >= calm_steps || stuck_ >= stuck_steps) && pay_doubt()) calm_ = stuck_ = 0;
    if (calm_ >= calm_steps) return end(MinimizeStop::converged, "the objective changes by less than the tolerance");
    if (stuck_ >= stuck_steps) return end(MinimizeStop::roundoff, "the violation of the constraints no longer falls");
    return is_outpaced();
}

void SqpSearch::update(const VectorXd& s, const VectorXd& y) {
    const VectorXd Bs = B_ * s;
    const double sBs = s.dot(Bs), sy = s.dot(y);
    if (!(sBs > 0)) return;
    const double theta = sy >= 0.2 * sBs ? 1.0 : 0.8 * sBs / (sBs - sy);
    const VectorXd r = theta * y + (1 - theta) * Bs;
    B_ += r * r.transpose() / s.dot(r) - Bs * Bs.transpose() / sBs;
    B_ = 0.5 * (B_ + B_.transpose()).eval();
}

void SqpSearch::measure_curvature(const Sample& trial, const VectorXd& d) {
    const double length2 = d.dot(p_.metric * d);
    const VectorXd bends = trial.constraints - at_.constraints - at_.jacobian * d;
    for (Eigen::Index i = 0; i < bends.size(); ++i) {
        if (std::abs(bends[i]) > 0.01 * tolerance() && length2 > 0)  // less may be rounding
            curvature_[i] = std::min(curvature_[i], std::max(2 * bends[i] / length2, 0.0));
    }
}

void SqpSearch::bend(const VectorXd& lambda) {
    for (Eigen::Index i = 0; i < lambda.size(); ++i) {
        const double needed = std::isfinite(curvature_[i]) ? lambda[i] * curvature_[i] : 0;
        if (!(needed > included_[i])) continue;
        B_ += (needed - included_[i]) * p_.metric;
        included_[i] = needed;
    }
}

void SqpSearch::stiffen(const Sample& trial, const VectorXd& d, const VectorXd& lambda) {
    const VectorXd Md = p_.metric * d;
    const VectorXd slope = at_.gradient + at_.jacobian.transpose() * lambda;
    const double rise =
        trial.objective - at_.objective + lambda.dot(trial.constraints - at_.constraints) - slope.dot(d);
    const double length2 = d.dot(Md), known = d.dot(B_ * d);
    const double most = std::abs(slope.dot(d)) * std::sqrt(length2) / radius_;
    const double excess = std::min(2 * rise, most) - known;
    const double rounding = 1e-3 * guard_.options.objective_tolerance * std::abs(at_.objective);
    if (excess > rounding && length2 > 0) B_ += excess / (length2 * length2) * Md * Md.transpose();
}

bool SqpSearch::end(MinimizeStop stop, const std::string& reason) {
    end_.stop = stop;
    end_.reason = reason;
    return true;
}

SqpEnd minimize_by_sqp(Guard& guard, double least_curvature) { return SqpSearch(guard, least_curvature).run(); }

}  // namespace strake
