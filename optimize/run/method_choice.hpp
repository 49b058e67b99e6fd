#pragma once
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
/// Else sqp by differences; or, where there is no cheap model and the budget pays for fewer than `min_gradients`
/// whole gradients of the first level, `model`.
/// @param budget of the whole run, evaluations
/// @pre problem.optimize.chooses_method
MethodChoice choose_method(const Problem& problem, int budget);

/// Maximum number of variables of the first level: a run drops those that turn out to move nothing.
int max_variables_at_start(const Problem& problem);

/// Gradients by differences, one evaluation for each variable and one more, below which `model` ends lower on most
/// problems of the evidence suite (docs/evidence.md).
inline constexpr double min_gradients = 8;

}  // namespace strake
