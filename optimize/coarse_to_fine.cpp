#include "optimize/coarse_to_fine.hpp"

#include "core/error.hpp"
#include "optimize/level_program.hpp"
#include "optimize/methods.hpp"
#include "optimize/partial_gradient.hpp"
#include "optimize/refinement.hpp"
#include "optimize/run_verdict.hpp"

namespace strake {
namespace {

constexpr int failures_before_refining = 4;  ///< the last level the minimizer's own limits hold
constexpr double variables_at_price = 10;    ///< new ones that have to promise `promise_below` of what was gained
/// A gradient by differences costs an evaluation for each variable, so that coarse levels are finished first: left once
/// their model sees no more than this share of what they have gained.
constexpr double done_by_differences = 0.05;
/// Nor does one cost more than so many gradients of the next.
constexpr double patience_by_differences = 2;
constexpr int parts_of_a_patch = 4;
constexpr double most_credit = 100;  ///< for promises that turned out too small

class Optimization {
public:
    Optimization(const Problem& problem, const RunEvents& events, Journal* journal)
        : state_(problem, events, LevelProgram::differentiated_names(problem), journal), program_(state_) {
        state_.evaluator.take_over_values();
    }

    RunResult run() {
        try {
            walk();
        } catch (const Interrupted&) {
            state_.leave_level();
            conclude_interrupted(state_.result);
        } catch (const Awaited&) {
            state_.leave_level();
            conclude_waiting(state_.result);
        }
        return state_.result;
    }

private:
    void walk() {
        Eigen::VectorXd x;
        MinimizeResult level;
        level.stop = MinimizeStop::converged;
        bool any = false;
        for (std::optional<Front> front;;) {
            x = state_.next_level(x, front ? &*front : nullptr);
            if (state_.space.size() == 0) {
                hessian_.resize(0, 0);
            } else {
                level = run_level(x, any ? Entry::refined : Entry::first);
                any = true;
                x = level.x;
            }
            bool refines = finish_or_refine(x, level, front);
            while (!refines && ended_at_limit(level) && state_.limits_were_raised()) {
                level = run_raised(x);
                x = level.x;
                refines = finish_or_refine(x, level, front);
            }
            state_.end_level(state_.space.size() == 0 ? "no variable of this level moves anything"
                                                      : level_words(level));
            if (!refines) break;
        }
        if (!any)
            throw InvalidInput("nothing to optimize: no variable of any level moves anything; is all of it fixed?");
        state_.result.level = state_.space.level;
        conclude_run(state_.result,
                     {level, program_.rows(), program_.quantity_failed(), program_.last_failed_in_quantity(),
                      state_.run_best.feasible, state_.can_refine(), refining_is_idle_});
    }

    /// True: on to this front. A level that was left for details that turn out to be worth nothing goes on to its end.
    bool finish_or_refine(Eigen::VectorXd& x, MinimizeResult& level, std::optional<Front>& front) {
        is_in_noise_ = level.stop == MinimizeStop::roundoff;
        if (!goes_on(level) || !state_.can_refine()) return false;
        if (choose_front(x, front)) return true;
        const bool was_left = level.stop == MinimizeStop::stopped || level.stop == MinimizeStop::outpaced;
        const bool has_spent_its_share = level.stop == MinimizeStop::evaluations;
        if (!refining_is_idle_ || !(was_left || has_spent_its_share)) return false;
        level = run_level(x, Entry::finished);
        x = level.x;
        is_in_noise_ = level.stop == MinimizeStop::roundoff;
        return goes_on(level) && choose_front(x, front);  // it may have come to where details are worth something
    }

    static bool ended_at_limit(const MinimizeResult& level) {
        return level.stop == MinimizeStop::evaluations || level.stop == MinimizeStop::time;
    }

    /// The level once more from its best design, which is not paid again, under the larger limits of a resumed run.
    MinimizeResult run_raised(const Eigen::VectorXd& x) {
        state_.begin_level_again();
        return run_level(x, Entry::again);
    }

    bool goes_on(const MinimizeResult& level) const {
        return level.stop != MinimizeStop::failed && !level.gradient_inconsistent && state_.evaluations_left() > 0 &&
               state_.seconds_left() > 0;
    }

    /// The front of the next level where the run chooses it. False: refining promises nothing.
    bool choose_front(const Eigen::VectorXd& x, std::optional<Front>& front) {
        front.reset();
        probed_ = 1;
        const SplitRule rule = state_.rest->parameters.split;
        if (rule == SplitRule::tree) return true;
        if (state_.space.size() == 0 || !program_.has_lagrangian()) {
            const Front& present = *state_.space.front;
            state_.note("refinement: there are no sensitivities to choose by, every patch is split");
            front = split_front(*state_.rest->tree, present, std::vector<char>(present.depth.size(), 1));
            return true;
        }
        const ShellSensitivities lagrangian = program_.lagrangian();
        const DesignFacts facts{state_.space, x, lagrangian, curvature_, program_.known().dJ_dv};
        const std::optional<Outlook> outlook = look_ahead(facts);
        refining_is_idle_ = !outlook;  // finer patches that are all held, or do the same
        if (refining_is_idle_) {
            state_.note("refinement: no patch has finer parts");
            return false;
        }
        const std::optional<double> probed = probe(x, *outlook);
        const double times = probed.value_or(credit());
        probed_ = probed.value_or(1);
        // Measured by what has been gained, so that an objective may go to zero.
        const double now = state_.level_best_objective;
        const double gained = std::abs(state_.result.objective_start - now);
        const double least = state_.problem.optimize.promise_below * gained;
        const bool has_price = rule == SplitRule::sensitivity && hessian_.size() > 0 && !is_in_noise_;
        const RefinementPlan plan =
            plan_refinement(facts, *outlook, has_price ? least / variables_at_price / times : 0);
        state_.note(text("refinement: ", plan.words(),
                         times == 1 ? ""
                         : probed   ? text("; the values promise ", times, " times that")
                                    : text("; the last one gave ", times, " times what was expected")));
        // Where the values bend down all along the step, how much it gives cannot be said: that is tried.
        const bool is_open = probed && *probed >= most_credit;
        const double floor =
            std::max(0.1 * state_.problem.optimize.objective_tolerance * std::max(std::abs(now), gained),
                     is_open ? 0 : least * price(plan));
        refining_is_idle_ = rule == SplitRule::sensitivity && hessian_.size() > 0 && times * plan.chosen <= floor;
        if (refining_is_idle_) return false;
        expected_of_level_ = plan.chosen + still_expected_;
        front = plan.front;
        return true;
    }

    /// Many variables have to promise more than few: each takes its share of the search. Not where this level can do
    /// no more for noise: larger steps, which only finer patches still have, are above it.
    double price(const RefinementPlan& plan) const {
        if (is_in_noise_) return 1;
        return std::max(1.0, (plan.variables_after - plan.variables_before) / variables_at_price);
    }

    /// The metric is stiffer on details than objectives are, so promises are too small. How much, the curvature along
    /// the promised step tells: the best on that line against what the metric expects.
    std::optional<double> probe(const Eigen::VectorXd& x, const Outlook& outlook) {
        const auto curvature = state_.evaluator.curvature_along(x, outlook.below.children.space, outlook.step,
                                                                program_.lagrangian_weights());
        if (!curvature) return {};
        return *curvature > 0 ? std::clamp(2 * outlook.decrease / *curvature, 1.0, most_credit) : most_credit;
    }

    /// Where that cannot be known, the level tells that the last refinement made.
    double credit() const {
        const double gained = std::abs(state_.result.levels.back().objective_start - state_.level_best_objective);
        return expected_of_level_ > 0 && std::isfinite(gained)
                   ? std::clamp(gained / expected_of_level_, 1.0, most_credit)
                   : 1;
    }

    MinimizeOptions options_of_level(bool first, bool last) {
        const OptimizeOptions& options = state_.problem.optimize;
        MinimizeOptions how;
        // Random and global searches belong where there are few variables.
        how.method = first || !method_facts(options.method).is_global ? options.method : Method::slsqp;
        how.starts = first ? options.starts : 1;
        how.seed = options.seed;
        how.objective_tolerance = options.objective_tolerance;
        // An objective that goes to zero, like a distance, is measured by what has been gained.
        const double gained = std::abs(state_.result.objective_start - state_.result.objective);
        if (std::isfinite(gained)) how.objective_scale = 1e-3 * gained;
        how.step_tolerance = options.step_tolerance;
        how.constraint_tolerance = options.constraint_tolerance;
        how.max_evaluations = std::max(1, state_.evaluations_left() / (last ? 1 : state_.levels_left() + 1));
        how.max_seconds = state_.limits().seconds > 0 ? std::max(state_.seconds_left(), 1e-9) : 0;
        how.clock = [&] { return state_.elapsed(); };
        how.confirm = last;
        how.first_step = first_step_;
        if (!last) how.max_shrinks = how.max_failures = failures_before_refining;
        how.on_event = [&](const std::string& words) { state_.note(text("level ", state_.space.level, ": ", words)); };
        return how;
    }

    /// The first level, one below another, the present one once more, or to its end because no finer one comes.
    enum class Entry { first, refined, again, finished };

    MinimizeResult run_level(const Eigen::VectorXd& start, Entry entry) {
        const bool last = entry == Entry::finished || state_.levels_left() == 0;
        const Eigen::VectorXd weight_before = program_.weight();
        NonlinearProgram program = program_.enter(start);
        const LevelStartHessian known = state_.problem.optimize.level_start;
        if (known == LevelStartHessian::diagonal)
            program.metric = Eigen::MatrixXd::Identity(start.size(), start.size());  // y is scaled by the diagonal
        const bool is_same = entry == Entry::again || entry == Entry::finished;
        const Eigen::MatrixXd inherits =
            is_same ? Eigen::MatrixXd::Identity(start.size(), start.size()) : state_.prolongation;
        if (known == LevelStartHessian::carried && hessian_.size() > 0 && inherits.cols() == hessian_.cols()) {
            const Eigen::MatrixXd P =
                program_.weight().asDiagonal() * inherits * weight_before.cwiseInverse().asDiagonal();
            program.hessian = carried_hessian(hessian_, P, program.metric, curvature_ / probed_);
            if (program.differences && program.differences->objective)
                program.start_gradient = inherited_gradient(parent_, doubt_, P, program.metric);
            if (!is_same) program.guessed = carried_hessian(0 * hessian_, P, program.metric, curvature_ / probed_);
        }
        MinimizeOptions how = options_of_level(entry == Entry::first, last);
        // The rule says when to refine: on the last level only convergence and the budget end the search. A global
        // search makes its progress in leaps.
        const bool watched = !last && how.starts == 1 && !method_facts(how.method).is_global;
        // Without gradients so many evaluations say of one point what one with a gradient says.
        const bool sees_values_only = !method_facts(how.method).needs_gradients;
        ProgressWatch watch(watched ? state_.problem.optimize.progress_below : 0,
                            sees_values_only ? static_cast<int>(start.size()) : 0);
        how.on_step = [&](const MinimizeStep& step) {
            const bool slackened = watch.slackened(step.merit, step.violation);
            return !(slackened && state_.run_best.feasible);  // not before there is something to refine
        };
        // Once the details below promise more than this level, it has done its part; where only the few that promise
        // most come, already a tenth: the metric is stiffer on details than objectives are, so that promises are too
        // small.
        const SplitRule split = state_.rest->parameters.split;
        const double outgrown = split == SplitRule::tree ? 1 : 10;
        std::optional<Prospect> below;
        if (watched && state_.problem.optimize.progress_below > 0 && split != SplitRule::gradient &&
            program_.gives_lagrangian())
            below = prospect(state_.space, start);
        if (below)
            how.on_model = [&](double expected, const Eigen::MatrixXd& hessian) {
                still_expected_ = expected;
                const ShellSensitivities lagrangian = program_.lagrangian();
                const DesignFacts facts{state_.space, program_.known().x, lagrangian,
                                        shape_curvature(hessian, program.metric), program_.known().dJ_dv};
                return outgrown * promised_decrease(facts, *below) <= expected;
            };
        const int evaluations_before = state_.result.evaluations;
        const int finer = static_cast<int>(start.size()) * parts_of_a_patch;
        if (!below && watched && state_.problem.optimize.progress_below > 0 && !sees_values_only)
            how.on_model = [&](double expected, const Eigen::MatrixXd&) {
                const double gained =
                    std::abs(state_.result.levels.back().objective_start - state_.level_best_objective);
                const int spent = state_.result.evaluations - evaluations_before;
                return !(expected <= done_by_differences * gained || spent > patience_by_differences * finer);
            };
        still_expected_ = 0;
        MinimizeResult result = minimize(program, how);
        if (result.stop == MinimizeStop::converged) still_expected_ = 0;
        hessian_ = result.hessian;
        parent_ = result.best;
        doubt_ = result.doubt;
        curvature_ = hessian_.size() > 0 ? shape_curvature(hessian_, program.metric) : 1;
        // Finer details move the shape by less than what they are details of.
        if (sees_values_only && result.best.failure.empty()) {
            const Eigen::VectorXd moved = result.x - program.start;
            const double length = std::sqrt(moved.dot(program.metric * moved));
            if (length > 0) first_step_ = std::clamp(0.5 * length, 0.02, how.first_step);
        }
        result.x = program_.unscaled(result.x);
        // Points of differences are no steps of the search, but the best of all is what the next level inherits.
        if (state_.level_best_x.size() == result.x.size()) result.x = state_.level_best_x;
        // What was too far on this level is too far on the next, and what was not is not.
        if (result.radius > 0) first_step_ = std::clamp((result.failures > 0 ? 2 : 1) * result.radius, 0.05, 2.0);
        return result;
    }

    /// What details of the shape are weighed with; own variables may be curved quite differently.
    double shape_curvature(const Eigen::MatrixXd& hessian, const Eigen::MatrixXd& metric) const {
        const int n = state_.space.num_shape();
        return n > 0 ? mean_curvature(hessian.topLeftCorner(n, n), metric.topLeftCorner(n, n)) : 1;
    }

    RunState state_;
    LevelProgram program_;
    Eigen::MatrixXd hessian_;  ///< at the end of the level, in y; empty: not known
    Sample parent_;            ///< best of the level, its gradient in y
    Eigen::MatrixXd doubt_;    ///< of that gradient
    double curvature_ = 1, first_step_ = 0.5;
    double probed_ = 1;             ///< how much softer the details of the next level are than the metric says
    double still_expected_ = 0;     ///< decrease that the level's model saw ahead at its end
    double expected_of_level_ = 0;  ///< by its refinement and the level above; 0: the first level
    bool refining_is_idle_ = false, is_in_noise_ = false;
};

}  // namespace

RunResult optimize(const Problem& problem, const RunEvents& events, Journal* journal) {
    return Optimization(problem, events, journal).run();
}

}  // namespace strake
