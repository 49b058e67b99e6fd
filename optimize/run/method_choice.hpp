#pragma once
#include "optimize/nlp/program/minimize_options.hpp"
#include "optimize/problem/problem.hpp"

/// `optimize.method: auto`: which method searches. The choice depends on the problem and its budget only, so that a run
/// that is resumed makes it again.
namespace strake {

struct MethodChoice {
    Method method = Method::sqp;
    bool by_differences = false;  ///< gradients that are missing
    std::string words;            ///< why, for the log
};

/// Where the objective and all constrained values have gradients, or the case asks for differences: sqp, and no words.
/// Else sqp by differences; or, where there is no cheap model, `model`: where the budget pays for fewer than
/// `min_gradients` whole gradients of the first level, or for at most `max_evaluations_by_models` in a run
/// `is_long_with_fields`.
/// @param budget of the whole run, evaluations
/// @pre problem.optimize.chooses_method
MethodChoice choose_method(const Problem& problem, int budget);

/// Of elastic energies, what the metric of a run counts (`RestFacts::energy_share`). Fields bend and twist a body as
/// loads do, and what only loads can do has little of their energy: beside fields all of it would make patches look a
/// hundred times too dear. By values alone it counts: what is soft is learned first.
double energy_share(const Problem& problem);
inline constexpr double energy_beside_fields = 0.003;

/// Beside fields, a run by gradients that chooses what to refine (`split: sensitivity`) gives variables to single
/// patches (`RestFacts::takes_single_patches`). Of loads alone: they leave what they do to those beside.
bool takes_single_patches(const Problem& problem);
/// The run watches its steps for waves of an objective with many minima: with fields by sensitivity and exact
/// gradients, from rest, where no number of starts is stated.
bool looks_for_waves(const Problem& problem);
/// The same of a run by values, with fields as its first level, once a search by models has ended there.
bool looks_for_waves_by_values(const Problem& problem);

/// Maximum number of variables of the first level: a run drops those that turn out to move nothing.
int max_variables_at_start(const Problem& problem);

/// Gradients by differences, one evaluation for each variable and one more, below which `model` ends lower on most
/// problems of the evidence suite (docs/evidence.md).
inline constexpr double min_gradients = 8;

/// With displacement fields in front, `model` reaches the end of patches and box by differences sooner on all but a few
/// problems of the suite, up to so many evaluations. More were not measured.
inline constexpr int max_evaluations_by_models = 1000;

/// Variables without patches that models are learned of, beside what differences would cost.
inline constexpr int max_variables_by_models = 100;

/// The run begins at its surface with displacement fields alone, few enough for models; its levels follow the tree; and
/// the budget pays for whole gradients by differences. A search by models then begins with one field after another
/// (`MinimizeOptions::tries_in_order`).
bool is_long_with_fields(const Problem& problem, int budget);

/// Designs that the first level of such a run asks at a time, unless programs have variables: half of
/// `OptimizeOptions::batch` but not below four: it knows the start alone, and every answer tells much.
int batch_of_first_fields(const OptimizeOptions& options);

/// What the options of a run say to each of its searches: tolerances, batch, and the meanings of earlier runs.
MinimizeOptions options_of_searches(const OptimizeOptions& options);

/// Ranges of variables under the motion limit are what they may do together (`widen_to_limit`): of sqp and model. Else
/// what each may do alone.
bool begins_with_wide_ranges(const Problem& problem);

}  // namespace strake
