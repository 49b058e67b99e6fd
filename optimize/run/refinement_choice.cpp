#include "optimize/run/refinement_choice.hpp"

#include "core/error.hpp"
#include "optimize/run/method_choice.hpp"

#include <algorithm>
#include <cmath>

namespace strake {
namespace {

constexpr double variables_at_price = 10;  ///< new ones that must gain `min_expected_gain` of what was gained

}  // namespace

std::string RefinementChoice::words() const {
    return text(plan.words(),
                times == 1 ? ""
                : probed   ? text("; by the values ", times, " times that")
                           : text("; the last one gave ", times, " times what was expected"),
                looked == 1      ? ""
                : single_patches ? "; too little, and so are patches by themselves"
                                 : text("; too little, and so are parts of parts (to depth ", looked, ")"));
}

/// As long as a level could have all of them: the look costs a response at rest for each.
int RefinementScale::max_depth(const DesignSpace& space) const {
    const PatchHierarchy& tree = *space.rest->tree;
    const Parameters& p = space.rest->parameters;
    const double max_variables = p.max_variable_ratio * std::max(1, space.size());
    Front parts = split_everywhere(tree, *space.front);
    for (int depth = 1;; ++depth) {
        Front next = split_everywhere(tree, parts);
        const bool is_finest = next.depth.size() == parts.depth.size();
        if (is_finest || static_cast<double>(next.depth.size()) * variables_of_a_patch(p) > max_variables) return depth;
        parts = std::move(next);
    }
}

std::optional<RefinementChoice> RefinementScale::choose(const DesignFacts& facts) const {
    std::optional<RefinementChoice> choice = weigh(facts, 1);
    const bool may_look = choice && choice->is_idle && !state_.problem.optimize.sees_parts_alone;
    const bool single_patches = facts.space.rest->takes_single_patches;
    // Fields are stiff beside patches: in a step of both they hide how soft values are on what patches do.
    const int deepest = !may_look ? 1 : single_patches ? 2 : max_depth(facts.space);
    for (int depth = 2; depth <= deepest; ++depth) {
        std::optional<RefinementChoice> deeper = weigh(facts, depth);
        if (!deeper) break;
        if (!deeper->is_idle) return deeper;
        choice->looked = depth;
        choice->single_patches = single_patches;
    }
    return choice;
}

std::optional<RefinementChoice> RefinementScale::weigh(const DesignFacts& facts, int depth) const {
    const std::optional<Forecast> forecast = make_forecast(facts, depth);
    if (!forecast) return {};
    RefinementChoice choice;
    choice.probed = probe(facts, *forecast);
    choice.times = choice.probed.value_or(last_times_);
    // Measured by what has been gained: an objective may go to zero.
    const OptimizeOptions& options = state_.problem.optimize;
    const double now = state_.level_best_objective, gained = std::abs(state_.result.objective_start - now);
    const double min_gain = options.min_expected_gain * gained;
    const bool has_price = by_sensitivity() && !is_in_noise_;
    choice.plan = plan_refinement(facts, *forecast, has_price ? min_gain / variables_at_price / choice.times : 0);
    // Where the values bend down all along the step, how much it gives cannot be said: that is tried, not deeper.
    const bool is_open = depth == 1 && choice.probed && *choice.probed >= max_correction;
    const double least = options.is_relative_to_objective ? std::max(std::abs(now), gained) : gained;
    const double floor =
        std::max(0.1 * options.objective_tolerance * least, is_open ? 0 : min_gain * price(choice.plan));
    choice.is_idle = by_sensitivity() && choice.times * choice.plan.chosen <= floor;
    return choice;
}

/// Many variables must gain more than few: each takes its share of the search. Not where the level can do no more for
/// noise: larger steps, which only finer patches still have, are above it.
double RefinementScale::price(const RefinementPlan& plan) const {
    if (is_in_noise_) return 1;
    return std::max(1.0, (plan.variables_after - plan.variables_before) / variables_at_price);
}

/// The metric is stiffer on details than objectives are: expected decreases are too small. How much too small follows
/// from the curvature along the expected step: the best on that line against what the metric expects.
std::optional<double> RefinementScale::probe(const DesignFacts& facts, const Forecast& forecast) const {
    const auto curvature = state_.evaluator.curvature_along(facts.x, forecast.below.children.space, forecast.step,
                                                            program_.lagrangian_weights());
    if (!curvature) return {};
    return *curvature > 0 ? std::clamp(2 * forecast.decrease / *curvature, 1.0, max_correction) : max_correction;
}

}  // namespace strake
