#pragma once
#include "optimize/nlp/program/guard.hpp"

/// What the end of a search says about its problem. Internal.
namespace strake {

/// Compares the objective and the constraints with their gradients from the best point along the steepest descent
/// (while constraints are violated, along their gradients, into the bounds), in a step of 1e-3 and half of it. Fills
/// the fields of the result and adds to its reason when one differs by more than a fifth and the two steps agree. Takes
/// up to three evaluations; with fewer left it does nothing.
void check_slopes(Guard& guard, MinimizeResult& result);

/// The gradient at the best point predicts a decrease clearly above the tolerance for a step of 1e-3.
bool expects_more(const Guard& guard);

/// Number of free variables at a bound across which the Lagrangian falls; without gradients, at any bound.
int count_active_bounds(const Guard& guard);

}  // namespace strake
