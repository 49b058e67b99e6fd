#include "core/error.hpp"
#include "optimize/nlp/sqp/sqp_search.hpp"
#include "optimize/nlp/sqp/trust_region.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

namespace strake {

using Eigen::VectorXd;

bool SqpSearch::is_small(double expected_decrease) const {
    const double share = guard_.options.is_relative_to_objective ? trust_region.small_decrease : 1;
    // A model that expects a rise, although no step at all is within it, was not solved.
    const double size = guard_.options.descends_as_before ? expected_decrease : std::abs(expected_decrease);
    return size <= std::max(share * guard_.decrease_tolerance(now_.at.objective), std::numeric_limits<double>::min());
}

bool SqpSearch::end_by_small(double expected_decrease) {
    const double noise = guard_.evidence.noise();
    const bool is_noise = !guard_.options.is_relative_to_objective && expected_decrease <= noise &&
                          guard_.decrease_tolerance(now_.at.objective) <= noise;
    // Where noise has rejected steps, it also hides whether the gradient is right.
    if (is_noise)
        return end(MinimizeStop::roundoff, text("noise of the values, about ", noise,
                                                ", hides further gains: ", expected_decrease, " is expected"));
    return end(MinimizeStop::converged, "the expected decrease is below the tolerance");
}

double SqpSearch::projected_gradient() const {
    VectorXd g = lagrangian_gradient(now_);
    for (Eigen::Index j = 0; j < g.size(); ++j)
        if (leaves_bounds(now_.program, now_.x, j, -g[j])) g[j] = 0;
    return dual_norm(now_.program, g);
}

bool SqpSearch::is_stationary(const VectorXd& d, double predicted) {
    const bool is_feasible = now_.is_met(now_.at), is_limited = steps_.is_limited();
    const double step_tolerance = guard_.options.step_tolerance;
    if (is_feasible && !guard_.options.is_relative_to_objective &&
        projected_gradient() <= guard_.options.objective_tolerance * guard_.largest_gradient)
        return end(MinimizeStop::converged, "the projected gradient is below the tolerance");
    if (is_limited && steps_.radius > step_tolerance) {
        if (!is_feasible || rejections_ + failed_in_row() == 0) return false;
        // A step that is short because longer ones were rejected or failed has a small expected decrease in any case.
        const VectorXd free = solve_model(steps_.model(now_.at.constraints, 0));
        const double expected = merit_.expected_decrease(hessian_.matrix(), free.size() > 0 ? free : d);
        return free.size() > 0 && is_small(expected) && end_by_small(expected);
    }
    const bool is_short = d.lpNorm<Eigen::Infinity>() <= step_tolerance;
    // Steps that fail say nothing of the gradient.
    if (is_short && is_limited && failed_in_row() > 0 && rejections_ == 0) return end_by_failures(border_.is_known());
    if (is_short)
        return end(is_limited    ? MinimizeStop::roundoff
                   : is_feasible ? MinimizeStop::converged
                                 : MinimizeStop::roundoff,
                   is_limited    ? "no step, however short, gains what the gradient predicts"
                   : is_feasible ? "the variables change by less than the tolerance"
                                 : "the constraints cannot be met within the bounds");
    return is_small(predicted) && is_feasible && end_by_small(predicted);
}

bool SqpSearch::complete_gradient() {
    if (!gradient_.complete(now_.at)) return false;
    merit_.raise_penalty(trust_region.penalty_factor *
                         multipliers(now_.program, now_.x, now_.at).lpNorm<Eigen::Infinity>());
    border_.update();
    return true;
}

bool SqpSearch::ends_here() {
    if (gradient_.is_exact()) return true;
    if (complete_gradient()) return false;
    return guard_.cause == StopCause::none || ended_by_guard();
}

bool SqpSearch::is_outpaced() {
    if (!guard_.options.on_model ||
        largest_violation(now_.program, now_.at.constraints) > trust_region.handover_violation)
        return false;
    VectorXd g = lagrangian_gradient(now_);
    const Eigen::LLT<Eigen::MatrixXd> inverse(hessian_.matrix());
    if (inverse.info() != Eigen::Success) return false;  // a model that expects nothing says nothing of others
    const VectorXd d = -inverse.solve(g);
    for (Eigen::Index j = 0; j < g.size(); ++j)
        if (leaves_bounds(now_.program, now_.x, j, d[j])) g[j] = 0;
    if (guard_.options.on_model(0.5 * g.dot(inverse.solve(g)), hessian_.matrix())) return false;
    return end(MinimizeStop::outpaced, "more is expected elsewhere");
}

bool SqpSearch::failed_at(const VectorXd& d) {
    if (guard_.cause != StopCause::failure) return ended_by_guard();
    guard_.cause = StopCause::none;
    if (!guard_.failed_on_the_way) border_.update();
    const bool knows_border = !guard_.failed_on_the_way && border_.is_known();
    if (knows_border && border_.expected_decrease() <= trust_region.border_share * total_decrease())
        return end_at_border();
    ++(was_paid_ ? failures_ : refusals_);
    // To learn where the border lies takes failures, the more the more variables there are.
    const int more_in_row = std::min(trust_region.border_failures_per_variable * static_cast<int>(now_.x.size()),
                                     trust_region.max_border_failures_in_row);
    const int in_row = knows_border ? more_in_row : 0;
    // A solver that fails now and then does not end a search that goes on gaining.
    const int all = guard_.options.max_failures * (1 + accepted_ / trust_region.steps_per_failures) +
                    (knows_border ? accepted_ + trust_region.max_border_failures : 0);
    if (failures_ > guard_.options.max_shrinks + in_row || refusals_ > trust_region.max_refusals + in_row ||
        (was_paid_ && end_.shrinks >= all))
        return end_by_failures(knows_border);
    end_.shrinks += was_paid_;
    if (refusals_ > trust_region.refusals_by_border)
        steps_.radius = trust_region.failure_cut * std::min(steps_.radius, steps_.length(d));
    else if (!knows_border)
        steps_.radius = (failed_in_row() > 1 ? trust_region.repeated_failure_cut : trust_region.failure_cut) *
                        std::min(steps_.radius, steps_.length(d));
    if (was_paid_)
        report(text("after the failure of its evaluation ", guard_.evaluations, ": ",
                    knows_border
                        ? std::string("steps keep to this side of the plane between what failed and what did not")
                        : text("the largest step is cut to ", steps_.radius)));
    return false;
}

bool SqpSearch::end_by_failures(bool knows_border) {
    const VectorXd free = solve_model(steps_.model_without_cut(now_.at.constraints, 0));
    const double expected = free.size() > 0 ? merit_.expected_decrease(hessian_.matrix(), free) : total_decrease();
    const bool is_met = now_.is_met(now_.at) && gradient_.is_exact() && !guard_.options.is_relative_to_objective;
    if (is_met && expected <= trust_region.unexpected_decrease * guard_.decrease_tolerance(now_.at.objective))
        return end(MinimizeStop::converged, "the expected decrease is below the tolerance, and longer steps fail");
    end_.is_at_border = knows_border;
    return end(MinimizeStop::no_valid_step,
               text(was_paid_ ? "evaluations" : "steps", " keep failing next to the best point (", failure_words()));
}

std::string SqpSearch::failure_words() const {
    return text(guard_.failures, " of this search's ", guard_.evaluations, " evaluations failed",
                without_shape_ > 0 ? text(", and ", without_shape_, " steps led to no valid shape") : "",
                "); the last failure: ", guard_.failure);
}

bool SqpSearch::end_at_border() {
    // What failed there may have been bad luck.
    const QuadraticModel without_cut = steps_.model_without_cut(now_.at.constraints, 0);
    if (const VectorXd free = solve_model(without_cut); free.size() > 0)
        for (const double share : trust_region.border_probes) {
            const VectorXd d = share * std::min(1.0, steps_.radius / steps_.length(free)) * free;
            Trial trial{{}, d};
            if (try_step(trial)) {
                const double decrease = merit_.at_present() - merit_.of(trial.evaluation);
                if (decrease > 0) return accept(trial.x, trial.evaluation, decrease, steps_.active(without_cut, free));
                continue;
            }
            if (guard_.cause != StopCause::failure) return ended_by_guard();
            guard_.cause = StopCause::none;
        }
    end_.is_at_border = true;
    return end(MinimizeStop::no_valid_step,
               text("evaluations fail beyond a border next to the best point, and nothing is left to gain before it (",
                    failure_words()));
}

bool SqpSearch::rejected(double length) {
    if (++rejections_ == trust_region.max_guessed_rejections && complete_gradient()) return false;
    if (rejections_ < trust_region.max_rejections && length > trust_region.min_step) return false;
    return end(MinimizeStop::roundoff, "no step, however short, gains what the gradient predicts");
}

bool SqpSearch::cut_back(const VectorXd& d) {
    const double length = steps_.length(d);
    steps_.radius = trust_region.max_cut * std::min(steps_.radius, length);
    return rejected(length) && end(MinimizeStop::roundoff, "every step, however short, leads beyond the motion limit");
}

bool SqpSearch::model_failed() {
    if (++model_failures_ > trust_region.max_model_failures)
        return end(MinimizeStop::roundoff, "the quadratic model can no longer be solved");
    start_hessian();
    return false;
}

bool SqpSearch::ended_by_guard() {
    const GuardEnd found = guard_.end_by_cause();
    return end(found.stop, found.reason);
}

void SqpSearch::restore() {
    if (end_.stop == MinimizeStop::failed || !needs_restoration()) return;
    if (guard_.best_feasible && !(now_.at.objective < guard_.best.objective)) return;
    if (guard_.cause == StopCause::stopped) guard_.cause = StopCause::none;
    const NonlinearProgram& p = now_.program;
    VectorXd x = now_.x;
    Evaluation s = now_.at;
    for (int i = 0; i < trust_region.max_restorations && guard_.cause == StopCause::none; ++i) {
        QuadraticModel m = steps_.model(s.constraints, 0);
        m.gradient.setZero();
        m.hessian = p.metric;
        m.min_step = 0;
        m.lower = p.lower - x;
        m.upper = p.upper - x;
        // Of the limits and the cut, which stand behind the inequalities, the values are those at now_.x.
        const Eigen::Index more = m.constraints.size() - s.constraints.size();
        m.constraints.segment(p.num_inequalities, more) +=
            m.jacobian.middleRows(p.num_inequalities, more) * (x - now_.x);
        const VectorXd d = solve_model(m);
        if (d.size() == 0 || metric_norm(p, d) > trust_region.max_restoration_step) return;
        x = guard_.inside(now_.clamped(x + d));
        if (!guard_.try_at(x, false, s) || now_.is_met(s)) return;
    }
}

bool SqpSearch::end(MinimizeStop stop, const std::string& reason) {
    end_.stop = stop;
    end_.reason = reason;
    return true;
}

}  // namespace strake
