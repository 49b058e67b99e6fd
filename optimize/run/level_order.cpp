#include "optimize/run/level_order.hpp"

#include "core/error.hpp"
#include "optimize/run/method_choice.hpp"
#include "optimize/run/run_state.hpp"

#include <algorithm>
#include <cmath>

namespace strake {
namespace {

constexpr int max_tried_variables = 24;  ///< few evaluations show what so many gain
/// Evaluations for each variable: of the trial, and of the levels after it.
constexpr double points_of_trial = 1.5, max_points_of_trial = 3, points_of_a_variable = 2;
/// Of what an evaluation gained before, patches that gain as much lead: what is tried later has less left to gain, and
/// the finest ones gain more than the few that are tried.
constexpr double min_ratio = 0.1, min_ratio_where_fields_lead = 0.7;
constexpr double points_for_fields = 1.5;     ///< with fewer left finer fields are left out
constexpr double points_left_by_patches = 3;  ///< for finer fields and what follows; else patches have the rest
constexpr double points_together = 2;         ///< with fewer left fields do not come back
constexpr int batches_of_trial = 3;

int evaluations_for(double for_each, int variables) { return static_cast<int>(for_each * (variables + 1)); }

}  // namespace

int LevelOrder::patch_variables(int level) const {
    const RestFacts& rest = *state_.rest;
    const auto& kinds = rest.parameters.kinds;
    if (kinds.empty() || !std::ranges::all_of(kinds, is_load)) return 0;
    return variables_of_a_patch(rest.parameters) *
           static_cast<int>(rest.tree->levels[static_cast<std::size_t>(level)].patches.size());
}

int LevelOrder::finest_with(int variables) const {
    int found = 0;
    for (int k = 1; k < static_cast<int>(state_.rest->tree->levels.size()); ++k)
        if (const int count = patch_variables(k); count > 0 && count <= variables) found = k;
    return found;
}

bool LevelOrder::has_order() const {
    const OptimizeOptions& options = state_.problem.optimize;
    const int tried = finest_with(max_tried_variables), finest = static_cast<int>(state_.rest->tree->levels.size()) - 1;
    return !options.patches_last && options.method == Method::model && budget_.begins_quickly() &&
           !state_.space.has_patches && tried > 0 && finest_with(max_variables_with_curvature) == finest &&
           finest > tried;
}

int LevelOrder::num_next_fields() const {
    const FieldSet& present = state_.space.fields;
    const FieldSet finer = more_fields(state_.rest->parameters, present);
    return finer.reach > present.reach ? static_cast<int>(finer.numbers.size()) : 0;
}

bool LevelOrder::can_afford(int variables, double for_each) const {
    return state_.evaluations_left() >= evaluations_for(for_each, budget_.directions_of(variables));
}

LevelSet LevelOrder::enter(Stage stage, int tree_level, bool has_fields, int levels_below) {
    stage_ = stage;
    state_.levels_below = levels_below;
    const FieldSet& present = state_.space.fields;
    LevelSet set{front_at(*state_.rest->tree, tree_level), {{}, present.reach}, stage != Stage::fields};
    set.takes_up = has_fields;
    if (has_fields) set.fields = more_fields(state_.rest->parameters, present);
    return set;
}

std::optional<LevelSet> LevelOrder::enter_together() {
    const int finest = finest_with(max_variables_with_curvature);
    const FieldSet next = more_fields(state_.rest->parameters, together_);
    const auto variables = patch_variables(finest) + static_cast<int>(next.numbers.size());
    if (!(next.reach > together_.reach) || !can_afford(variables, points_together)) {
        state_.levels_below = 0;
        return {};
    }
    together_ = next;
    const bool has_more = more_fields(state_.rest->parameters, next).reach > next.reach;
    state_.note(text("level ", state_.space.level + 1, ": the first ", next.numbers.size(),
                     " fields come back beside the finest patches, which have come to rest"));
    LevelSet set = enter(Stage::together, finest, true, has_more ? 1 : 0);
    set.fields = {next.numbers, state_.space.fields.reach};
    return set;
}

double LevelOrder::gain_from(double objective) const {
    return (state_.problem.maximize ? -1 : 1) * (objective - state_.level_best_objective);
}

bool LevelOrder::patches_gain_more() const {
    const int evaluations = state_.evaluations_of_level();
    const double gain = evaluations > 0 ? gain_from(state_.result.levels.back().objective_start) : 0;
    const bool fields_lead = state_.problem.optimize.fields_lead;
    const double wanted = fields_lead ? min_ratio_where_fields_lead : min_ratio;
    const bool tells = was_feasible_ && (gain_before_ > 0 || state_.problem.constraints.empty() ||
                                         (!fields_lead && state_.start_is_feasible));
    const bool is_more = tells && gain > 0 && gain * evaluations_before_ >= wanted * gain_before_ * evaluations;
    state_.note(text("level ", state_.space.level, ": these patches gained ", gain, " in ", evaluations,
                     " evaluations, the fields before them ", gain_before_, " in ", evaluations_before_, ": ",
                     is_more ? "patches go first" : "finer fields go first, if there are any"));
    return is_more;
}

bool LevelOrder::has_finer_below() const {
    const bool has_finer_fields = num_next_fields() > 0 && !leaves_out_fields_;
    const bool is_at_finest = stage_ == Stage::together || (stage_ == Stage::patches && !has_finer_fields);
    return state_.can_refine() && !is_at_finest;
}

std::optional<LevelSet> LevelOrder::after_patches(int finest, int fields) {
    if (fields > 0 && !leaves_out_fields_)
        return enter(Stage::fields, finest, true, can_afford(fields, points_for_fields) ? 1 : 0);
    return enter_together();
}

std::optional<LevelSet> LevelOrder::advance() {
    const int tried = finest_with(max_tried_variables), finest = finest_with(max_variables_with_curvature);
    const int fields = num_next_fields();
    const int levels_after_all = state_.problem.optimize.fields_lead ? 0 : 1;  // fields come back
    switch (stage_) {
        case Stage::first:
            if (!has_order()) break;
            gain_before_ = std::max(0.0, gain_from(state_.result.objective_start));
            if (!std::isfinite(gain_before_)) gain_before_ = 0;
            evaluations_before_ = std::max(1, state_.result.evaluations);
            was_feasible_ = state_.run_best.feasible;
            return enter(Stage::trial, tried, false, 2);
        case Stage::trial:
            patches_lead_ = patches_gain_more();
            if (patches_lead_ || fields == 0)
                return enter(Stage::patches, finest, false, fields > 0 ? 1 : levels_after_all);
            // Where nothing has kept the limits yet, all variables together find it sooner.
            return enter(gain_before_ > 0 ? Stage::fields : Stage::both, tried, true, 1);
        case Stage::patches:
            return after_patches(finest, fields);
        case Stage::together:
            return enter_together();
        case Stage::fields:
            if (!patches_lead_ && fields > 0) return enter(Stage::both, tried, true, 1);
            if (patches_lead_ && fields > 0 && can_afford(fields, points_for_fields))
                return enter(Stage::fields, finest, true, 1);
            leaves_out_fields_ = fields > 0;
            return enter(Stage::patches, finest, false, levels_after_all);
        case Stage::both:
            if (fields > 0) return enter(Stage::both, tried, true, 1);
            return enter(Stage::patches, finest, false, levels_after_all);
        case Stage::as_the_tree:
            break;
    }
    stage_ = Stage::as_the_tree;
    return {};
}

std::optional<int> LevelOrder::evaluations() const {
    const int left = state_.evaluations_left(), variables = budget_.directions();
    const int wanted = evaluations_for(points_of_a_variable, variables);
    switch (stage_) {
        case Stage::trial: {
            const int batches = 1 + batches_of_trial * state_.problem.optimize.batch;
            const int trial = std::clamp(batches, evaluations_for(points_of_trial, variables),
                                         evaluations_for(max_points_of_trial, variables));
            return std::clamp(trial, 1, std::max(1, left / 2));
        }
        case Stage::patches: {
            const int fields = num_next_fields();
            const bool leaves_enough =
                fields > 0 && left - wanted >= evaluations_for(points_left_by_patches, budget_.directions_of(fields));
            return leaves_enough ? wanted : left;
        }
        case Stage::fields:
            if (!patches_lead_ && !can_afford(state_.space.size(), points_left_by_patches)) return left;
            return std::clamp(wanted, 1, std::max(1, left / 2));
        case Stage::together:
            return left;
        case Stage::first:
        case Stage::both:
        case Stage::as_the_tree:
            break;
    }
    return {};
}

int LevelOrder::limit_while_gaining() const {
    const OptimizeOptions& options = state_.problem.optimize;
    const bool may_go_on = options.method == Method::model && !options.levels_end_at_limits && budget_.begins_quickly();
    const bool is_first_or_trial = stage_ == Stage::first || stage_ == Stage::trial;
    return may_go_on && !is_first_or_trial ? state_.evaluations_left() / 2 : 0;
}

}  // namespace strake
