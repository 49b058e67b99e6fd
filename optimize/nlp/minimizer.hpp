#pragma once
#include "optimize/nlp/program/minimize_options.hpp"

/// Minimizes nonlinear programs by our sqp and NLopt's methods behind a guard. NLopt 2.7 swallows exceptions, accepts
/// NaN with a positive code, can return a point that is not its best, and can run without end; the guard prevents all
/// of it.
namespace strake {

/// Minimizes from `start` within the bounds. Variables with equal bounds are removed first. Every x is evaluated once,
/// even if the algorithm asks again. Constraints that the method cannot take go into an augmented Lagrangian around it.
/// Exceptions of the callbacks are rethrown unchanged.
/// @throws InvalidInput: sizes, start outside bounds, a global method or several starts without finite bounds.
MinimizeResult minimize(const NonlinearProgram& program, const MinimizeOptions& options);

}  // namespace strake
