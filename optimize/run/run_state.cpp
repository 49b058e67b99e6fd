#include "optimize/run/run_state.hpp"

#include "core/error.hpp"
#include "optimize/run/run_verdict.hpp"
#include "optimize/run/stored_design.hpp"
#include "optimize/space/design_levels.hpp"
#include "optimize/space/parameters.hpp"
#include "optimize/space/refinement.hpp"
#include "optimize/space/scaling.hpp"

namespace strake {
namespace {

/// So that inheritance and level numbers need no special case: a tree that ends at level 0 is optimized on it.
/// Displacement fields are level 0 by themselves; cores of strain variables begin at level 1.
int first_level_of(const PatchHierarchy& tree, const Parameters& parameters) {
    if (tree.levels.empty()) throw InvalidInput("the patch tree is empty");
    const auto& kinds = parameters.kinds;
    const bool has_cores = std::find(kinds.begin(), kinds.end(), VariableKind::strain) != kinds.end();
    return tree.levels.size() > 1 && (!parameters.fields || has_cores) ? 1 : 0;
}

}  // namespace

RunState::RunState(const Problem& p, const RunEvents& e, const std::vector<std::string>& differentiated,
                   Journal* journal, double energy_share, bool takes_single_patches)
    : problem(p),
      events(e),
      rest(rest_facts(p, energy_share, takes_single_patches)),
      evaluator(p, rest, differentiated),
      journal_(journal),
      replayed_(journal ? static_cast<int>(journal->evaluations().size()) : 0) {
    evaluator.keep_calls(journal, e.stop_wanted);
    rest->cache->stop_wanted = e.stop_wanted;
    if (p.optimize.max_evaluations < 1)
        throw InvalidInput(text("max_evaluations = ", p.optimize.max_evaluations, " must be >= 1"));
    result.names = evaluator.names();
    for (const auto* list : {&rest->setup.warnings, &rest->notes})
        for (const std::string& words : *list) note(words);
}

ShapeEvaluation RunState::evaluate(const Eigen::VectorXd& x) {
    if (events.stop_wanted && events.stop_wanted()) interrupt();
    const auto begin = std::chrono::steady_clock::now();
    ++result.evaluations;
    check_design(x);
    ShapeEvaluation evaluation;
    try {
        with_unfinished_calls([&] { evaluation = evaluator.evaluate(x, result.evaluations); });
    } catch (const Interrupted&) {
        --result.evaluations;  // it has no end
        throw;
    } catch (const Awaited&) {
        --result.evaluations;
        throw;
    }
    last_seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return evaluation;
}

void RunState::run(const std::function<void()>& search) {
    try {
        search();
    } catch (const Interrupted&) {
        leave_level();
        conclude_interrupted(result);
    } catch (const Awaited&) {
        leave_level();
        conclude_waiting(result);
    }
}

void RunState::interrupt() {
    with_unfinished_calls([&] { evaluator.interrupt(); });
    throw Interrupted{};
}

void RunState::differentiate(ShapeEvaluation& evaluation) {
    with_unfinished_calls([&] { evaluator.differentiate(evaluation); });
}

void RunState::tell_sensitivities(const ShapeEvaluation& evaluation, const Points& dJ_dv) const {
    if (events.sensitivities && result.best_evaluation == result.evaluations)
        events.sensitivities(result.evaluations, evaluation.vertices, dJ_dv);
}

void RunState::with_unfinished_calls(const std::function<void()>& ask) {
    try {
        ask();
    } catch (const Interrupted& interrupted) {
        result.pending = interrupted.pending;
        throw;
    } catch (const Awaited& awaited) {
        result.awaited = awaited.calls;
        throw;
    }
}

void RunState::check_inheritance(const ShapeEvaluation& evaluation, double objective) {
    LevelSummary& summary = result.levels.back();
    if (level_best_vertices.rows() > 0 && evaluation.vertices.rows() > 0) {
        summary.inherited_shape_change =
            std::sqrt((evaluation.vertices - level_best_vertices).rowwise().squaredNorm().maxCoeff()) / rest->diagonal;
        const double before = level_best_objective;
        summary.inherited_objective_change =
            std::abs(objective - before) / std::max(std::abs(before), std::numeric_limits<double>::min());
        if (summary.inherited_shape_change > inheritance_tolerance)
            note(text("level ", summary.level, " starts ", summary.inherited_shape_change,
                      " diagonals off the shape that it inherits (limit ", inheritance_tolerance, ")"));
    }
    summary.objective_start = objective;
}

bool RunState::record(const Eigen::VectorXd& x, const ShapeEvaluation& evaluation, double objective, const Rank& rank,
                      const Points& dJ_dv) {
    const bool ok = evaluation.status == EvaluationStatus::ok;
    if (!level_has_started_) check_inheritance(evaluation, objective);
    const bool is_level_best = ok && (!level_has_started_ || (!is_trying && rank.better_than(level_best)));
    level_has_started_ = true;
    EvaluationRecord record;
    record.evaluation = result.evaluations;
    record.level = space.level;
    record.status = to_string(evaluation.status);
    record.reason = evaluation.reason;
    record.max_displacement = evaluation.max_displacement;
    record.seconds = last_seconds_;
    record.is_taken_over = evaluation.is_taken_over;
    record.parameters = recorded_values(space, x);
    if (ok) {
        record.objective = objective;
        record.values = evaluation.values;
        record.max_violation = rank.violation;
        record.accepted = result.best_evaluation == 0 || rank.better_than(run_best);
    }
    keep(x, evaluation, record);
    for (const std::string& words : evaluation.remarks) note(text("evaluation ", record.evaluation, ": ", words));
    if (is_level_best) {
        level_best = rank;
        level_best_evaluation = record.evaluation;
        level_best_vertices = evaluation.vertices;
        level_best_x = x;
        level_best_objective = objective;
        evaluator.accept();
    }
    if (record.accepted) {
        if (result.best_evaluation == 0) {
            result.objective_start = objective;
            start_is_feasible = rank.feasible;
            result.values_start = evaluation.values;
            const std::vector<double> at_rest = values_at_rest(evaluation.values);
            for (std::size_t i = 0; i < at_rest.size(); ++i) at_rest_.emplace_back(result.names[i], at_rest[i]);
        }
        run_best = rank;
        result.best_evaluation = record.evaluation;
        result.objective = objective;
        result.values = evaluation.values;
        result.max_violation = rank.violation;
        result.vertices = evaluation.vertices;
        result.space = space;
        result.x = x;
        result.level = space.level;
    }
    record.level_best = is_level_best;
    if (events.evaluation) events.evaluation(record);
    if (record.accepted && events.accepted)
        events.accepted({record, space, x, evaluation.vertices, dJ_dv, evaluator.poses(), at_rest_});
    return is_level_best;
}

bool RunState::can_refine() const {
    if (rest->parameters.split == SplitRule::tree && follows_tree_) return levels_left() > 0;
    return has_finer(space);
}

int RunState::levels_left() const {
    if (levels_below) return *levels_below;
    if (rest->parameters.kinds.empty() && !has_finer(space)) return 0;  // finer patches of what stays as it is
    const std::size_t levels = std::max(rest->tree->levels.size(), rest->parameters.field_steps.size());
    const int below = static_cast<int>(levels) - 1 - space.level;
    if (rest->parameters.split == SplitRule::tree && follows_tree_) return below;
    // Fronts may go on longer than the tree is deep.
    return can_refine() ? std::max(below, 1) : 0;
}

Eigen::VectorXd RunState::first_level() {
    if (!problem.start) {
        space = design_space(rest, first_level_of(*rest->tree, rest->parameters));
        evaluator.enter(space);
        return Eigen::VectorXd::Zero(space.size());
    }
    const StoredDesign& design = *problem.start;
    InheritedSpace inherited = enter_stored(evaluator, rest, design);
    space = std::move(inherited.space);
    follows_tree_ = design.level < static_cast<int>(rest->tree->levels.size()) &&
                    rest->tree->levels[design.level].label == space.patches().label;
    level_best_vertices = design.vertices;
    note(text("starts from evaluation ", design.evaluation, " of the run before, objective there ", design.objective));
    return inherited.x;
}

std::vector<double> RunState::values_at_rest(const std::vector<double>& first) const {
    std::vector<double> values = first;
    if (!problem.start) return values;
    for (std::size_t i = 0; i < values.size(); ++i)
        for (const auto& [name, value] : problem.start->at_rest)
            if (name == result.names[i]) values[i] = value;
    return values;
}

Eigen::VectorXd RunState::next_level(const Eigen::VectorXd& x, const LevelSet* next) {
    Eigen::VectorXd start;
    if (result.levels.empty()) {
        start = first_level();
    } else {
        std::optional<LevelSet> all;
        if (!next && !follows_tree_) all = refined_everywhere(space);
        if (all) next = &*all;
        InheritedSpace inherited = next ? refine(space, x, *next) : refine(space, x);
        space = std::move(inherited.space);
        start = std::move(inherited.x);
        prolongation = std::move(inherited.prolongation);
    }
    return enter_level(std::move(start));
}

Eigen::VectorXd RunState::first_level_again() {
    const LevelSet first = level_set(*rest, first_level_of(*rest->tree, rest->parameters));
    space = make_space(rest, space.level + 1, first, nullptr);
    prolongation.resize(0, 0);
    level_best_vertices.resize(0, 3);
    return enter_level(Eigen::VectorXd::Zero(space.size()));
}

Eigen::VectorXd RunState::enter_level(Eigen::VectorXd start) {
    range_ratio = begins_with_wide_ranges ? widen_to_limit(space) : 1;
    if (!result.levels.empty())
        evaluator.enter(space);
    else
        evaluator.set_ranges(space);
    level_limits_ = limits();
    LevelSummary summary;
    summary.level = space.level;
    summary.patches = static_cast<int>(space.patches().patches.size());
    summary.variables = space.size();
    for (const DependentVariable& other : space.dependent) summary.dependent.push_back(other.variable.name);
    summary.weak = space.weak;
    summary.nearly_fixed = space.nearly_fixed;
    summary.evaluations = result.evaluations;  // until end_level: those before
    result.levels.push_back(summary);
    level_has_started_ = false;
    level_best_x.resize(0);
    for (const std::string& words : space.notes) note(text("level ", space.level, ": ", words));
    if (events.level) events.level({space, start});
    return start;
}

void RunState::begin_level_again() {
    level_limits_ = limits();
    evaluator.enter(space);
}

int RunState::evaluations_of_level() const { return result.evaluations - result.levels.back().evaluations; }

void RunState::complete_summary(const std::string& why) {
    LevelSummary& summary = result.levels.back();
    summary.evaluations = evaluations_of_level();
    summary.stop = why;
    summary.objective_end = level_best_objective;
}

void RunState::end_level(const std::string& why) {
    complete_summary(why);
    if (events.level_end) events.level_end(result.levels.back());
}

void RunState::leave_level() {
    if (result.levels.empty() || !result.levels.back().stop.empty()) return;
    complete_summary("it has not ended");
    if (!level_has_started_) result.levels.back().objective_start = std::numeric_limits<double>::quiet_NaN();
}

bool ProgressWatch::slackened(const std::optional<Seen>& last, double penalty) {
    // Reaching feasibility starts a new count: the objective may have to rise on the way there.
    if (!near_feasible_ && last && last->largest_violation < 1e-3) seen_.clear(), near_feasible_ = true;
    seen_.push_back(last);
    const int count = static_cast<int>(seen_.size());
    if (fraction_ <= 0 || count < 2 * window_) return false;
    std::vector<double> merit;  // the lowest so far; infinite before the first value
    double lowest = std::numeric_limits<double>::infinity();
    for (const std::optional<Seen>& seen : seen_) {
        if (seen) lowest = std::min(lowest, seen->objective + penalty * seen->total_violation);
        merit.push_back(lowest);
    }
    const auto gain = [&](int i) { return std::isfinite(merit[i - window_]) ? merit[i - window_] - merit[i] : 0; };
    double best_gain = 0;
    for (int i = window_; i < count; ++i) best_gain = std::max(best_gain, gain(i));
    if (best_gain == 0) return count >= 4 * window_;  // steps are still being shortened
    return gain(count - 1) <= fraction_ * best_gain;
}

}  // namespace strake
