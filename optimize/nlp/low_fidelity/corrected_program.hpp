#pragma once
#include "optimize/nlp/low_fidelity/residual_model.hpp"
#include "optimize/nlp/program/failure_border.hpp"
#include "optimize/nlp/program/minimize_options.hpp"

/// The cheap program, corrected by what the expensive one has shown, within a trust region. Internal.
namespace strake {

/// Both programs at the point that a search has reached.
struct LowFidelityPoint {
    Eigen::VectorXd x;
    Eigen::VectorXd values, low;    ///< of the expensive and of the cheap program, objective first
    Eigen::MatrixXd low_gradients;  ///< n x values
    StepLimits limits;              ///< near x
};

/// f(x0) + rho (f_low(x) - f_low(x0)) + s.(x - x0) + (x - x0).Q (x - x0) / 2 for each value about x0 = `from`, with
/// more inequalities, the last of them: x within `radius` of x0 in the metric, and on this side of the cut, if there is
/// one. All of it is copied but the callbacks of `low`, which must outlive the program.
NonlinearProgram corrected_program(const LowFidelity& low, const ResidualModel& model, const LowFidelityPoint& from,
                                   const Eigen::MatrixXd& metric, double radius,
                                   const std::optional<FailureCut>& cut = {});

/// Its values (objective first, without the trust region) at a point where the cheap program has these.
Eigen::VectorXd corrected_values(const ResidualModel& model, const LowFidelityPoint& from, const Eigen::VectorXd& x,
                                 const Eigen::VectorXd& low);

/// The optimum of a corrected program.
struct CorrectedOptimum {
    bool is_found = false;
    Eigen::VectorXd x, values;  ///< without trust region and cut
    Eigen::MatrixXd hessian;    ///< of its Lagrangian
    bool is_limited = false;    ///< by the trust region
};
/// @param num_inequalities without those of trust region and cut
/// @param hessian that it begins with; empty: none
/// @throws what the callbacks throw
CorrectedOptimum minimize_corrected(NonlinearProgram program, int num_inequalities, const MinimizeOptions& options,
                                    const Eigen::MatrixXd& hessian, double radius);

}  // namespace strake
