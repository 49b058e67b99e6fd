#pragma once
#include "core/primo/definiteness.hpp"

/// Solves systems with the shell's current Hessian by conjugate gradients, preconditioned by the kept factor or cycles
/// of an earlier design. Residuals are measured in the norm of the preconditioner, sqrt(r.M^-1 r), an energy norm:
/// torques on thin prisms would otherwise hide the soft motions that matter.
namespace strake {

struct CgOptions {
    double tolerance = 1e-3;              ///< of the right-hand side's norm
    int max_iterations = 30;              ///< stops early when these cannot suffice
    double expected_rate = 1;             ///< reduction of the residual per iteration; 1: unknown
    DefinitenessProbe* beside = nullptr;  ///< its steps share the substitutions while it is open
    /// Whether `x` with that reduction is good enough, regardless of the tolerance; may be empty.
    std::function<bool(const Eigen::VectorXd& x, double reduction)> is_enough;
    /// Sets `tolerance` and `expected_rate` once the right-hand side's norm is known.
    std::function<void(double size, CgOptions& options)> adapt;
};

struct CgResult {
    Eigen::VectorXd x;
    int iterations = 0;       ///< of one substitution each
    double size = 0;          ///< of the right-hand side
    double reduction = 1;     ///< of the residual, expected after the last iteration
    double rate = 1;          ///< measured over the last iteration; the expected rate after a single one
    bool is_reached = false;  ///< the tolerance
    bool is_positive = true;  ///< no direction of negative curvature found
};
CgResult conjugate_gradients(PrimoShell::Impl& shell, Eigen::VectorXd b, const CgOptions& options);

/// Solves H X = B for all columns at once, each to `tolerance`. @param similar vectors whose span is likely to contain
/// parts of X, for example solutions at a neighbouring design; may be empty. Each costs a product.
/// Where the kept preconditioner does not lead there, it is built anew, as a factor where that is not too large.
/// @throws SolverError: H is not positive definite, a right-hand side is not finite, or a column stays unsolved.
Eigen::MatrixXd solve_columns(PrimoShell::Impl& shell, const Eigen::MatrixXd& B, double tolerance,
                              const Eigen::MatrixXd& similar = {});

}  // namespace strake
