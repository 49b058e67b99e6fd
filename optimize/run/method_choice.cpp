#include "optimize/run/method_choice.hpp"

#include "core/error.hpp"
#include "optimize/nlp/program/methods.hpp"
#include "optimize/space/design_space.hpp"

#include <algorithm>

namespace strake {
namespace {

bool has(const Parameters& parameters, VariableKind kind) {
    return std::find(parameters.kinds.begin(), parameters.kinds.end(), kind) != parameters.kinds.end();
}

bool runs_several(const Quantity& quantity) { return quantity.parallel > 1; }

bool has_patches_at_start(const Parameters& p) { return !p.fields || has(p, VariableKind::strain); }

/// First of the values that the search needs and that have no gradient; empty: none.
std::string without_gradient(const Problem& problem) {
    const auto has_none = [&](const std::string& name) {
        return std::any_of(problem.quantities.begin(), problem.quantities.end(), [&](const Quantity& quantity) {
            return !quantity.has_sensitivities &&
                   std::find(quantity.names.begin(), quantity.names.end(), name) != quantity.names.end();
        });
    };
    if (has_none(problem.objective)) return problem.objective;
    for (const Constraint& constraint : problem.constraints)
        if (has_none(constraint.quantity)) return constraint.quantity;
    return {};
}

bool has_exact_gradients(const Problem& problem) {
    return method_facts(problem.optimize.method).needs_gradients && without_gradient(problem).empty();
}

bool minds_waves(const Problem& problem) {
    const OptimizeOptions& options = problem.optimize;
    return problem.parameters.fields && !problem.start && options.starts == 1 && !options.ignores_waves;
}

}  // namespace

int max_variables_at_start(const Problem& problem) {
    const Parameters& p = problem.parameters;
    auto count = static_cast<int>(problem.program_parameters.size());
    int fields = 0;
    for (const UserVariable& variable : p.user_variables) ++(variable.field >= 0 ? fields : count);
    count += p.field_steps.empty() ? fields : std::min(fields, p.field_steps.front());
    if (!has_patches_at_start(p) || problem.tree.levels.empty()) return count;
    std::vector<char> is_held(static_cast<std::size_t>(problem.surface.num_triangles()), 0);
    for (const int t : problem.fixed) is_held[static_cast<std::size_t>(t)] = 1;
    const PatchLevel& first = problem.tree.levels[problem.tree.levels.size() > 1 ? 1 : 0];
    for (const Patch& patch : first.patches) {
        const auto moves = [&](int t) {
            const auto at = static_cast<std::size_t>(t);
            return !is_held[at] && (p.variables_on.empty() || p.variables_on[at]) &&
                   (p.frozen.empty() || !p.frozen[at]);
        };
        if (std::any_of(patch.triangles.begin(), patch.triangles.end(), moves)) count += variables_of_a_patch(p);
    }
    return count;
}

bool is_long_with_fields(const Problem& problem, int budget) {
    const Parameters& p = problem.parameters;
    const auto is_field = [](const UserVariable& variable) { return variable.field >= 0; };
    const bool are_alone = p.fields && !has_patches_at_start(p) && problem.tree.levels.size() != 1 &&
                           std::ranges::all_of(p.user_variables, is_field);
    const int variables = max_variables_at_start(problem);
    return are_alone && p.split == SplitRule::tree && !problem.start && !problem.optimize.long_runs_by_differences &&
           variables <= max_variables_by_models && budget >= min_gradients * (variables + 1);
}

int batch_of_first_fields(const OptimizeOptions& options) {
    constexpr int enough = 4;  // answers at a time to learn from: two were worse
    if (options.begins_with_whole_batches) return options.batch;
    return std::max(options.batch / 2, std::min(enough, options.batch));
}

MinimizeOptions options_of_searches(const OptimizeOptions& options) {
    MinimizeOptions how;
    how.batch = options.batch;
    how.objective_tolerance = options.objective_tolerance;
    how.step_tolerance = options.step_tolerance;
    how.constraint_tolerance = options.constraint_tolerance;
    how.is_relative_to_objective = options.is_relative_to_objective;
    how.trusts_long_steps = options.trusts_long_steps;
    how.learns_as_before = options.learns_as_before;
    how.descends_as_before = options.descends_as_before;
    how.limits_by_models = options.limits_by_models;
    how.limits_by_turns = options.limits_by_turns;
    how.minima_in_variables = options.minima_in_variables;
    how.leaves_equations = options.leaves_equations;
    how.leaves_limits = options.leaves_limits;
    how.pays_without_shape = options.pays_without_shape;
    how.steps_pay_without_shape = options.steps_pay_without_shape;
    how.stays_where_models_are_sure = options.stays_where_models_are_sure;
    how.images_are_exact = options.images_are_exact;
    how.follows_short_waves = options.follows_short_waves;
    if (options.levels_gain_a_quarter) how.gaining_share = 0.25;
    return how;
}

bool begins_with_wide_ranges(const Problem& problem) {
    const OptimizeOptions& options = problem.optimize;
    if (options.method == Method::model) return !options.models_begin_with_narrow_ranges;
    const bool are_narrow =
        problem.has_shell ? options.begins_with_narrow_shell_ranges : options.begins_with_narrow_ranges;
    return options.method == Method::sqp && !are_narrow;
}

double energy_share(const Problem& problem) {
    const bool counts_share = problem.parameters.fields && !problem.optimize.counts_whole_energy;
    return counts_share && has_exact_gradients(problem) ? energy_beside_fields : 1;
}

bool takes_single_patches(const Problem& problem) {
    const Parameters& p = problem.parameters;
    return p.fields && p.split == SplitRule::sensitivity && !p.kinds.empty() && std::ranges::all_of(p.kinds, is_load) &&
           has_exact_gradients(problem) && !problem.optimize.refines_whole_fronts;
}

bool looks_for_waves(const Problem& problem) {
    return minds_waves(problem) && problem.parameters.split == SplitRule::sensitivity && has_exact_gradients(problem);
}

bool looks_for_waves_by_values(const Problem& problem) { return minds_waves(problem) && !has_exact_gradients(problem); }

MethodChoice choose_method(const Problem& problem, int budget) {
    MethodChoice choice;
    if (problem.optimize.finite_differences) return choice;  // stated
    const std::string missing = without_gradient(problem);
    if (missing.empty()) return choice;
    const int variables = max_variables_at_start(problem), gradient = variables + 1;
    const double affordable = static_cast<double>(budget) / gradient;
    choice.by_differences = true;
    if (!problem.cheap_models.empty()) {  // only sqp knows how to use them
        choice.words =
            text("method: auto chooses sqp with the cheap model, and differences where that is not enough: '", missing,
                 "' has no gradient");
        return choice;
    }
    const std::string why =
        text("'", missing, "' has no gradient, one by differences takes ", gradient,
             " evaluations (variables of the first level: ", variables, "), the budget is ", budget);
    const bool is_long = budget <= max_evaluations_by_models && is_long_with_fields(problem, budget);
    if (affordable < min_gradients || is_long) {
        choice.method = Method::model;
        choice.words = text("method: auto chooses model, in batches of ", problem.optimize.batch, ": ",
                            is_long ? text("displacement fields are the first level, and ") : "", why);
        const int first = batch_of_first_fields(problem.optimize);
        if (is_long && problem.program_parameters.empty() && first < problem.optimize.batch)
            choice.words += text("; the first level asks ", first, " at a time");
        if (problem.optimize.batch > 1 && std::ranges::none_of(problem.quantities, runs_several))
            choice.words +=
                "; here they run one after another (parallel: 1), and optimize.batch: 1 learns after each: about a "
                "tenth fewer evaluations";
    } else {
        choice.words = text("method: auto chooses sqp by differences: ", why);
    }
    return choice;
}

}  // namespace strake
