#pragma once
#include "optimize/run/run_records.hpp"

/// Recovers a target shape, measured points or wanted dimensions: nonlinear least squares of the design variables on
/// the residuals of the fitted quantities, with the exact Jacobian dr/dx = dr/dv dv/dx, level by level.
namespace strake {

class Journal;

/// Fits the quantities named in `problem.fit` (a quantity of several values by the part of its names before the dot);
/// the objective of the records is the sum of squares of all residuals, under a robust loss the sum of its rho: for
/// small distances the mean square distance. Shapes that are refused shorten the step. The result is our own best
/// evaluation. A level ends when its least-squares problem has converged or three iterations in a row remove
/// less than `progress_below` of the residual; the run has converged when the last level has. Each level's summary says
/// what share it explains of the distance that the levels before have left. A quantity that gives no residuals, or
/// numbers that are not finite, ends the fit (status `evaluation_failed`) unless its failing shortens the step.
/// @param journal as for `optimize`.
/// @throws ReplayMismatch; InvalidInput: nothing to fit, a quantity without residuals, stiffness variables, a wrong
/// option; UnheldPart.
RunResult fit(const Problem& problem, const RunEvents& events = {}, Journal* journal = nullptr);

}  // namespace strake
