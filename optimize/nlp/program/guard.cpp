#include "optimize/nlp/program/guard.hpp"

#include "core/error.hpp"
#include "optimize/nlp/program/difference_step.hpp"
#include "optimize/nlp/program/finite_differences.hpp"
#include "optimize/nlp/program/first_order.hpp"

#include <chrono>
#include <nlopt.hpp>

namespace strake {
namespace {

constexpr std::size_t max_failed_points = 64;  ///< in a row: searches end before, but global ones
constexpr int reserved = 2;                    ///< evaluations for the check of a gradient that steps contradict
constexpr int min_budget = 8;                  ///< of which they may be taken

/// Gradient-free methods never call `differentiate`.
NonlinearProgram prepared(NonlinearProgram p, const MethodFacts& method) {
    if (!method.needs_gradients && !method.is_global) p.differentiate = nullptr;
    if (!p.differentiate) {
        Differences how = p.differences.value_or(Differences());
        how.objective = true;
        how.rows.clear();
        p.differences = how;
    }
    return p;
}

/// What the program says; `otherwise` where the guard has stopped, or an exception stops it.
template <class T, class Ask>
T told(Guard& guard, const T& otherwise, const Ask& ask) {
    if (guard.cause != StopCause::none) return otherwise;
    try {
        return ask();
    } catch (...) {
        guard.exception = std::current_exception();
        guard.cause = StopCause::exception;
        return otherwise;
    }
}

}  // namespace

Guard::Guard(const NonlinearProgram& p, const MinimizeOptions& o)
    : program(prepared(p, method_facts(o.method))),
      options(o),
      method(method_facts(o.method)),
      limit(o.max_evaluations),
      best_x(p.start),
      largest_gradient(o.largest_gradient) {
    for (Eigen::Index j = 0; j < p.start.size(); ++j)
        if (p.lower[j] < p.upper[j]) free.push_back(static_cast<int>(j));
    wants_gradient = method.needs_gradients;
}

double Guard::now() const {
    if (options.clock) return options.clock();
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

Eigen::VectorXd Guard::all_variables(const double* z) const {
    Eigen::VectorXd x = program.start;
    for (std::size_t i = 0; i < free.size(); ++i) x[free[i]] = z[i];
    return x;
}

const Evaluation& Guard::at(const double* z, bool gradient) { return requested(all_variables(z), gradient); }

const Evaluation& Guard::requested(const Eigen::VectorXd& x, bool gradient) {
    // Known points cost nothing: no other limit ends an algorithm that repeats them.
    if (++requests_ > 100L * options.max_evaluations + 10000 && cause == StopCause::none)
        cause = StopCause::repeated_points;
    return at_all(x, gradient);
}

const Evaluation& Guard::at_all(const Eigen::VectorXd& asked, bool gradient) {
    if (cause != StopCause::none) throw nlopt::forced_stop();
    if (!asked.allFinite()) stop(StopCause::nonfinite_point);
    const Eigen::VectorXd x = asked.cwiseMax(program.lower).cwiseMin(program.upper);
    if (!reported_outside_ && (x - asked).lpNorm<Eigen::Infinity>() > 1e-6) {
        reported_outside_ = true;
        report_event("the algorithm asked for a point outside the bounds; such points are moved onto the bounds");
    }
    const Eigen::VectorXd there = inside(x);
    if (cause != StopCause::none) throw nlopt::forced_stop();
    try {
        return evaluation_at(there, gradient);
    } catch (const nlopt::forced_stop&) {
        throw;
    } catch (...) {
        exception = std::current_exception();
        stop(StopCause::exception);
    }
}

Eigen::VectorXd Guard::inside(const Eigen::VectorXd& x) {
    if (!program.within || cause != StopCause::none) return x;
    const auto is = [&](const Eigen::VectorXd& known) { return known.size() == x.size() && known == x; };
    if ((has_best && is(best_x)) || is(last_x_) || is(moved_) || std::ranges::any_of(expected_, is)) return x;
    if (is(asked_)) return moved_;
    const Eigen::VectorXd there = told(*this, x, [&] { return program.within(x); });
    if (cause != StopCause::none) return x;
    moved_ = there.cwiseMax(program.lower).cwiseMin(program.upper);
    asked_ = x;
    return moved_;
}

void Guard::expect(const std::vector<Eigen::VectorXd>& points) {
    expected_ = points;
    if (program.expect) program.expect(points);
}

bool Guard::is_defined(const Eigen::VectorXd& x) {
    return !program.is_defined || told(*this, true, [&] { return program.is_defined(x); });
}

bool Guard::is_refused(const Eigen::VectorXd& x) {
    if (!program.refusal) return false;
    const std::string why = told(*this, std::string(), [&] { return program.refusal(x); });
    if (why.empty()) return false;
    failure = why;
    failed_on_the_way = false;
    border.add_failed(x);
    return true;
}

StepLimits Guard::beyond(const Eigen::VectorXd& from, const Eigen::VectorXd& to) {
    if (!program.beyond) return {};
    return told(*this, StepLimits(), [&] { return program.beyond(from, to); });
}

bool Guard::try_with(const Eigen::VectorXd& x, const GradientGuess& guess, Evaluation& evaluation) {
    guess_ = &guess;
    const bool ok = try_at(x, true, evaluation);
    guess_ = nullptr;
    return ok;
}

bool Guard::try_refined(const Eigen::VectorXd& x, const GradientGuess& guess, Evaluation& evaluation) {
    evaluation.gradient.resize(0);
    if (has_best && x == best_x) best.gradient.resize(0);
    last_ = evaluation;
    last_x_ = x;
    is_refined_ = true;
    const bool ok = try_with(x, guess, evaluation);
    is_refined_ = false;
    return ok;
}

void Guard::forget_guessed() {
    if (best.is_partly_guessed) best.gradient.resize(0), best.is_partly_guessed = false, last_x_.resize(0);
}

bool Guard::try_at(const Eigen::VectorXd& x, bool gradient, Evaluation& evaluation) {
    try {
        evaluation = at_all(x, gradient);
        return true;
    } catch (const nlopt::forced_stop&) {
        return false;
    }
}

const Evaluation& Guard::evaluation_at(const Eigen::VectorXd& x, bool gradient) {
    if (has_best && x == best_x && (!gradient || best.gradient.size() > 0)) return best;
    if (has_best && x == best_x && !program.differentiate)
        last_ = best, last_x_ = x;  // differences need its values only
    if (!(last_x_.size() > 0 && x == last_x_)) evaluate(x);
    if (gradient && last_.gradient.size() == 0) differentiate(x);
    return last_;
}

void Guard::stop(StopCause why) {
    cause = why;
    throw nlopt::forced_stop();
}

void Guard::fail_gradient(const Eigen::VectorXd& x, const std::string& why) {
    failure = why;
    failed_x = x;
    last_x_.resize(0);
    border.add_failed(x);
    stop(StopCause::failure);
}

Evaluation Guard::count_and_evaluate(const Eigen::VectorXd& x) {
    Evaluation s = evaluation_of(x);
    if (s.failure.empty())
        border.add_sound(x);
    else if (!s.is_of_step)
        border.add_failed(x);
    failed_on_the_way = s.is_of_step;
    return s;
}

double Guard::decrease_tolerance(double objective) const {
    if (options.is_relative_to_objective)
        return options.objective_tolerance * std::max(std::abs(objective), 1e-3 * options.gained_before);
    return std::max(options.objective_tolerance * gained(objective), resolution(objective, evidence.noise()));
}

double Guard::gained(double objective) const {
    const double change = std::abs(start_objective - objective);
    return std::max(options.gained_before, std::isfinite(change) ? change : 0);
}

std::string Guard::limit_words() const {
    const int all = std::max(options.max_evaluations, limit);
    const int before = options.evaluations_before;
    return text("the limit of evaluations", options.scope, " is reached (",
                evaluations < all ? text(before + evaluations, " of ", before + all) : text(before + all), ")");
}

GuardEnd Guard::end_by_cause() const {
    switch (cause) {
        case StopCause::evaluations:
            return {MinimizeStop::evaluations, limit_words()};
        case StopCause::time:
            return {MinimizeStop::time, "the time limit is reached"};
        case StopCause::stopped:
            return {MinimizeStop::stopped, "stopped on request"};
        default:
            return {MinimizeStop::failed, failure};
    }
}

int Guard::reserve() const {
    const bool is_wanted = !may_use_reserve && limit == options.max_evaluations && limit >= min_budget &&
                           !options.is_relative_to_objective && has_own_gradients() && evidence.is_contradicted();
    return is_wanted ? reserved : 0;
}

Evaluation Guard::evaluation_of(const Eigen::VectorXd& x) {
    if (evaluations >= limit - reserve()) stop(StopCause::evaluations);
    if (options.max_seconds > 0 && evaluations > 0 && now() - begin_ > options.max_seconds) stop(StopCause::time);
    if (patience_ > 0 && evaluations - gained_at_ >= patience_) stop(StopCause::stalled);
    ++evaluations;
    Evaluation s;
    try {
        s = program.evaluate(x);
    } catch (const InvalidInput&) {
        throw;
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& e) {
        if (!options.exceptions_are_failures) throw;
        s.failure = e.what();
        if (s.failure.empty()) s.failure = "an exception without a message";
    }
    if (!s.failure.empty()) return s;
    const Eigen::Index rows = program.num_inequalities + program.num_equalities;
    if (s.constraints.size() != rows)
        throw InvalidInput(text("evaluation gave ", s.constraints.size(), " constraints instead of ", rows));
    if (!std::isfinite(s.objective) || !s.constraints.allFinite())
        s.failure = text("objective or constraint not finite at evaluation ", evaluations);
    return s;
}

void Guard::evaluate(const Eigen::VectorXd& x) {
    const auto is_known = [&](const Eigen::VectorXd& failed) { return failed == x; };
    if (std::any_of(failed_since_value_.begin(), failed_since_value_.end(), is_known)) {
        failed_x = x;
        stop(StopCause::failure);
    }
    last_x_.resize(0);
    last_ = count_and_evaluate(x);
    if (!last_.failure.empty()) {
        const bool go_on = report({x, last_, 0, false, false, best_merit, penalty});
        if (failed_since_value_.size() < max_failed_points) failed_since_value_.push_back(x);
        ++failures;
        failure = last_.failure;
        failed_x = x;
        stop(last_.is_fatal ? StopCause::fatal : go_on ? StopCause::failure : StopCause::stopped);
    }
    last_x_ = x;
    failed_since_value_.clear();
    rank(x);
}

void Guard::rank(const Eigen::VectorXd& x) {
    if (!has_best) start_objective = last_.objective;
    if (wants_gradient) evidence.add_values(x, last_);
    const double violation = largest_violation(program, last_.constraints);
    const bool feasible = violation <= options.constraint_tolerance;
    const bool better =
        !has_best || (feasible && !best_feasible) ||
        (feasible == best_feasible && (feasible ? last_.objective < best.objective : violation < best_violation));
    if (better) {
        const double gain = feasible ? best.objective - last_.objective : best_violation - violation;
        const double floor = feasible ? decrease_tolerance(last_.objective) : 0;
        if (!has_best || feasible != best_feasible || gain > floor) gained_at_ = evaluations;
        has_best = true;
        best = last_;
        best_x = x;
        best_feasible = feasible;
        best_violation = violation;
    }
    lowest = std::min(lowest, last_.objective);
    highest = std::max(highest, last_.objective);
    if (penalty == 0) penalty = 3 * std::abs(last_.objective);  // until multipliers are known
    remember_merit(x);
    if (!report({x, last_, violation, better, feasible, best_merit, penalty})) stop(StopCause::stopped);
}

void Guard::remember_merit(const Eigen::VectorXd& x) {
    const double objective = last_.objective, violation = total_violation(program, last_.constraints);
    const auto is_no_better = [&](const MeritPoint& p) { return p.objective <= objective && p.violation <= violation; };
    if (std::none_of(merit_points_.begin(), merit_points_.end(), is_no_better)) {
        std::erase_if(merit_points_,
                      [&](const MeritPoint& p) { return objective <= p.objective && violation <= p.violation; });
        merit_points_.push_back({objective, violation, x});
    }
    best_merit = std::numeric_limits<double>::infinity();
    for (const MeritPoint& p : merit_points_)
        if (const double merit = p.objective + penalty * p.violation; merit < best_merit)
            best_merit = merit, merit_x = p.x;
}

void Guard::differentiate(const Eigen::VectorXd& x) {
    Evaluation s = last_;
    if (program.differentiate && !is_refined_) try {
            program.differentiate(x, s);
        } catch (const InvalidInput&) {
            throw;
        } catch (const std::bad_alloc&) {
            throw;
        } catch (const std::exception& e) {
            if (!options.exceptions_are_failures) throw;
            ++failures;
            fail_gradient(x, text("gradient at evaluation ", evaluations, ": ", e.what()));
        }
    if (!s.failure.empty()) {
        ++failures;
        if (!s.is_fatal) fail_gradient(x, s.failure);
        failure = s.failure;
        failed_x = x;
        last_x_.resize(0);
        stop(StopCause::fatal);
    }
    if (program.differences) add_differences(x, s);
    last_ = s;
    check_gradient(x);
    if (!last_.is_partly_guessed) evidence.add_gradients(x, last_);
    last_x_ = x;
    if (has_best && best_x == x) best = last_;
}

void Guard::add_differences(const Eigen::VectorXd& x, Evaluation& s) {
    last_x_.resize(0);  // the program's last evaluation will not be the one at x
    const auto evaluate = [&](const Eigen::VectorXd& at) {
        // The border does not learn from it: next to x, one chance failure would hide where it lies.
        Evaluation next = evaluation_of(at);
        failed_on_the_way = next.is_of_step;
        if (next.failure.empty()) return next;
        ++failures;
        failure = next.failure;
        if (next.is_fatal) stop(StopCause::fatal);
        return next;
    };
    const auto expect = [&](std::vector<Eigen::VectorXd> points) {
        if (!program.expect) return;
        points.resize(std::min(points.size(), static_cast<std::size_t>(std::max(0, limit - evaluations))));
        program.expect(points);
    };
    if (guess_ && differentiate_along(program, x, s, *guess_, evaluate, expect)) {
        s.is_partly_guessed = !guess_->is_complete;
        return;
    }
    s.is_partly_guessed = false;
    const Evaluation before = s;
    bool has_gradient = differentiate_by_differences(program, x, s, evaluate, expect);
    if (has_gradient && follow_noise(x, s, evaluate)) {
        s = before;
        has_gradient = differentiate_by_differences(program, x, s, evaluate, expect);
    }
    if (!has_gradient)
        fail_gradient(x, text("no differences give the gradient at evaluation ", evaluations, ": ", failure));
}

bool Guard::follow_noise(const Eigen::VectorXd& x, const Evaluation& at,
                         const std::function<Evaluation(const Eigen::VectorXd&)>& evaluate) {
    Differences& how = *program.differences;
    if (knows_noise_ || how.max_step <= how.step) return false;
    knows_noise_ = true;
    const std::optional<StepChoice> choice = step_above_noise(program, x, at, how.max_step, evaluate);
    if (!choice) return false;
    const std::string what = choice->value == 0 ? "the objective" : text("constraint ", choice->value - 1);
    report_event(text(what, " carries noise of ", choice->noise, ": differences take steps of ", choice->step,
                      " in place of ", how.step));
    how.step = choice->step;
    if (how.on_step) how.on_step(choice->step);
    return true;
}

void Guard::check_gradient(const Eigen::VectorXd& x) {
    const Eigen::Index rows = last_.constraints.size();
    if (last_.gradient.size() == x.size() && last_.gradient.allFinite() &&
        (rows == 0 || (last_.jacobian.rows() == rows && last_.jacobian.cols() == x.size())) &&
        last_.jacobian.allFinite()) {
        if (rows == 0) last_.jacobian.resize(0, x.size());
        return;
    }
    if (last_.gradient.size() != x.size() && last_.gradient.size() > 0)
        throw InvalidInput(text("gradient of ", last_.gradient.size(), " entries for ", x.size(), " variables"));
    last_.gradient.resize(0);
    ++failures;
    fail_gradient(x, text("gradient not finite at evaluation ", evaluations));
}

}  // namespace strake
