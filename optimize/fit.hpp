#pragma once
#include "optimize/run_records.hpp"

/// Recovers a target shape: nonlinear least squares (Ceres, Levenberg-Marquardt) of the design variables on the
/// residuals of the fitted quantities, with the exact Jacobian dr/dx = dr/dv dv/dx, level by level.
namespace strake {

/// Fits the quantities named in `problem.fit`; the objective of the records is the sum of squares of all residuals
/// (for target shapes the mean square distance). Invalid shapes are refused to Ceres, which shortens its step. The
/// result is our own best evaluation. A level ends when its least-squares problem has converged or an iteration removes
/// less than `progress_below` of the residual; the run has converged when the last level has.
/// @throws InvalidInput: nothing to fit, a quantity without residuals, stiffness variables; UnheldPart.
RunResult fit(const Problem& problem, const RunEvents& events = {});

}  // namespace strake
