#include "optimize/run/level_budget.hpp"

#include "optimize/run/method_choice.hpp"
#include "optimize/run/run_state.hpp"
#include "optimize/run/value_trial.hpp"

#include <algorithm>

namespace strake {
namespace {

constexpr int points_of_a_variable = 2;
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

int LevelBudget::by_models() const {
    const int shared = by_differences(), left = state_.evaluations_left();
    if (state_.problem.optimize.learns_as_before || shared == left) return shared;
    const int terms = static_cast<int>(state_.space.size()) + 1;
    if (left < min_points_of_a_variable * terms) return left;
    const int batches = 1 + batches_of_a_level * state_.problem.optimize.batch;
    return std::clamp(std::max(points_of_a_variable * terms, batches), 1, std::max(1, left / 2));
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
