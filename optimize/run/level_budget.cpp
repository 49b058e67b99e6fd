#include "optimize/run/level_budget.hpp"

#include "optimize/run/method_choice.hpp"
#include "optimize/run/run_state.hpp"
#include "optimize/run/value_trial.hpp"

#include <algorithm>
#include <cmath>

namespace strake {
namespace {

constexpr double points_of_a_variable = 2;
constexpr double points_of_first_fields = 1.5;  ///< in long runs: what a few fields do not find waits on the next level
constexpr int min_points_of_a_variable = 3;     ///< of this level and those below it together
constexpr int batches_of_a_level = 3;           ///< at least: the first only looks around
constexpr int max_variables_with_patches = 60;  ///< whose metric says less of the objective's curvature
constexpr int trial_share = 10;                 ///< trials of directions that must still be affordable

}  // namespace

bool LevelBudget::can_pay_trial() const { return state_.evaluations_left() > trial_share * trial_directions; }

int LevelBudget::by_differences() const {
    const int gradient = program_.gives_lagrangian() ? 0 : static_cast<int>(state_.space.size());
    const int left = state_.evaluations_left(), to_come = state_.levels_left() + 1;
    const bool is_for_all = state_.problem.optimize.shares_with_all_levels;
    const int levels = is_for_all ? to_come : std::clamp(left / (min_evaluations + gradient), 1, to_come);
    return std::max(1, left / levels);
}

int LevelBudget::directions() const { return program_.num_directions(); }

int LevelBudget::directions_of(int variables) const {
    if (directions() == static_cast<int>(program_.program().start.size())) return variables;
    const double share = directions() / std::max<double>(1, static_cast<double>(state_.space.size()));
    return static_cast<int>(std::ceil(share * variables));
}

int LevelBudget::by_models() const {
    const int shared = by_differences(), left = state_.evaluations_left();
    if (state_.problem.optimize.learns_as_before || shared == left) return shared;
    const int terms = directions() + 1;
    if (!can_learn(directions())) return left;
    const int batches = 1 + batches_of_a_level * state_.problem.optimize.batch;
    const bool is_quick = !state_.space.has_patches && begins_quickly();
    const double wanted = (is_quick ? points_of_first_fields : points_of_a_variable) * terms;
    return std::clamp(std::max(static_cast<int>(wanted), batches), 1, std::max(1, left / 2));
}

bool LevelBudget::can_learn(int variables) const {
    return state_.evaluations_left() >= min_points_of_a_variable * (variables + 1);
}

bool LevelBudget::begins_quickly() const {
    return !state_.problem.optimize.begins_slowly && state_.space.num_parameters() == 0 &&
           is_long_with_fields(state_.problem, state_.limits().evaluations);
}

std::optional<LevelSet> LevelBudget::patches_alone() const {
    const DesignSpace& space = state_.space;
    const auto is_of_patch = [](const Variable& variable) { return variable.patch >= 0 && is_load(variable.kind); };
    const auto loads = static_cast<int>(std::ranges::count_if(space.variables, is_of_patch));
    if (state_.problem.optimize.method != Method::model || loads == 0 || !begins_quickly()) return {};
    LevelSet below = level_set(*space.rest, space.level + 1);
    const auto patches = static_cast<int>(below.front.patches.patches.size());
    const auto before = static_cast<int>(space.patches().patches.size());
    const auto fields = static_cast<int>(below.fields.numbers.size());
    if (below.fields.reach > space.fields.reach || can_learn(directions_of(fields + loads * patches / before)))
        return {};
    below.fields.numbers.clear();
    return below;
}

bool LevelBudget::begins_by_models() const {
    const OptimizeOptions& options = state_.problem.optimize;
    const auto is_equality = [](const Constraint& c) { return c.equals.has_value(); };
    if (options.learns_as_before || options.method != Method::sqp || !program_.has_choice() ||
        std::ranges::any_of(state_.problem.constraints, is_equality))
        return false;
    if (!state_.space.has_patches) return state_.space.size() <= max_variables_by_models;
    return !options.descends_as_before && state_.space.size() <= max_variables_with_patches;
}

}  // namespace strake
