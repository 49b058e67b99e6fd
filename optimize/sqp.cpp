#include "optimize/sqp.hpp"

#include "core/error.hpp"
#include "optimize/first_order.hpp"
#include "optimize/quadratic_model.hpp"

#include <algorithm>
#include <nlopt.hpp>

namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double first_radius = 0.5, largest_radius = 2;      // in the metric: 1 is the largest reasonable step
constexpr double careful_growth = 1.4;                        // once an evaluation has failed
constexpr double acceptable = 1e-4, good = 0.7, poor = 0.25;  // actual over predicted decrease
constexpr double nearly_met = 1e-3;                           // violation at which a finer level may take over
constexpr int restorations = 3;      ///< evaluations spent at the end on meeting the constraints
constexpr int most_rejections = 12;  ///< in a row: the gradient does not say what the values do
constexpr int most_softenings = 4;   ///< looks at the present metric before a step is taken
constexpr double softened = 1.5;     ///< a step so many times as long as thought is made anew
constexpr int stuck_steps = 4;       ///< the same, outside of the constraints
constexpr int calm_steps = 2;        ///< small decreases in a row that mean convergence

class Sqp {
public:
    Sqp(Guard& guard, double least_curvature)
        : guard_(guard), p_(guard.program), x_(guard.best_x), at_(guard.best), least_curvature_(least_curvature) {
        if (p_.metric.size() == 0) p_.metric = MatrixXd::Identity(x_.size(), x_.size());
    }

    SqpEnd run() {
        start_hessian();
        // What is known holds at the start, not where an earlier search from there has ended.
        if (p_.hessian.size() > 0 && guard_.best_x == p_.start) B_ = p_.hessian;
        if (!is_outpaced())
            while (!step()) {
            }
        restore();
        end_.radius = radius_;
        end_.hessian = B_;
        return end_;
    }

private:
    double tolerance() const { return guard_.options.constraint_tolerance; }
    /// A hair inside of the inequalities, so that round-off and curvature do not leave the last point a hair outside.
    VectorXd tightened(VectorXd constraints) const {
        constraints.head(p_.num_inequalities).array() += 0.5 * tolerance();
        return constraints;
    }
    double merit(const Sample& s) const {
        return s.objective + guard_.penalty * total_violation(p_, tightened(s.constraints));
    }

    VectorXd lagrangian_gradient() const { return at_.gradient + at_.jacobian.transpose() * multipliers(p_, at_); }

    /// B = beta metric, so that the first step has the length of the first radius, or less where more is known.
    void start_hessian() {
        const double slope = std::max(dual_norm(p_, lagrangian_gradient()), 1e-3 * dual_norm(p_, at_.gradient));
        B_ = std::max(slope > 0 ? slope / guard_.options.first_step : 1.0, least_curvature_) * p_.metric;
        raise_penalty(2 * multipliers(p_, at_).lpNorm<Eigen::Infinity>());
    }

    /// Somebody knows of something better than what this model still expects.
    bool is_outpaced() {
        if (!guard_.options.on_model || largest_violation(p_, at_.constraints) > nearly_met) return false;
        VectorXd g = lagrangian_gradient();
        const VectorXd d = -B_.llt().solve(g);
        for (Eigen::Index j = 0; j < g.size(); ++j)
            if (leaves_bounds(p_, x_, j, d[j])) g[j] = 0;
        if (guard_.options.on_model(0.5 * g.dot(B_.llt().solve(g)), B_)) return false;
        return end(MinimizeStop::outpaced, "more is expected elsewhere");
    }

    void raise_penalty(double least) { guard_.penalty = std::max(guard_.penalty, least); }

    QuadraticModel model(const VectorXd& constraints, double damping) const {
        QuadraticModel m;
        m.gradient = at_.gradient;
        m.hessian = B_ + damping * p_.metric;
        m.lower = p_.lower - x_;
        m.upper = p_.upper - x_;
        m.constraints = tightened(constraints);
        m.jacobian = at_.jacobian;
        m.num_inequalities = p_.num_inequalities;
        return m;
    }

    /// The model's step, no longer than the radius: the damping that it takes is found by bisection of its logarithm.
    VectorXd model_step(const VectorXd& constraints) {
        VectorXd d = solve_model(model(constraints, 0));
        is_limited_ = d.size() > 0 && metric_norm(p_, d) > 1.01 * radius_;
        if (!is_limited_) return d;
        const double size = B_.trace() / p_.metric.trace();
        double low = std::log(1e-6 * size), high = std::log(1e10 * size);
        for (int i = 0; i < 30; ++i) {
            const double middle = 0.5 * (low + high);
            d = solve_model(model(constraints, std::exp(middle)));
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

    /// The model's step. Where the present metric finds it too long (a direction has become soft), the metric learns of
    /// it by an update that keeps it positive definite (BFGS with the exact product), and the step is made anew.
    VectorXd careful_step() {
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

    /// Evaluates x; false with the guard's cause set when there is no value.
    bool evaluate(const VectorXd& x, bool gradient, Sample& sample) {
        try {
            sample = guard_.at_all(x, gradient);
            return true;
        } catch (const nlopt::forced_stop&) {
            return false;
        }
    }

    /// One step. True: the end.
    bool step() {
        if (needs_restoration() && guard_.evaluations + restorations >= guard_.options.max_evaluations)
            return end(MinimizeStop::evaluations,
                       text("the limit of evaluations is reached (", guard_.options.max_evaluations, ")"));
        const VectorXd d = careful_step();
        if (d.size() == 0) return model_failed();
        const double gain = -(at_.gradient.dot(d) + 0.5 * d.dot(B_ * d));
        const double relief = total_violation(p_, tightened(at_.constraints)) -
                              total_violation(p_, tightened(at_.constraints + at_.jacobian * d));
        if (relief > 0) raise_penalty(-gain / (0.7 * relief));
        const double predicted = gain + guard_.penalty * std::max(relief, 0.0);
        if (is_at_rest(d, predicted)) return true;
        Sample trial;
        if (!evaluate(x_ + d, false, trial)) return failed_at(d);
        double decrease = merit(at_) - merit(trial);
        VectorXd taken = d;
        if (decrease < acceptable * predicted &&
            largest_violation(p_, trial.constraints) > std::max(tolerance(), largest_violation(p_, at_.constraints))) {
            if (!correct(trial, taken)) return failed_at(d);
            decrease = merit(at_) - merit(trial);
        }
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
            stiffen(trial, taken);
            return rejected(length);
        }
        return accept(x_ + taken, trial, decrease);
    }

    /// A second-order correction: the same model with the curvature that the trial met added to the constraints.
    bool correct(Sample& trial, VectorXd& d) {
        const VectorXd corrected = model_step(trial.constraints - at_.jacobian * d);
        if (corrected.size() == 0 || metric_norm(p_, corrected) > 2 * radius_) return true;
        Sample second;
        if (!evaluate(x_ + corrected, false, second)) return false;
        if (merit(second) < merit(trial)) trial = second, d = corrected;
        return true;
    }

    bool accept(const VectorXd& x, Sample& trial, double decrease) {
        if (!evaluate(x, true, trial)) return failed_at(x - x_);
        const VectorXd lambda = multipliers(p_, trial);
        update(x - x_, trial.gradient - at_.gradient + (trial.jacobian - at_.jacobian).transpose() * lambda);
        raise_penalty(1.5 * lambda.lpNorm<Eigen::Infinity>());
        const double objective = std::max(std::abs(trial.objective), guard_.options.objective_scale);
        const bool small = decrease <= guard_.options.objective_tolerance * objective && !is_limited_ &&
                           largest_violation(p_, trial.constraints) <= tolerance();
        // Far from feasible the violations are most of the merit: where it stands still, they cannot be met.
        const bool stuck = largest_violation(p_, trial.constraints) > 10 * tolerance() &&
                           decrease <= 10 * guard_.options.objective_tolerance * std::abs(merit(trial));
        calm_ = small ? calm_ + 1 : 0;
        stuck_ = stuck ? stuck_ + 1 : 0;
        x_ = x;
        at_ = trial;
        failures_ = rejections_ = 0;
        if (calm_ >= calm_steps)
            return end(MinimizeStop::converged, "the objective changes by less than the tolerance");
        if (stuck_ >= stuck_steps)
            return end(MinimizeStop::roundoff, "the violation of the constraints no longer falls");
        return is_outpaced();
    }

    /// Powell's damped BFGS update.
    void update(const VectorXd& s, const VectorXd& y) {
        const VectorXd Bs = B_ * s;
        const double sBs = s.dot(Bs), sy = s.dot(y);
        if (!(sBs > 0)) return;
        const double theta = sy >= 0.2 * sBs ? 1.0 : 0.8 * sBs / (sBs - sy);
        const VectorXd r = theta * y + (1 - theta) * Bs;
        B_ += r * r.transpose() / s.dot(r) - Bs * Bs.transpose() / sBs;
        B_ = 0.5 * (B_ + B_.transpose()).eval();
    }

    /// The model promises nothing more: converged, if nothing but the tolerances keeps it from a longer step.
    bool is_at_rest(const VectorXd& d, double predicted) {
        const bool feasible = largest_violation(p_, at_.constraints) <= tolerance();
        const double size =
            std::max({std::abs(at_.objective), guard_.options.objective_scale, std::numeric_limits<double>::min()});
        if (is_limited_ && radius_ > guard_.options.step_tolerance) return false;
        if (d.lpNorm<Eigen::Infinity>() <= guard_.options.step_tolerance)
            return end(is_limited_ ? MinimizeStop::roundoff
                       : feasible  ? MinimizeStop::converged
                                   : MinimizeStop::roundoff,
                       is_limited_ ? "no step, however short, gains what the gradient promises"
                       : feasible  ? "the variables change by less than the tolerance"
                                   : "the constraints cannot be met within the bounds");
        if (predicted <= 0.1 * guard_.options.objective_tolerance * size && feasible)
            return end(MinimizeStop::converged, "the gradient promises less than the tolerance");
        return false;
    }

    /// What a rejected step tells for nothing: the Lagrangian's curvature along d, where it is more than the model's.
    /// No more than makes the model's own step along d as long as the radius: a wall further out is not curvature here.
    void stiffen(const Sample& trial, const VectorXd& d) {
        const VectorXd lambda = multipliers(p_, at_), Md = p_.metric * d;
        const VectorXd slope = at_.gradient + at_.jacobian.transpose() * lambda;
        const double rise =
            trial.objective - at_.objective + lambda.dot(trial.constraints - at_.constraints) - slope.dot(d);
        const double length2 = d.dot(Md), known = d.dot(B_ * d);
        const double most = std::abs(slope.dot(d)) * std::sqrt(length2) / radius_;
        const double excess = std::min(2 * rise, most) - known;
        const double rounding = 1e-3 * guard_.options.objective_tolerance * std::abs(at_.objective);
        if (excess > rounding && length2 > 0) B_ += excess / (length2 * length2) * Md * Md.transpose();
    }

    bool failed_at(const VectorXd& d) {
        if (guard_.cause != Cause::failure) return ended_by_guard();
        guard_.cause = Cause::none;
        if (++failures_ > guard_.options.max_shrinks || end_.shrinks >= guard_.options.max_failures)
            return end(MinimizeStop::blocked,
                       text("evaluations keep failing next to the best point (", end_.shrinks + 1, " of ",
                            guard_.evaluations, ", ", failures_, " in a row); the last failure: ", guard_.failure));
        ++end_.shrinks;
        radius_ = (failures_ > 1 ? 0.25 : 0.5) * std::min(radius_, metric_norm(p_, d));
        tell(text("evaluation ", guard_.evaluations, " failed (", guard_.failure, "); the largest step is cut to ",
                  radius_));
        return false;
    }

    bool rejected(double length) {
        if (++rejections_ < most_rejections && length > 1e-12) return false;
        return end(MinimizeStop::roundoff, "no step, however short, gains what the gradient promises");
    }

    bool model_failed() {
        if (++model_failures_ > 2) return end(MinimizeStop::roundoff, "the quadratic model can no longer be solved");
        start_hessian();
        return false;
    }

    bool ended_by_guard() {
        switch (guard_.cause) {
            case Cause::evaluations:
                return end(MinimizeStop::evaluations,
                           text("the limit of evaluations is reached (", guard_.evaluations, ")"));
            case Cause::time:
                return end(MinimizeStop::time, "the time limit is reached");
            case Cause::stopped:
                return end(MinimizeStop::stopped, "stopped on request");
            default:
                return end(MinimizeStop::failed, guard_.failure);
        }
    }

    bool needs_restoration() const {
        return p_.num_inequalities + p_.num_equalities > 0 && largest_violation(p_, at_.constraints) > tolerance();
    }

    /// Steps onto the constraints from the last point, where that is better than the best feasible one.
    void restore() {
        if (end_.stop == MinimizeStop::failed || !needs_restoration()) return;
        if (guard_.best_feasible && !(at_.objective < guard_.best.objective)) return;
        if (guard_.cause == Cause::stopped) guard_.cause = Cause::none;
        VectorXd x = x_;
        Sample s = at_;
        for (int i = 0; i < restorations && guard_.cause == Cause::none; ++i) {
            QuadraticModel m = model(s.constraints, 0);
            m.gradient.setZero();
            m.hessian = p_.metric;
            m.lower = p_.lower - x;
            m.upper = p_.upper - x;
            const VectorXd d = solve_model(m);
            if (d.size() == 0 || metric_norm(p_, d) > 0.5) return;
            x += d;
            if (!evaluate(x, false, s) || largest_violation(p_, s.constraints) <= tolerance()) return;
        }
    }

    bool end(MinimizeStop stop, const std::string& reason) {
        end_.stop = stop;
        end_.reason = reason;
        return true;
    }
    void tell(const std::string& event) const {
        if (guard_.options.on_event) guard_.options.on_event(event);
    }

    Guard& guard_;
    NonlinearProgram p_;  ///< its metric may be renewed
    VectorXd x_;
    Sample at_;  ///< at x_, with gradients
    MatrixXd B_;
    double radius_ = guard_.options.first_step;
    double least_curvature_;
    bool is_limited_ = false;
    int calm_ = 0, stuck_ = 0, failures_ = 0, rejections_ = 0, model_failures_ = 0;
    SqpEnd end_{MinimizeStop::failed, "", 0, 0, {}, 0};
};

}  // namespace

SqpEnd minimize_by_sqp(Guard& guard, double least_curvature) { return Sqp(guard, least_curvature).run(); }

}  // namespace strake
