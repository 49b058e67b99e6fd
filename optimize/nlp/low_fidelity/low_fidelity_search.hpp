#pragma once
#include "optimize/nlp/low_fidelity/corrected_program.hpp"
#include "optimize/nlp/program/guard.hpp"

/// Search for the optimum of an expensive program by a cheap one (approximation and model management, Alexandrov and
/// Lewis 2001). Internal.
///
/// Each step goes to the optimum of the corrected cheap program within a trust region; what the expensive one says
/// there decides about the step and the radius, and corrects. Where more is expected of knowing the slope of the
/// residual along some directions than of the next step, each per evaluation, designs along these are evaluated, all at
/// the same time. A cheap program whose expected decreases do not come is left after a few evaluations.
namespace strake {

struct LowFidelityEnd {
    /// The cheap program is of no more use; or its expected decreases came, and nothing is left to gain that is worth
    /// an evaluation; or the search is over, with the guard's cause or because of `on_model`.
    enum class Why { misled, exhausted, ended, outpaced } why = Why::ended;
    Eigen::VectorXd x;               ///< where it stands
    Evaluation at;                   ///< there, with the gradients as far as they are known
    Eigen::MatrixXd gradient_error;  ///< columns, by which these may be off
    Eigen::MatrixXd hessian;         ///< of the Lagrangian; empty: not known
    double radius = 0;
    int accepted = 0;
    Eigen::VectorXd rho;            ///< per value
    double expected = 0, kept = 0;  ///< decrease of the merit, over all steps with a value
};

/// Starts at the guard's best point, whose values are known; leaves the best in the guard.
/// @pre the program has a cheap one. @throws what the callbacks of the cheap program throw
LowFidelityEnd minimize_by_low_fidelity(Guard& guard);

/// All that no cheap program says is given by `differentiate`, or nothing: gradients are not asked for then.
bool learns_from_values(const NonlinearProgram& program);

}  // namespace strake
