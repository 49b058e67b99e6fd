#pragma once
#include "optimize/guard.hpp"

/// What a search that ended can tell about its problem. Internal.
namespace strake {

/// Compares the objective and the constraints with their gradients from the best point along the steepest descent (or,
/// where the constraints are not met, along the gradients of what is violated, into the bounds), in a step of 1e-3 and
/// half of it. Fills the fields of the result and adds to its reason when one differs by more than a fifth and the two
/// steps agree. Takes up to three evaluations; with fewer left it says nothing.
void check_slopes(Guard& guard, MinimizeResult& result);

/// Whether the gradient at the best point promises clearly more than the tolerance for a step of 1e-3.
bool promises_more(const Guard& guard);

/// Number of free variables at a bound whose derivative of the Lagrangian pushes outward; without gradients, at one.
int count_active_bounds(const Guard& guard);

}  // namespace strake
