#pragma once
#include "optimize/problem/problem.hpp"

/// Robust losses: far-off points pull less, and outliers of a scan do not bend the fit.
namespace strake {

/// rho(s) of the squared distance s (length^2) of a point, rho ~ s for small s; a is the scale, length:
/// none s; huber 2 a sqrt(s) - a^2 beyond a; cauchy a^2 log(1 + s/a^2); soft_l1 2 a^2 (sqrt(1 + s/a^2) - 1).
/// Returns rho and its first two derivatives. @pre a > 0 unless `none`.
std::array<double, 3> robust_loss(Loss loss, double scale, double squared_distance);

/// Residuals whose sum of squares is the robust objective sum w_i rho(|r_i|^2 / w_i) itself:
/// f_i = phi r_i, phi = sqrt(rho(s)/s), df_i = (phi I + 2 phi'/w r_i r_i^T) dr_i. So the objective that the solver
/// sees, the one in the history and its gradient agree exactly (Triggs' correction has only the gradient right).
Residuals robust(Loss loss, double scale, Residuals residuals);

}  // namespace strake
