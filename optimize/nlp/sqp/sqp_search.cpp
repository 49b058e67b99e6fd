#include "optimize/nlp/sqp/sqp_search.hpp"

#include "core/error.hpp"
#include "optimize/nlp/sqp/parabola_misfit.hpp"
#include "optimize/nlp/sqp/trust_region.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

namespace strake {

using Eigen::VectorXd;

SqpSearch::SqpSearch(Guard& guard, double min_curvature)
    : guard_(guard),
      now_(guard),
      merit_(now_),
      hessian_(now_, min_curvature),
      steps_(now_, hessian_, merit_),
      border_(now_, hessian_, merit_, steps_),
      gradient_(now_, hessian_) {}

SqpEnd SqpSearch::run() {
    start_hessian();
    border_.update();
    // What is known holds at the start, not where an earlier search from there has ended.
    const NonlinearProgram& p = now_.program;
    if (p.hessian.size() > 0 && guard_.best_x == p.start) hessian_.start_from(p.hessian);
    guard_.largest_gradient = std::max(guard_.largest_gradient, projected_gradient());
    if (!is_outpaced())
        while (!step()) {
        }
    if (without_shape_ > 0)
        guard_.report_event(text(without_shape_, " steps led to no valid shape and were not evaluated"));
    restore();
    if (end_.stop == MinimizeStop::evaluations) end_.reason = guard_.limit_words();  // restoring has taken some
    end_.last_x = now_.x;
    end_.last = now_.at;
    // What was cut where trying costs nothing is no reason for shorter steps on the next level.
    end_.radius = (without_shape_ > 0 && guard_.failures == 0 ? 2 : 1) * steps_.radius;
    end_.accepted = accepted_;
    if (guard_.best_x == now_.x && !gradient_.is_exact())
        end_.gradient_error = gradient_.remaining_error();
    else
        guard_.forget_guessed();
    // Where steps are rejected however short, what they added of curvature is noise.
    end_.hessian = end_.stop == MinimizeStop::roundoff && accepted_ > 0 ? hessian_.accepted() : hessian_.matrix();
    return end_;
}

void SqpSearch::start_hessian() {
    hessian_.start();
    merit_.raise_penalty(trust_region.first_penalty_factor *
                         multipliers(now_.program, now_.x, now_.at).lpNorm<Eigen::Infinity>());
}

void SqpSearch::place(Trial& trial) {
    const VectorXd there = now_.clamped(now_.x + trial.d);
    trial.x = guard_.inside(there);
    trial.is_moved = trial.x != there;
    if (trial.is_moved) trial.d = trial.x - now_.x;
}

bool SqpSearch::try_step(Trial& trial) {
    place(trial);
    return try_placed(trial);
}

bool SqpSearch::try_placed(Trial& trial) {
    // With no evaluation left the search has ended, whatever shape is there.
    const bool pays =
        guard_.options.steps_pay_without_shape || guard_.evaluations >= guard_.limit || !guard_.is_refused(trial.x);
    was_paid_ |= pays;
    if (pays) return guard_.try_at(trial.x, false, trial.evaluation);
    ++without_shape_;
    guard_.cause = StopCause::failure;
    return false;
}

VectorXd SqpSearch::within_limits(VectorXd d) {
    for (int round = 0; round < trust_region.max_limit_rounds && d.size() > 0; ++round) {
        if (!now_.program.beyond || d.lpNorm<Eigen::Infinity>() <= guard_.options.step_tolerance) break;
        const StepLimits limits = guard_.beyond(now_.x, now_.clamped(now_.x + d));
        if (limits.values.size() == 0) break;
        steps_.add_limits(limits);
        d = steps_.step(now_.at.constraints);
    }
    return d;
}

bool SqpSearch::step() {
    was_paid_ = false;
    if (needs_restoration() && guard_.evaluations + trust_region.max_restorations >= guard_.options.max_evaluations)
        return end(MinimizeStop::evaluations, guard_.limit_words());
    // The present metric once per point: to come back to the point after a failure costs an equilibrium.
    const VectorXd d = within_limits(failures_ + refusals_ + rejections_ == 0 ? steps_.step_in_present_metric()
                                                                              : steps_.step(now_.at.constraints));
    if (d.size() == 0) return model_failed();
    const ActiveSet set = steps_.active(steps_.last_model(), d);
    const double gain = model_decrease(now_, hessian_.matrix(), d);
    const double relief = merit_.violation_decrease(d);
    if (relief > 0) merit_.raise_penalty(-gain / (trust_region.penalty_share * relief));
    double predicted = merit_.expected_decrease(gain, relief);
    // No step at all would be better: rounding, not the end.
    if (!guard_.options.descends_as_before && predicted < -guard_.decrease_tolerance(now_.at.objective))
        return model_failed();
    if (is_stationary(d, predicted)) return ends_here() && (!steps_.is_cut_off(d) || end_at_border());
    Trial trial{{}, d};
    place(trial);
    if (trial.is_moved && guard_.cause == StopCause::none && trial.d.isZero(0)) return cut_back(d);
    if (!try_placed(trial)) return failed_at(d);
    if (trial.is_moved)  // shorter than expected
        predicted = std::max(merit_.expected_decrease(hessian_.matrix(), trial.d), std::numeric_limits<double>::min());
    const auto decrease = [&] { return merit_.at_present() - merit_.of(trial.evaluation); };
    if (decrease() < trust_region.acceptable * predicted &&
        largest_violation(now_.program, trial.evaluation.constraints) >
            std::max(now_.tolerance(), largest_violation(now_.program, now_.at.constraints)) &&
        !correct(trial))
        return failed_at(d);
    hessian_.measure_constraints(trial.evaluation, trial.d);
    const double ratio = decrease() / predicted;
    const double length = steps_.length(trial.d);
    resize(ratio, length);
    if (ratio < trust_region.acceptable || !(decrease() > 0)) {
        hessian_.add_rejected_curvature(trial.evaluation, trial.d, multipliers_of(now_, now_.at, set), steps_.radius);
        return rejected(length);
    }
    if (!meet_constraints(trial)) return failed_at(trial.d);
    extrapolate(trial, now_.at.gradient.dot(d) - guard_.penalty * std::max(relief, 0.0));
    return accept(trial.x, trial.evaluation, decrease(), set);
}

void SqpSearch::resize(double ratio, double length) {
    constexpr const TrustRegionOptions& t = trust_region;
    double& radius = steps_.radius;
    if (ratio < t.poor)  // towards the minimum of the parabola through the values
        radius = std::clamp(0.5 / (1 - std::min(ratio, 0.0)), t.min_cut, t.max_cut) * std::min(radius, length);
    else if (ratio > t.good && steps_.is_limited()) {
        const double growth = end_.shrinks > 0                      ? t.growth_after_failure
                              : std::abs(ratio - 1) < t.exact_share ? t.exact_growth
                                                                    : t.growth;
        radius = std::min(growth * radius, guard_.options.max_step);
    }
}

void SqpSearch::extrapolate(Trial& trial, double slope) {
    const double before = trial.d.norm();
    for (int k = 0; now_.has_expensive_gradient() && k < trust_region.max_extrapolations; ++k) {
        const double curvature = 2 * (merit_.of(trial.evaluation) - merit_.at_present() - slope);
        constexpr double farthest = trust_region.max_extrapolation;
        const double times = curvature > 0 ? std::min(-slope / curvature, farthest) : farthest;
        if (!(times > trust_region.min_extrapolation)) break;
        const VectorXd longer = now_.clamped(now_.x + times * trial.d) - now_.x;
        Trial further{{}, longer};
        if (steps_.length(longer) > guard_.options.max_step) break;
        if (!try_step(further)) {
            if (guard_.cause == StopCause::failure) guard_.cause = StopCause::none;  // the shorter step stands
            break;
        }
        if (!(merit_.of(further.evaluation) < merit_.of(trial.evaluation))) break;
        trial = further;
        slope *= times;
    }
    const double all = trial.d.norm() / before;
    if (!(all > 1)) return;
    steps_.radius = std::clamp(steps_.length(trial.d), steps_.radius, guard_.options.max_step);
    if (accepted_ == 0) hessian_.remove_guess(1 - 1 / all);
}

bool SqpSearch::meet_constraints(Trial& trial) {
    for (int k = 0; k < trust_region.max_corrections && now_.has_expensive_gradient(); ++k) {
        if (now_.is_met(trial.evaluation)) break;
        const double before = merit_.of(trial.evaluation);
        if (!correct(trial)) {
            if (guard_.cause != StopCause::failure) return false;
            guard_.cause = StopCause::none;  // the step as it was stands
            break;
        }
        if (!(merit_.of(trial.evaluation) < before)) break;
    }
    return true;
}

bool SqpSearch::correct(Trial& trial) {
    const VectorXd& d = trial.d;
    const VectorXd corrected = steps_.step(trial.evaluation.constraints - now_.at.jacobian * d);
    if (corrected.size() == 0 || steps_.length(corrected - d) > trust_region.max_correction * steps_.length(d))
        return true;
    Trial second{{}, corrected};
    if (!try_step(second)) return false;
    if (merit_.of(second.evaluation) < merit_.of(trial.evaluation)) trial = second;
    return true;
}

bool SqpSearch::accept(const VectorXd& x, Evaluation& trial, double decrease, const ActiveSet& set) {
    const bool is_left = guard_.options.before_differences && now_.has_expensive_gradient() && now_.is_met(trial) &&
                         !guard_.options.before_differences();
    if (!(is_left ? gradient_.estimate(x, trial) : gradient_.differentiate(x, trial))) return failed_at(x - now_.x);
    const VectorXd lambda = multipliers_of(now_, trial, set);
    const bool is_wavy = tells_of_waves(trial, x - now_.x, lambda);
    hessian_.add_constraint_curvature(lambda);
    hessian_.update(x - now_.x,
                    trial.gradient - now_.at.gradient + (trial.jacobian - now_.at.jacobian).transpose() * lambda);
    hessian_.mark_accepted();
    merit_.adapt_penalty(trust_region.penalty_factor * lambda.lpNorm<Eigen::Infinity>(), now_.is_met(trial));
    const bool is_small =
        decrease <= guard_.decrease_tolerance(trial.objective) && !steps_.is_limited() && now_.is_met(trial);
    // Far from feasible the violations are most of the merit: where it stands still, they cannot be met.
    const bool is_stalled =
        largest_violation(now_.program, trial.constraints) > trust_region.stalled_violation * now_.tolerance() &&
        decrease <= trust_region.stalled_decrease * guard_.options.objective_tolerance * std::abs(merit_.of(trial));
    small_decreases_ = is_small && !border_.is_known() ? small_decreases_ + 1 : 0;
    stalled_steps_ = is_stalled ? stalled_steps_ + 1 : 0;
    now_.x = x;
    now_.at = trial;
    guard_.largest_gradient = std::max(guard_.largest_gradient, projected_gradient());
    steps_.forget_limits();
    failures_ = refusals_ = rejections_ = model_failures_ = 0;
    ++accepted_;
    border_.update();
    if (is_wavy) return end(MinimizeStop::wavy, "values go up and down along the steps");
    return is_left ? end(MinimizeStop::outpaced, "more is expected elsewhere") : ends_by_progress();
}

bool SqpSearch::tells_of_waves(const Evaluation& trial, const VectorXd& step, const VectorXd& lambda) const {
    if (!guard_.options.on_misfit || now_.program.differences) return false;
    const double change = trial.objective - now_.at.objective + lambda.dot(trial.constraints - now_.at.constraints);
    const double telling = std::max(trust_region.telling_change * guard_.gained(trial.objective),
                                    guard_.decrease_tolerance(trial.objective));
    return std::abs(change) > telling && !guard_.options.on_misfit(parabola_misfit(now_, trial, lambda, step));
}

bool SqpSearch::ends_by_progress() {
    const auto are_small = [&] { return small_decreases_ >= trust_region.max_small_decreases; };
    const auto are_stalled = [&] { return stalled_steps_ >= trust_region.max_stalled_steps; };
    if ((are_small() || are_stalled()) && complete_gradient()) small_decreases_ = stalled_steps_ = 0;
    if (are_small()) return end_by_small_steps();
    if (are_stalled()) return end(MinimizeStop::roundoff, "the violation of the constraints no longer falls");
    return is_outpaced();
}

bool SqpSearch::end_by_small_steps() {
    if (guard_.options.is_relative_to_objective)
        return end(MinimizeStop::converged, "the objective changes by less than the tolerance");
    const VectorXd free = solve_model(steps_.model(now_.at.constraints, 0));
    const double expected = free.size() > 0 ? merit_.expected_decrease(hessian_.matrix(), free) : 0;
    const double tolerance = guard_.decrease_tolerance(now_.at.objective);
    if (expected <= trust_region.unexpected_decrease * tolerance)
        return end(MinimizeStop::converged, "the objective changes by less than the tolerance");
    return end(MinimizeStop::roundoff,
               text("no further progress: the last ", trust_region.max_small_decreases, " steps gained less than ",
                    tolerance, " each, where the gradient predicts ", expected));
}

SqpEnd minimize_by_sqp(Guard& guard, double min_curvature) { return SqpSearch(guard, min_curvature).run(); }

}  // namespace strake
