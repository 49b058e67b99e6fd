#pragma once
#include "optimize/nlp/program/guard.hpp"

/// What the end of a search says about its problem: active bounds. `optimize/run/run_verdict.hpp` chooses the word for
/// the run. Internal.
namespace strake {

/// Number of free variables at a bound across which the Lagrangian falls; without gradients, at any bound.
int count_active_bounds(const Guard& guard);

}  // namespace strake
