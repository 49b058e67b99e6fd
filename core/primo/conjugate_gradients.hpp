#pragma once
#include "core/primo/definiteness.hpp"

/// Systems with the shell's present Hessian, by conjugate gradients on what is kept from an earlier design. Residuals
/// are measured in the norm of the preconditioner, sqrt(r.M^-1 r): it is that of the error's energy, where torques on
/// thin prisms do not drown the soft motions that matter.
namespace strake {

struct CgOptions {
    double tolerance = 1e-3;              ///< of the right-hand side's norm
    int max_iterations = 30;              ///< also gives up as soon as it is seen that these will not do
    double expected_rate = 1;             ///< factor by which one iteration reduces the residual; 1: not known
    DefinitenessProbe* beside = nullptr;  ///< steps of it go along while it is open
    /// Whether `x` with that reduction does, whatever the tolerance; may be empty.
    std::function<bool(const Eigen::VectorXd& x, double reduction)> is_enough;
    /// Sets `tolerance` and `expected_rate` once the right-hand side's norm is known.
    std::function<void(double size, CgOptions& options)> adapt;
};

struct CgResult {
    Eigen::VectorXd x;
    int iterations = 0;       ///< of one substitution each
    double size = 0;          ///< of the right-hand side
    double reduction = 1;     ///< of the residual, as the last iteration is expected to have left it
    double rate = 1;          ///< measured over the last iteration; as expected where there was but one
    bool is_reached = false;  ///< the tolerance
    bool is_positive = true;  ///< no direction of negative curvature met
};
CgResult conjugate_gradients(PrimoShell::Impl& shell, Eigen::VectorXd b, const CgOptions& options);

/// H X = B, all columns side by side, each to `tolerance`. @param similar columns in whose span parts of X are to be
/// expected, such as the solution at a neighbouring design; any number, also none. They cost a product each.
/// @throws SolverError: H is not positive definite.
Eigen::MatrixXd solve_columns(PrimoShell::Impl& shell, const Eigen::MatrixXd& B, double tolerance,
                              const Eigen::MatrixXd& similar = {});

}  // namespace strake
