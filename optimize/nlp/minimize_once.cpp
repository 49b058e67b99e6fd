#include "optimize/nlp/minimize_once.hpp"

#include "core/error.hpp"
#include "optimize/nlp/low_fidelity/low_fidelity_search.hpp"
#include "optimize/nlp/model/conflict.hpp"
#include "optimize/nlp/model/restoration.hpp"
#include "optimize/nlp/model/slope_check.hpp"
#include "optimize/nlp/model/verdict.hpp"
#include "optimize/nlp/nlopt/augmented_lagrangian.hpp"
#include "optimize/nlp/program/finite_differences.hpp"
#include "optimize/nlp/program/first_order.hpp"
#include "optimize/nlp/sqp/sqp.hpp"
#include "optimize/nlp/sqp/trust_region.hpp"
#include "optimize/nlp/surrogate/model_search.hpp"

namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double global_share = 0.7;  ///< of the evaluations; the rest polishes
constexpr double max_failing = 0.75;  ///< of the evaluations: with more, nothing is known of convergence
constexpr int max_confirmations = 5, separable_confirmations = 20;
constexpr double border_share = 1e-2;  ///< of the total decrease: with less, a fresh start along the border ends
constexpr double much_longer = 3;      ///< a better difference step is told
constexpr int max_returns = 5;         ///< of a method without gradients, from what looked like a border
constexpr double fresh_share = 0.1;    ///< of the mean curvature: a fresh model must find soft directions
constexpr int restoration_steps = 40, max_feasibility_phases = 2;

class Minimization {
public:
    Minimization(const NonlinearProgram& program, const MinimizeOptions& options)
        : guard_(program, options), method_(&guard_.method) {}

    MinimizeResult run() {
        if (start()) {
            search();
            approach_constraints();
            judge();
        }
        if (guard_.exception) std::rethrow_exception(guard_.exception);
        result_.x = guard_.best_x;
        result_.best = guard_.best;
        result_.violation = guard_.best_violation;
        result_.is_feasible = guard_.has_best && guard_.best_feasible;
        result_.evaluations = guard_.evaluations;
        result_.failures = guard_.failures;
        result_.noise = std::max(guard_.evidence.noise(), noise_);
        result_.largest_gradient = guard_.largest_gradient;
        return result_;
    }

private:
    bool is_constrained() const { return guard_.program.num_inequalities + guard_.program.num_equalities > 0; }

    bool has_low_fidelity() const { return method_->method == Method::sqp && guard_.program.low_fidelity.has_value(); }

    bool evaluate_start(Evaluation& evaluation) {
        const NonlinearProgram& p = guard_.program;
        if (has_low_fidelity() && learns_from_values(p)) return guard_.try_at(p.start, false, evaluation);
        const bool knows_more = method_->method == Method::sqp && p.start_gradient && p.differences;
        if (!knows_more) return guard_.try_at(p.start, guard_.wants_gradient, evaluation);
        if (!guard_.try_at(p.start, false, evaluation)) return false;
        const StartGradient& known = *p.start_gradient;
        return guard_.try_with(
            p.start,
            {known.gradient, known.jacobian, known.unknown_directions, metric_of(p), known.gradient_error.cols() == 0},
            evaluation);
    }

    /// Evaluates the start. False: that is all.
    bool start() {
        Evaluation evaluation;
        if (!evaluate_start(evaluation)) {
            take(end_by_cause(guard_));
            if (guard_.cause == StopCause::failure || guard_.cause == StopCause::fatal)
                end(MinimizeStop::failed, text("the start cannot be evaluated: ", guard_.failure));
            return false;
        }
        if (guard_.free.empty()) return end(MinimizeStop::converged, "all variables are fixed"), false;
        if (guard_.best.gradient.size() == 0 && has_low_fidelity()) return true;
        guard_.scale = objective_scale(guard_);
        if (guard_.wants_gradient && !method_->is_global && guard_.best.gradient.isZero(0) && guard_.best_feasible) {
            end(MinimizeStop::converged,
                "the gradient is zero at the start: the objective does not change with any variable");
            confirm_gradient();
            result_.is_flat = !result_.gradient_inconsistent;
            return false;
        }
        if (static_cast<int>(guard_.free.size()) < method_->min_variables) {
            guard_.report_event(
                text(method_->name, " needs at least ", method_->min_variables, " variables; sbplx takes its place"));
            method_ = &method_facts(Method::sbplx);
        }
        return true;
    }

    void search() {
        if (has_low_fidelity() && !run_low_fidelity()) return;
        if (method_->method == Method::sqp) return run_sqp();
        if (method_->method == Method::model) return run_by_model();
        if (method_->is_global) return run_global();
        // A few evaluations are kept for the way back onto the constraints.
        const int all = guard_.options.max_evaluations;
        const int jacobian =
            method_->needs_gradients && !guard_.program.differences ? 0 : static_cast<int>(guard_.free.size());
        if (is_constrained()) guard_.limit = all - std::min(all / 4, jacobian + 4);
        SearchEnd found = search_by(*method_);
        for (int i = 0; i < max_returns && was_chance(found); ++i) found = search_by(*method_);
        guard_.limit = all;
        take(found);
        settle(found);
        if (found.stop == MinimizeStop::evaluations) end(found.stop, guard_.limit_words());
        if (found.is_at_border && (guard_.cause == StopCause::failure || guard_.cause == StopCause::none))
            follow_border();
        second_opinion();
    }

    /// The failures look like a border, but next to the best point differences fail on either side: sqp could not start
    /// there, and the method goes on.
    bool was_chance(const SearchEnd& found) {
        if (method_->needs_gradients || !found.is_at_border) return false;
        if (guard_.cause != StopCause::failure && guard_.cause != StopCause::none) return false;
        guard_.cause = StopCause::none;
        Evaluation evaluation;
        if (guard_.try_at(guard_.best_x, true, evaluation) || guard_.cause != StopCause::failure) return false;
        guard_.cause = StopCause::none;
        guard_.border = {};
        guard_.report_event(
            text("no plane separates the failures (", guard_.failure, "); continuing with ", method_->name));
        return true;
    }

    /// sqp knows the border of the failing region, and goes on along it.
    void follow_border() {
        guard_.cause = StopCause::none;
        guard_.report_event(
            text(method_->name, " met failures (", guard_.failure, "); continuing with sqp along their border"));
        guard_.wants_gradient = true;
        run_sqp();
        result_.reason = text(result_.reason, " (sqp went on where ", method_->name, " had met failures)");
    }

    /// Some algorithms stop before the optimum: those with gradients because of too careful steps or their line search,
    /// praxis because it knows no bounds.
    void second_opinion() {
        if (result_.stop != MinimizeStop::converged && result_.stop != MinimizeStop::roundoff) return;
        if (guard_.cause != StopCause::none) return;
        // The models of sqp are dense: with more variables they cost more than they gain.
        constexpr int max_variables = 300;
        const bool praxis = method_->method == Method::praxis && !is_constrained();
        if (praxis) {
            take(search_by(method_facts(Method::sbplx)));
            return;
        }
        Evaluation evaluation;
        if (guard_.free.size() > max_variables) return;
        if (!method_->needs_gradients || !guard_.try_at(guard_.best_x, true, evaluation) || !expects_more(guard_))
            return;
        guard_.report_event(text(method_->name, " ended (", result_.reason,
                                 "), but the gradient predicts a further decrease: continuing with sqp from there"));
        const double before = guard_.best.objective;
        const MinimizeResult own = result_;
        run_sqp();
        if (before - guard_.best.objective > 10 * guard_.decrease_tolerance(before))
            result_.reason = text(result_.reason, " (sqp went on where ", method_->name, " had stopped)");
        else if (own.stop == MinimizeStop::converged && result_.stop == MinimizeStop::roundoff)
            end(own.stop, own.reason);
    }

    SearchEnd search_by(const MethodFacts& method) {
        if (needs_lagrangian(method, guard_.program)) return minimize_augmented(guard_, method);
        const MinimizeOptions& o = guard_.options;
        // The approximations of these can get too careful; a fresh start distinguishes that from an end.
        const bool separable = method.method == Method::mma || method.method == Method::ccsaq;
        const int confirmations = separable ? separable_confirmations : o.confirm ? max_confirmations : 0;
        return run_with_restarts(guard_, method, nullptr, guard_.best_x,
                                 {o.objective_tolerance, o.step_tolerance, o.max_shrinks, confirmations});
    }

    /// The last steps onto the constraints from an end that misses them by little.
    void settle(const SearchEnd& found) {
        if (!is_constrained() || guard_.cause == StopCause::fatal || guard_.cause == StopCause::exception) return;
        if (guard_.cause == StopCause::time || guard_.cause == StopCause::stopped) return;
        guard_.cause = StopCause::none;
        const bool by_limit = found.stop == MinimizeStop::evaluations;
        const bool augmented = needs_lagrangian(*method_, guard_.program);
        const VectorXd from = by_limit && !augmented ? guard_.merit_x : found.x;
        Evaluation there;
        if (!guard_.try_at(from, false, there)) return;
        const double violation = largest_violation(guard_.program, there.constraints);
        const bool is_nearly = violation > guard_.options.constraint_tolerance && violation < 0.1;
        if (!is_nearly || (guard_.best_feasible && there.objective >= guard_.best.objective)) return;
        restore_feasibility(guard_, from, 8);
        if (guard_.cause == StopCause::failure) guard_.cause = StopCause::none;
    }

    /// False: that was all. Otherwise sqp goes on, from the best point by what is known there.
    bool run_low_fidelity() {
        const LowFidelityEnd low = minimize_by_low_fidelity(guard_);
        using Why = LowFidelityEnd::Why;
        result_.low_fidelity_scale = low.rho;
        if (low.expected > 0) result_.low_fidelity_kept = low.kept / low.expected;
        if (low.why == Why::misled) return true;
        result_.hessian = low.hessian;
        result_.radius = low.radius;
        result_.last_x = low.x;
        result_.last = low.at;
        if (low.why == Why::outpaced) return end(MinimizeStop::outpaced, "more is expected elsewhere"), false;
        if (low.why == Why::ended) return take(end_by_cause(guard_)), false;
        NonlinearProgram& p = guard_.program;
        // Its Hessian is that of a few steps: too stiff to say that nothing is left to gain.
        p.hessian.resize(0, 0);
        p.guessed.resize(0, 0);
        p.start_gradient.reset();
        if (low.x != guard_.best_x || !learns_from_values(p) || p.start.size() < trust_region.expensive_gradient)
            return true;
        p.start = low.x;
        const Eigen::Index n = p.start.size();
        p.start_gradient = StartGradient{low.at.gradient, low.at.jacobian, MatrixXd(n, 0), low.gradient_error};
        Evaluation evaluation = low.at;
        guard_.try_refined(low.x, {low.at.gradient, low.at.jacobian, MatrixXd(n, 0), metric_of(p), false}, evaluation);
        return true;
    }

    void run_by_model() {
        const ModelEnd found = minimize_by_model(guard_);
        result_.shrinks += found.shrinks;
        result_.radius = found.radius;
        if (!guard_.options.learns_as_before) {
            result_.last_x = found.x;
            result_.last = found.at;
            result_.hessian = found.hessian;
        }
        noise_ = found.noise;
        end(found.stop, found.reason);
    }

    void run_sqp() {
        double curvature = 0;
        int rounds = 0, max_steps = -1;
        for (bool continues = true; continues; ++rounds) {
            const double before = guard_.best.objective;
            const bool feasible_before = guard_.best_feasible;
            Evaluation evaluation;
            if (rounds > 0) guard_.forget_guessed();
            if (!guard_.try_at(guard_.best_x, true, evaluation)) return end_without_gradient();
            const SqpEnd sqp = minimize_by_sqp(guard_, curvature);
            result_.shrinks += sqp.shrinks;
            result_.radius = sqp.radius;
            if (sqp.accepted > max_steps) result_.hessian = sqp.hessian;  // a fresh start may learn less
            max_steps = std::max(max_steps, sqp.accepted);
            result_.gradient_error = sqp.gradient_error;
            result_.last_x = sqp.last_x;
            result_.last = sqp.last;
            end(sqp.stop, sqp.reason);
            const bool uncertain = confirmations_ == 0 && expects_more(guard_);
            continues = sqp.is_at_border ? gained_at_border(before)
                                         : sqp.stop == MinimizeStop::converged &&
                                               wants_confirmation(before, feasible_before, uncertain);
            // A fresh model of about the same size has little to relearn; an uncertain one starts from nothing.
            const double size = metric_of(guard_.program).trace();
            curvature = uncertain ? 0 : fresh_share * sqp.hessian.trace() / size;
        }
    }

    /// The best point has a value and stands, although its gradient fails.
    void end_without_gradient() {
        if (guard_.cause != StopCause::failure) return take(end_by_cause(guard_));
        end(MinimizeStop::no_valid_step,
            text("the best point has no gradient, and the search cannot go on from there: ", guard_.failure));
    }

    /// The model's curvature may be older than the border: a fresh one decides whether something is left to gain.
    bool gained_at_border(double before) {
        const double gain = before - guard_.best.objective, all = guard_.highest - guard_.best.objective;
        if (!guard_.options.confirm || !(gain > border_share * all) || ++confirmations_ > max_confirmations)
            return false;
        guard_.report_event("evaluations fail beyond a border; a fresh start from here confirms or continues");
        return true;
    }

    /// A quasi-Newton method may stop early: a fresh start shows it, which the gradient may ask for once.
    bool wants_confirmation(double before, bool feasible_before, bool uncertain) {
        const double floor = 10 * guard_.decrease_tolerance(guard_.best.objective);
        const bool gained = before - guard_.best.objective > floor || feasible_before != guard_.best_feasible;
        const bool wanted = (guard_.options.confirm && gained) || uncertain;
        if (!wanted || ++confirmations_ > max_confirmations) return false;
        guard_.report_event("converged; a fresh start from here confirms or continues");
        return true;
    }

    /// The global search gets its share of the evaluations; sqp polishes its best point with the rest.
    void run_global() {
        const int all = guard_.options.max_evaluations;
        guard_.limit = std::max(guard_.evaluations, static_cast<int>(global_share * all));
        const SearchEnd found = search_by(*method_);
        guard_.limit = all;
        take(found);
        if (found.stop == MinimizeStop::evaluations) guard_.cause = StopCause::none;
        if (guard_.cause != StopCause::none) return;
        const double value = guard_.best.objective;
        guard_.report_event(text(method_->name, " ended after ", guard_.evaluations, " evaluations at ", value, " (",
                                 found.reason, "); sqp polishes"));
        guard_.wants_gradient = true;
        guard_.border = {};  // all over the box no plane separates the failures
        Evaluation evaluation;
        if (!guard_.try_at(guard_.best_x, true, evaluation)) return end_without_gradient();
        guard_.scale = objective_scale(guard_);
        run_sqp();
        result_.reason = text(result_.reason, " (polished by sqp after ", method_->name, ")");
    }

    /// From an end outside the constraints: goes to the minimum violation; from a feasible point the search goes on.
    void approach_constraints() {
        for (int phase = 0; phase < max_feasibility_phases; ++phase) {
            const bool is_limited = guard_.cause != StopCause::none && guard_.cause != StopCause::failure;
            if (!guard_.has_best || guard_.best_feasible || is_limited || !is_constrained()) return;
            guard_.cause = StopCause::none;
            const Restoration r = restore_feasibility(guard_, guard_.best_x, restoration_steps);
            if (r.end == Restoration::End::stationary) return find_conflict(r);
            if (guard_.cause == StopCause::evaluations || guard_.cause == StopCause::time ||
                guard_.cause == StopCause::stopped || guard_.cause == StopCause::fatal)
                take(end_by_cause(guard_));
            if (!guard_.best_feasible) return;
            guard_.report_event(text("the constraints are met after ", guard_.evaluations, " evaluations; continuing"));
            guard_.cause = guard_.cause == StopCause::failure ? StopCause::none : guard_.cause;
            if (guard_.cause != StopCause::none) return;
            guard_.wants_gradient |= method_->is_global;
            method_->is_global ? run_sqp() : search();
        }
    }

    void find_conflict(const Restoration& r) {
        end(MinimizeStop::roundoff, "no step reduces the violation of the constraints");
        if (guard_.has_own_gradients()) check_slopes(guard_, result_);
        if (result_.gradient_inconsistent) return;  // a conflict by wrong gradients is none
        result_.conflict =
            conflicting_constraints(guard_.program, r.x, r.evaluation, guard_.options.constraint_tolerance);
        std::string rows;
        for (const int i : result_.conflict) rows += text(rows.empty() ? "" : ", ", i);
        const std::string what = result_.conflict.empty() ? "no step reduces the violation of the constraints"
                                 : result_.conflict.size() == 1
                                     ? text("constraint ", rows, " cannot be met within the bounds")
                                     : text("constraints ", rows, " are in conflict within the bounds");
        end(MinimizeStop::roundoff, text(what, "; the least violation is ", guard_.best_violation));
    }

    /// No search has converged, or ended without progress, by a gradient that the values contradict.
    void confirm_gradient() {
        if (!result_.conflict.empty() || result_.gradient_inconsistent || !guard_.has_own_gradients()) return;
        const bool is_old = guard_.options.is_relative_to_objective;
        const bool has_converged = result_.stop == MinimizeStop::converged && !(is_old && !expects_more(guard_));
        const bool is_open = guard_.cause == StopCause::none || guard_.cause == StopCause::failure;
        const bool is_short = !is_old && guard_.cause == StopCause::evaluations && guard_.evidence.is_contradicted() &&
                              guard_.limit == guard_.options.max_evaluations;
        if (!is_short && !(is_open && (has_converged || result_.stop == MinimizeStop::roundoff))) return;
        guard_.may_use_reserve = true;
        guard_.cause = StopCause::none;
        check_slopes(guard_, result_);
        if (result_.gradient_inconsistent) result_.stop = MinimizeStop::roundoff;
    }

    /// What the end says about the problem.
    void judge() {
        if (!guard_.has_best) return;
        confirm_gradient();
        advise_on_differences();
        result_.active_bounds = count_active_bounds(guard_);
        if (guard_.evaluations - guard_.failures > 1 && guard_.lowest == guard_.highest) {
            result_.is_flat = true;
            result_.reason +=
                "; the objective has been the same at every evaluation; check that it depends on the variables";
        }
        const MinimizeOptions& options = guard_.options;
        const int failures = options.failures_before + guard_.failures;
        if (failures > 0 && result_.stop != MinimizeStop::no_valid_step)
            result_.reason += text("; ", failures, " of ", options.evaluations_before + guard_.evaluations,
                                   " evaluations", options.scope, " failed");
        const bool is_shown = guard_.best.gradient.size() > 0 && !guard_.best.is_partly_guessed &&
                              !guard_.options.is_relative_to_objective && !expects_more(guard_);
        if (result_.stop == MinimizeStop::converged && guard_.failures > max_failing * guard_.evaluations && !is_shown)
            result_.stop = MinimizeStop::no_valid_step;  // too few values to say more
    }

    /// Tells of a difference step that measures noise.
    void advise_on_differences() const {
        const double noise = guard_.evidence.noise();
        if (!guard_.program.differences || !(noise > 0) || result_.hessian.size() == 0) return;
        const double curvature = result_.hessian.trace() / metric_of(guard_.program).trace();
        const double step = guard_.program.differences->step, best = best_difference_step(noise, curvature);
        if (best > much_longer * step)
            guard_.report_event(text("the values have noise of about ", noise, ": differences over steps of ", step,
                                     " see no slopes below ", noise / step, "; a difference_step of about ", best,
                                     " has the least error"));
    }

    void take(const SearchEnd& found) {
        result_.shrinks += found.shrinks;
        end(found.stop, found.reason);
    }
    void end(MinimizeStop stop, const std::string& reason) {
        result_.stop = stop;
        result_.reason = reason;
    }

    Guard guard_;
    const MethodFacts* method_;
    MinimizeResult result_;
    int confirmations_ = 0;
    double noise_ = 0;  ///< of the objective, by its model
};

}  // namespace

void validate(const NonlinearProgram& p, const MinimizeOptions& o) {
    const Eigen::Index n = p.start.size();
    if (p.lower.size() != n || p.upper.size() != n)
        throw InvalidInput(text("bounds: ", p.lower.size(), " and ", p.upper.size(), " for ", n, " variables"));
    for (Eigen::Index j = 0; j < n; ++j)
        if (!(p.lower[j] <= p.start[j] && p.start[j] <= p.upper[j]))
            throw InvalidInput(
                text("start of variable ", j, " = ", p.start[j], " must be in [", p.lower[j], ", ", p.upper[j], "]"));
    if (o.max_evaluations < 1) throw InvalidInput(text("max_evaluations = ", o.max_evaluations, " must be >= 1"));
    if (o.batch < 1) throw InvalidInput(text("batch = ", o.batch, " must be >= 1"));
    if (o.starts < 1) throw InvalidInput(text("starts = ", o.starts, " must be >= 1"));
    if (p.low_fidelity) {
        const auto rows = static_cast<std::size_t>(p.num_inequalities + p.num_equalities);
        if (!p.low_fidelity->program || p.low_fidelity->values.size() != 1 + rows ||
            p.low_fidelity->program->start.size() != n)
            throw InvalidInput(text("low_fidelity: a program of the same ", n, " variables and ", rows,
                                    " constraints is needed, with a kind for each value"));
    }
    if (p.differences) with_differences(p, *p.differences);
    const bool is_global = method_facts(o.method).is_global;
    if ((is_global || o.starts > 1) && !(p.lower.allFinite() && p.upper.allFinite()))
        throw InvalidInput(text(is_global ? "method " : "several starts with ", method_facts(o.method).name,
                                ": all variables need finite bounds"));
}

MinimizeResult minimize_once(const NonlinearProgram& program, const MinimizeOptions& options) {
    validate(program, options);
    return Minimization(program, options).run();
}

}  // namespace strake
