#include "optimize/run/coarse_to_fine.hpp"

#include "core/error.hpp"
#include "optimize/nlp/program/first_order.hpp"
#include "optimize/nlp/program/methods.hpp"
#include "optimize/nlp/program/partial_gradient.hpp"
#include "optimize/run/known_designs.hpp"
#include "optimize/run/level_order.hpp"
#include "optimize/run/level_program.hpp"
#include "optimize/run/method_choice.hpp"
#include "optimize/run/refinement_choice.hpp"
#include "optimize/run/run_verdict.hpp"
#include "optimize/run/value_trial.hpp"
#include "optimize/run/wave_watch.hpp"
#include "optimize/space/motion_limit.hpp"
#include "optimize/space/refinement.hpp"
#include "optimize/space/scaling.hpp"

#include <algorithm>
#include <utility>

namespace strake {
namespace {

constexpr double first_step_of_run = 0.5;    ///< in the metric
constexpr int failures_before_refining = 4;  ///< the last level the minimizer's own limits hold
/// Of the first fields' expected decrease: where the gradient of the start promises more by others, the first step
/// takes those, too.
constexpr double outgrown_at_start = 1000;
/// A gradient by differences costs an evaluation for each variable: coarse levels are finished first, and left once
/// their model sees no more than this share of what they have gained.
constexpr double done_by_differences = 0.05;
/// Nor does one cost more than so many gradients of the next.
constexpr double patience_by_differences = 2;
/// Where trials of a few directions tell what else there is, a level is left once the step by a gradient gives no more
/// than this share of what the level has gained; the trial may find that it is to go on.
constexpr double early_by_differences = 0.3;
constexpr int parts_of_a_patch = 4;
/// Share of the motion limit in use below which the ranges of variables become wider. Above, other optima are as likely
/// as better ones (next to buckling, and where the mesh decides).
constexpr double idle_limit = 0.3;
constexpr double full_limit = 0.97;   ///< they go on to become wider up to here
constexpr double beyond_limit = 1.2;  ///< of it that wider ranges are to reach: then the limit stops the search
constexpr double min_widening = 1.2, max_widening = 4;  ///< times: the first order is only good for so much
constexpr int max_widenings = 6;                        ///< of a level
constexpr double max_range_ratio = 16;  ///< times the longest step, where ranges begin wide: more was not faster

class Optimization {
public:
    Optimization(const Problem& problem, const RunEvents& events, Journal* journal)
        : state_(problem, events, LevelProgram::differentiated_names(problem), journal, energy_share(problem),
                 takes_single_patches(problem)),
          program_(state_),
          budget_(state_, program_),
          order_(state_, budget_),
          waves_(state_, program_) {
        state_.evaluator.take_over_values();
        state_.begins_with_wide_ranges = begins_with_wide_ranges(problem);
    }

    RunResult run() {
        state_.run([this] { walk(); });
        if (!state_.result.cheap_model.empty()) state_.result.reason += text("; ", state_.result.cheap_model);
        return state_.result;
    }

private:
    void walk() {
        state_.evaluator.limit_motion();
        note_short_budget();
        Eigen::VectorXd x;
        MinimizeResult level;
        level.stop = MinimizeStop::converged;
        bool any = false;
        for (std::optional<LevelSet> next;;) {
            const bool is_first = !any || waves_.goes_back();
            x = enter_level(x, next);
            if (state_.space.size() == 0) {
                hessian_.resize(0, 0);
            } else {
                level = search_level(x, is_first ? Entry::first : Entry::refined);
                any = true;
                x = level.x;
                if (goes_back(level)) continue;
            }
            bool refines = finish_or_refine(x, level, next);
            while (!refines && ended_at_limit(level) && state_.limits_were_raised()) {
                level = run_again(x);
                if (!state_.problem.optimize.begins_with_narrow_ranges) level = in_wider_ranges(std::move(level));
                x = level.x;
                refines = finish_or_refine(x, level, next);
            }
            state_.end_level(state_.space.size() == 0 ? "no variable of this level moves anything"
                                                      : level_words(level));
            if (!refines) break;
            if (is_trial_wanted_) choose_by_trial(x, next);
        }
        if (!any)
            throw InvalidInput("nothing to optimize: no variable of any level moves anything; is all of it fixed?");
        state_.result.level = state_.space.level;
        state_.result.motion = program_.motion_at_end(level.best);
        conclude_run(state_.result,
                     {level, program_.rows(), program_.quantity_failed(), program_.last_failed_in_quantity(),
                      state_.run_best.feasible, order_.has_finer_below(), refining_is_idle_, state_.problem.objective,
                      state_.problem.maximize, state_.limits().evaluations, state_.level_best_evaluation});
    }

    /// The level below the one that the run has left at x, or where it goes back the first one again.
    Eigen::VectorXd enter_level(const Eigen::VectorXd& x, const std::optional<LevelSet>& next) {
        const Eigen::VectorXd start =
            waves_.goes_back() ? state_.first_level_again() : state_.next_level(x, next ? &*next : nullptr);
        program_.carry_designs(x, start, state_.prolongation);
        waves_.enter_level();
        below_.reset();
        if (state_.result.levels.size() == 1 && state_.problem.table) program_.learn(*state_.problem.table, start);
        return start;
    }

    /// The level ends for the first one again: what has been learned is of other minima.
    bool goes_back(const MinimizeResult& level) {
        if (level.stop != MinimizeStop::wavy) return false;
        state_.end_level(level_words(level));
        waves_.go_back();
        hessian_.resize(0, 0);
        curvature_ = 1, first_step_ = step_of_other_group_ = first_step_of_run, largest_gradient_ = 0;
        still_expected_ = forecast_of_level_ = forecast_of_next_ = expected_of_level_ = 0;
        return true;
    }

    /// The first batch of a search by models only looks around, unless designs are known.
    void note_short_budget() const {
        const OptimizeOptions& options = state_.problem.optimize;
        const int budget = state_.limits().evaluations;
        if (options.method != Method::model || budget > 1 + options.batch || state_.problem.table) return;
        state_.note(text("method model learns from whole batches, and a budget of ", budget,
                         " evaluations ends with the first (the start, and a batch of ", options.batch,
                         "): raise optimize.budget.evaluations to ", 1 + 2 * options.batch,
                         " or more, or lower optimize.batch to ", std::max(1, (budget - 1) / 2)));
    }

    /// True: on to this level. A level that was left for details that turn out to be worth nothing is finished first.
    bool finish_or_refine(Eigen::VectorXd& x, MinimizeResult& level, std::optional<LevelSet>& next) {
        is_in_noise_ = level.stop == MinimizeStop::roundoff;
        if (is_last_ || !may_continue(state_, level) || !state_.can_refine()) return false;
        if (choose_next(x, next)) return true;
        const bool order_ends = !state_.can_refine();
        const bool was_left = level.stop == MinimizeStop::stopped || level.stop == MinimizeStop::outpaced ||
                              (order_ends && level.stop == MinimizeStop::no_valid_step);
        if (!(refining_is_idle_ || order_ends) || !(was_left || level.stop == MinimizeStop::evaluations)) return false;
        level = run_level(x, Entry::finished);
        x = level.x;
        is_in_noise_ = level.stop == MinimizeStop::roundoff;
        return may_continue(state_, level) &&
               choose_next(x, next);  // it may have come to where details are worth something
    }

    static bool ended_at_limit(const MinimizeResult& level) {
        return level.stop == MinimizeStop::evaluations || level.stop == MinimizeStop::time;
    }

    /// The range of a variable is the motion limit that it may use by itself; together, variables may move the surface
    /// far less. Where a level has converged at such ranges while no point is near its limit, they become wider.
    bool widens_ranges(const Eigen::VectorXd& x, const MinimizeResult& level) {
        const OptimizeOptions& options = state_.problem.optimize;
        const Parameters& p = state_.rest->parameters;
        const bool may = level.stop == MinimizeStop::converged && options.method == Method::sqp &&
                         !options.keeps_ranges && limits_motion(p) && !p.limits_variables &&
                         may_continue(state_, level);
        if (!may || level.active_bounds == 0) return false;
        const double used = program_.motion_at_end(level.best).used;
        if (!(used < (widened_ > 1 ? full_limit : idle_limit))) return false;
        const double times = std::clamp(beyond_limit / used, min_widening, max_widening);
        if (!widen_ranges(state_.space, x, times)) return false;
        widened_ *= times;
        first_step_ = std::min(times * first_step_, max_step());
        state_.note(text("level ", state_.space.level, ": converged at the variables' own ranges with ",
                         std::round(1000 * used) / 10, " % of the motion limit in use; the ranges become ",
                         std::round(10 * times) / 10, " times as wide"));
        return true;
    }

    /// The first level, one below another, the present one once more, or to its end because no finer one comes.
    enum class Entry { first, refined, again, finished };

    MinimizeResult search_level(const Eigen::VectorXd& start, Entry entry) {
        return in_wider_ranges(run_level(start, entry));
    }

    MinimizeResult in_wider_ranges(MinimizeResult level) {
        for (int k = 0; k < max_widenings && widens_ranges(level.x, level); ++k) level = run_again(level.x);
        return level;
    }

    /// The level once more from its best design, which is not paid again, with wider ranges or under the larger limits
    /// of a resumed run.
    MinimizeResult run_again(const Eigen::VectorXd& x) {
        state_.begin_level_again();
        return run_level(x, Entry::again);
    }

    /// The metric, in which 1 is a reasonable step, takes what one variable may do alone for reasonable.
    double max_step() const {
        const bool is_model = state_.problem.optimize.method == Method::model;
        const double ratio = is_model ? 1 : std::min(state_.range_ratio, max_range_ratio);
        return widened_ * ratio * MinimizeOptions().max_step;
    }

    /// By `LevelOrder`, else as the tree has it. False: that order ends.
    bool choose_in_order(std::optional<LevelSet>& next) {
        if ((next = order_.advance())) keep_step_of_group(*next);
        if (next || !state_.can_refine()) return next.has_value();
        if ((next = budget_.patches_alone()) && !state_.space.fields.numbers.empty())
            state_.note(text("level ", state_.space.level + 1, ": there are no finer fields, those of level ",
                             state_.space.level, " stay as they are, and patches alone are searched"));
        return true;
    }
    /// What the next level is made of where the run chooses it. False: refining is expected to gain nothing.
    bool choose_next(const Eigen::VectorXd& x, std::optional<LevelSet>& next) {
        next.reset(), probed_ = 1;
        forecast_of_next_ = forecast_of_details();
        is_trial_wanted_ = false;
        const SplitRule rule = state_.rest->parameters.split;
        if (rule == SplitRule::tree) return choose_in_order(next);
        if (may_try()) return is_trial_wanted_ = true;
        if (program_.has_choice() && state_.space.size() > 0 && !budget_.can_pay_trial()) {
            state_.note("refinement: too few evaluations are left for it");
            refining_is_idle_ = true;
            return false;
        }
        if (state_.space.size() == 0 || !program_.has_lagrangian()) {
            next = refined_everywhere(state_.space);
            const auto more = next->fields.numbers.size() - state_.space.fields.numbers.size();
            state_.note(text("refinement: there are no sensitivities to choose by, every patch is split",
                             more > 0 ? text(", and the next ", more, " fields are taken") : ""));
            return true;
        }
        const ShellSensitivities lagrangian = program_.lagrangian();
        const DesignFacts facts{state_.space, x, lagrangian, curvature_, program_.known().dJ_dv};
        const RefinementScale scale(state_, program_, model_correction(), hessian_.size() > 0, is_in_noise_);
        const std::optional<RefinementChoice> choice = scale.choose(facts);
        refining_is_idle_ = !choice;  // finer patches that are all held, or do the same
        if (!choice) {
            state_.note("refinement: no patch has finer parts");
            return false;
        }
        state_.note(text("refinement: ", choice->words()));
        probed_ = choice->probed.value_or(1);
        refining_is_idle_ = choice->is_idle;
        if (refining_is_idle_) return false;
        expected_of_level_ = choice->plan.chosen + still_expected_;
        next = choice->plan.next;
        return true;
    }

    /// What was too far for fields says nothing of patches, nor of fields what was for patches.
    void keep_step_of_group(const LevelSet& next) {
        const bool had_fields = !state_.space.fields.numbers.empty(), has_fields = !next.fields.numbers.empty();
        if (had_fields != has_fields) std::swap(first_step_, step_of_other_group_);
    }

    /// Values alone, and fields beside patches to choose from.
    bool may_try() const {
        const bool has_multipliers = last_.gradient.size() > 0 || state_.problem.constraints.empty();
        return program_.has_choice() && has_multipliers && state_.space.size() > 0 && budget_.can_pay_trial();
    }
    void choose_by_trial(const Eigen::VectorXd& x, std::optional<LevelSet>& next) {
        const double gained = std::abs(state_.result.objective_start - state_.level_best_objective);
        const double least = state_.problem.optimize.min_expected_gain * gained;
        const TrialResult found =
            next_by_values(state_, program_, {x, weight_, last_y_, last_, first_step_}, curvature_, least);
        next = found.next;
        is_last_ = found.is_idle || (found.stays && has_converged_);
        has_stayed_ = found.stays;
    }

    /// What the last refinement gained against what it was expected to.
    double model_correction() const {
        const double gained = std::abs(state_.result.levels.back().objective_start - state_.level_best_objective);
        return expected_of_level_ > 0 && std::isfinite(gained)
                   ? std::clamp(gained / expected_of_level_, 1.0, max_correction)
                   : 1;
    }

    MinimizeOptions options_of_level(bool first, bool last) {
        const OptimizeOptions& options = state_.problem.optimize;
        MinimizeOptions how = options_of_searches(options);
        // Random and global searches belong where there are few variables.
        how.method = first || !method_facts(options.method).is_global ? options.method : Method::sqp;
        if (!last && !has_stayed_ && budget_.begins_by_models()) {
            how.method = Method::model;
            how.tries_in_order = !options.descends_as_before;
            // A run that has the evaluations for differences learns more from each where fewer are asked at a time.
            if (!options.descends_as_before) how.batch = std::max(1, options.batch / 2);
        }
        if (!options.limits_by_models && state_.space.num_shape() > 0)
            for (int j = state_.space.num_shape(); j < state_.space.size(); ++j) how.first_alone.push_back(j);
        if (first && options.method == Method::model && how.first_alone.empty()) {
            how.tries_in_order = is_long_with_fields(state_.problem, state_.limits().evaluations);
            how.begins_with_few = budget_.begins_quickly();
            if (how.begins_with_few) how.batch = batch_of_first_fields(options);
        }
        how.starts = first ? options.starts : 1;
        how.seed = options.seed;
        const double gained = std::abs(state_.result.objective_start - state_.result.objective);
        if (std::isfinite(gained)) how.gained_before = gained;
        how.largest_gradient = largest_gradient_;
        how.limit_follows_variables = !last;
        how.scope = text(" of level ", state_.space.level);
        how.evaluations_before = spent_;
        how.failures_before = failed_;
        // Where trials choose, levels are left by what they gain.
        how.max_evaluations = last                          ? state_.evaluations_left()
                              : how.method == Method::model ? order_.evaluations().value_or(budget_.by_models())
                              : how.method == Method::sqp && may_try() ? state_.evaluations_left()
                                                                       : budget_.by_differences();
        how.limit_while_gaining = order_.limit_while_gaining();
        how.max_seconds = state_.limits().seconds > 0 ? std::max(state_.seconds_left(), 1e-9) : 0;
        how.clock = [&] { return state_.elapsed(); };
        how.confirm = last;
        how.first_step = first_step_;
        how.max_step = max_step();
        if (!last) how.max_shrinks = how.max_failures = failures_before_refining;
        how.on_event = [&](const std::string& words) { state_.note(text("level ", state_.space.level, ": ", words)); };
        return how;
    }

    MinimizeResult run_level(const Eigen::VectorXd& start, Entry entry) {
        const bool begins = entry == Entry::first || entry == Entry::refined;
        if (begins) {
            widened_ = 1;
            spent_ = failed_ = 0;
            forecast_of_level_ = std::exchange(forecast_of_next_, 0);
            first_step_ = std::min(first_step_, max_step());
        }
        const bool last = entry == Entry::finished || is_last_ || state_.levels_left() == 0;
        NonlinearProgram program = program_.enter(start, widened_ > 1);
        carry_over(program, weight_, entry == Entry::again || entry == Entry::finished);
        MinimizeOptions how = options_of_level(entry == Entry::first, last);
        // The rule says when to refine: on the last level only convergence and the budget end the search. A global
        // search makes its progress in leaps.
        const bool watched = !last && how.starts == 1 && !method_facts(how.method).is_global;
        // Without gradients so many evaluations say of one point what one with a gradient says.
        const bool sees_values_only = !method_facts(how.method).needs_gradients;
        ProgressWatch watch(watched ? state_.problem.optimize.progress_below : 0,
                            sees_values_only ? static_cast<int>(start.size()) : 0);
        how.on_step = [&](const MinimizeStep& step) {
            if (waves_.is_patient()) return true;
            std::optional<ProgressWatch::Seen> seen;
            if (step.evaluation.failure.empty())
                seen = {step.evaluation.objective, total_violation(program, step.evaluation.constraints),
                        step.violation};
            const bool slackened = watch.slackened(seen, step.penalty);
            return !(slackened && state_.run_best.feasible);  // not before there is something to refine
        };
        const bool may_leave = watched && state_.problem.optimize.progress_below > 0;
        below_ = may_leave && state_.rest->parameters.split != SplitRule::gradient && program_.gives_lagrangian()
                     ? prospect(state_.space, start)
                     : std::nullopt;
        if (below_)
            how.on_model = [&, before = state_.result.evaluations](double expected, const Eigen::MatrixXd& hessian) {
                still_expected_ = expected;
                if (waves_.is_patient()) return true;
                const double kept = kept_of_forecast(state_.result.evaluations - before);
                return is_best_at_this_level(*below_, program, expected / std::max(kept, 1e-9), hessian);
            };
        else if (may_leave && !sees_values_only)
            how.on_model = by_differences_rule(static_cast<int>(start.size()));
        if (may_leave && !sees_values_only && program_.has_choice() && !has_stayed_)
            how.before_differences = leave_early_rule();
        still_expected_ = 0;
        if (begins) how.on_misfit = waves_.on_misfit();
        MinimizeResult result = minimize(program, how);
        if (entry == Entry::first) result = waves_.look_elsewhere(program, how, result);
        spent_ = result.evaluations += spent_;
        failed_ = result.failures += failed_;
        keep_knowledge(program, result, how.first_step, sees_values_only);
        return result;
    }

    /// What the level before has learned of Hessian and gradient.
    void carry_over(NonlinearProgram& program, const Eigen::VectorXd& weight_before, bool is_same_level) const {
        const Eigen::Index size = program.start.size();
        const LevelStartHessian known = state_.problem.optimize.level_start;
        if (known == LevelStartHessian::diagonal)
            program.metric = Eigen::MatrixXd::Identity(size, size);  // y is scaled by the diagonal
        const Eigen::MatrixXd inherits = is_same_level ? Eigen::MatrixXd::Identity(size, size) : state_.prolongation;
        if (known != LevelStartHessian::carried || hessian_.size() == 0 || inherits.cols() != hessian_.cols()) return;
        const Eigen::MatrixXd all =
            program_.weight().asDiagonal() * inherits * weight_before.cwiseInverse().asDiagonal();
        std::vector<Eigen::Index> kept;  // what is frozen now has no column
        for (Eigen::Index j = 0; j < all.cols(); ++j)
            if (!all.col(j).isZero(0)) kept.push_back(j);
        if (kept.empty()) return;
        const Eigen::MatrixXd P = all(Eigen::all, kept), hessian = hessian_(kept, kept);
        program.hessian = carried_hessian(hessian, P, program.metric, curvature_ / probed_);
        if (program.differences && program.differences->objective)
            program.start_gradient = inherited_gradient(reduced(parent_, kept), kept_error(kept), P, program.metric);
        if (!is_same_level) program.guessed = carried_hessian(0 * hessian, P, program.metric, curvature_ / probed_);
    }

    static Evaluation reduced(Evaluation evaluation, const std::vector<Eigen::Index>& kept) {
        if (evaluation.gradient.size() == 0) return evaluation;
        evaluation.gradient = evaluation.gradient(kept).eval();
        evaluation.jacobian = evaluation.jacobian(Eigen::all, kept).eval();
        return evaluation;
    }
    Eigen::MatrixXd kept_error(const std::vector<Eigen::Index>& kept) const {
        return gradient_error_.size() > 0 ? Eigen::MatrixXd(gradient_error_(kept, Eigen::all)) : gradient_error_;
    }

    /// Of what details were expected to gain when the level above was left for them, the share that this one gains.
    /// Where the gradient of an objective grows with fineness (the drag of a wave), finer details always promise more.
    double kept_of_forecast(int evaluations_of_level) const {
        if (state_.problem.optimize.descends_as_before || forecast_of_level_ == 0) return 1;
        const double gained = std::abs(state_.result.levels.back().objective_start - state_.level_best_objective);
        if (gained == 0 && evaluations_of_level >= min_evaluations) return 1;  // it leads nowhere, or is not feasible
        return std::min(1.0, gained / forecast_of_level_);
    }

    /// False: the details below are expected to gain more than this level, it has done its part. Where only the best
    /// few are split, already a tenth: the metric is stiffer on details than objectives are, and underestimates them
    /// (not where patches of all depths are seen, and energies count a share).
    bool is_best_at_this_level(const Prospect& below, const NonlinearProgram& program, double expected,
                               const Eigen::MatrixXd& hessian) {
        const Parameters& p = state_.rest->parameters;
        const FieldSet& present = state_.space.fields;
        const bool begins = state_.result.evaluations <= 1 && !p.offers_fields_by_steps &&
                            offered_fields(p, present).numbers.size() > present.numbers.size();
        const bool by_best_few = p.split != SplitRule::tree, is_exact = state_.rest->takes_single_patches;
        const double outgrown = !by_best_few ? 1 : begins ? outgrown_at_start : is_exact ? 1 : 10;
        return outgrown * forecast_by(below, shape_curvature(hessian, program.metric)) <= expected;
    }

    double forecast_by(const Prospect& below, double curvature) const {
        const ShellSensitivities lagrangian = program_.lagrangian();
        return expected_decrease_of({state_.space, program_.known().x, lagrangian, curvature, program_.known().dJ_dv},
                                    below);
    }
    /// By all details below, at the level's end. 0: not known.
    double forecast_of_details() const {
        return below_ && program_.has_lagrangian() ? forecast_by(*below_, curvature_) : 0;
    }

    /// Without sensitivities to look ahead by: a level ends when its model expects little, or costs too much.
    std::function<bool(double, const Eigen::MatrixXd&)> by_differences_rule(int variables) const {
        const int evaluations_before = state_.result.evaluations, finer = variables * parts_of_a_patch;
        return [=, this](double expected, const Eigen::MatrixXd&) {
            const double gained = std::abs(state_.result.levels.back().objective_start - state_.level_best_objective);
            const int spent = state_.result.evaluations - evaluations_before;
            return !(expected <= done_by_differences * gained || spent > patience_by_differences * finer);
        };
    }

    /// What else there is may gain more than a further gradient: that is tried before it is paid.
    std::function<bool()> leave_early_rule() const {
        std::optional<double> before;
        return [this, before]() mutable {
            const double start = state_.result.levels.back().objective_start, now = state_.level_best_objective;
            const double gained = std::abs(start - now), last_gain = std::abs(before.value_or(start) - now);
            before = now;
            return !(gained > 0 && last_gain <= early_by_differences * gained);
        };
    }

    /// What the next level starts from; sets `result.x` to the design that it inherits, in x.
    void keep_knowledge(const NonlinearProgram& program, MinimizeResult& result, double first_step,
                        bool sees_values_only) {
        has_converged_ = result.stop == MinimizeStop::converged || result.stop == MinimizeStop::roundoff;
        if (result.stop == MinimizeStop::converged) still_expected_ = 0;
        hessian_ = result.hessian;
        largest_gradient_ = result.largest_gradient;
        state_.result.cheap_model = program_.cheap_words(result);
        if (!state_.result.cheap_model.empty())
            state_.note(text("level ", state_.space.level, ": ", state_.result.cheap_model));
        weight_ = program_.weight();
        parent_ = result.best;
        last_y_ = result.last_x;
        last_ = result.last;
        gradient_error_ = result.gradient_error;
        curvature_ = hessian_.size() > 0 ? shape_curvature(hessian_, program.metric) : 1;
        // Finer details move the shape by less than what they are details of.
        if (sees_values_only && result.best.failure.empty()) {
            const Eigen::VectorXd moved = result.x - program.start;
            const double length = std::sqrt(moved.dot(program.metric * moved));
            if (length > 0) first_step_ = std::clamp(0.5 * length, 0.02, first_step);
        }
        result.x = program_.unscaled(result.x);
        // Points of differences are no steps of the search, but the best of all is what the next level inherits.
        if (state_.level_best_x.size() == result.x.size()) result.x = state_.level_best_x;
        // What was too far on this level is too far on the next, and what was not is not.
        if (result.radius > 0)
            first_step_ = std::clamp((result.failures > 0 ? 2 : 1) * result.radius, 0.05, max_step());
    }

    /// What details of the shape are weighed with; parameters may be curved quite differently.
    double shape_curvature(const Eigen::MatrixXd& hessian, const Eigen::MatrixXd& metric) const {
        const int n = state_.space.num_shape();
        return n > 0 ? mean_curvature(hessian.topLeftCorner(n, n), metric.topLeftCorner(n, n)) : 1;
    }

    RunState state_;
    LevelProgram program_;
    LevelBudget budget_;
    LevelOrder order_;
    WaveWatch waves_;
    Eigen::MatrixXd hessian_;         ///< at the end of the level, in y; empty: not known
    Eigen::VectorXd weight_;          ///< y over x
    Eigen::VectorXd last_y_;          ///< the last point of the level that was differentiated
    Evaluation last_;                 ///< there
    Evaluation parent_;               ///< best of the level, its gradient in y
    Eigen::MatrixXd gradient_error_;  ///< of that gradient
    double curvature_ = 1, first_step_ = first_step_of_run, step_of_other_group_ = first_step_of_run,
           largest_gradient_ = 0;
    int spent_ = 0, failed_ = 0;     ///< evaluations of the level's searches before the present one, and failures
    double widened_ = 1;             ///< times the ranges that the level began with
    double probed_ = 1;              ///< how much softer the details of the next level are than the metric says
    double still_expected_ = 0;      ///< decrease that the level's model saw ahead at its end
    std::optional<Prospect> below_;  ///< of the present level; none: it is not left for its details
    double forecast_of_level_ = 0;   ///< of its details, when the level above was left for them; 0: not known
    double forecast_of_next_ = 0;    ///< the same of the level to come
    double expected_of_level_ = 0;   ///< by its refinement and the level above; 0: the first level
    bool refining_is_idle_ = false, is_in_noise_ = false;
    bool is_trial_wanted_ = false;  ///< before the next level
    bool has_converged_ = false;    ///< the last level
    bool has_stayed_ = false;       ///< after a trial, with what was there
    bool is_last_ = false;          ///< the present level goes on to its end
};

RunResult search(const Problem& problem, const RunEvents& events, Journal* journal) {
    if (!problem.optimize.chooses_method) return Optimization(problem, events, journal).run();
    const int budget = journal ? journal->limits_after(0).evaluations : problem.optimize.max_evaluations;
    const MethodChoice choice = choose_method(problem, budget);
    if (choice.words.empty()) return Optimization(problem, events, journal).run();
    if (events.note) events.note(choice.words);
    Problem chosen = problem;
    chosen.optimize.method = choice.method;
    chosen.optimize.finite_differences = choice.method == Method::sqp;
    return Optimization(chosen, events, journal).run();
}

}  // namespace

RunResult optimize(const Problem& problem, const RunEvents& events, Journal* journal) {
    if (!problem.start || !problem.table) return search(problem, events, journal);
    Problem with_known = problem;
    if (journal && !journal->facts().files.contains(known_designs_key))
        with_known.table.reset();  // the run began without them
    else
        answer_start(with_known);
    return search(with_known, events, journal);
}

}  // namespace strake
