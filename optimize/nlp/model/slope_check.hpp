#pragma once
#include "optimize/nlp/program/guard.hpp"

/// Before a search ends: do the values follow the gradients of the program? Internal.
namespace strake {

/// What the search has paid for is asked first (`GradientEvidence`): steps in all directions of the free variables that
/// follow the gradient confirm it, steps that follow it times a wrong factor contradict it. Where these cannot tell,
/// two further evaluations are paid, which `MinimizeResult::confirmations` counts and an event tells:
///  - the search has stalled, or its gradient expects more: along the steepest descent (while constraints are violated,
///    along their gradients, into the bounds), 1e-3 of the metric to both sides;
///  - it has converged: in a direction that no step has confirmed, as well.
/// From variables at their bounds, and from limits, steps lead inward: one and its half.
/// A value is wrong whose slope differs from its gradient's by more than a fifth, where the slope clearly exceeds what
/// curvature and noise leave unknown. Fills `gradient_inconsistent`, `gradient_confirmed` and `slope_*` of the result
/// and adds to its reason. With fewer than two evaluations left it only asks what is known.
void check_slopes(Guard& guard, MinimizeResult& result);

/// The gradient at the best point predicts a decrease clearly above the tolerance for a step of 1e-3.
bool expects_more(const Guard& guard);

}  // namespace strake
