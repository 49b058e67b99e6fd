#pragma once
#include "optimize/guard.hpp"

/// Sequential quadratic programming in a trust region. Internal.
///
/// NLopt's own driver of SLSQP has no way to reject a point, starts from a unit Hessian and loses what it learned when
/// it is restarted. Here NLopt's SLSQP solves the quadratic model of each step, and the globalization is ours: the
/// Hessian starts as what the program knows of it, else as a multiple of the metric, and learns by damped BFGS updates
/// (Powell), and by the curvature that active constraints have shown, in all directions; a step is no longer than the
/// trust region in the metric; directions that have become soft are found before they are tried; an evaluation that
/// fails halves the region, and from the second on steps go along the border of what fails (failure_border.hpp); and a
/// merit function (objective + penalty * violations) decides about the rest.
namespace strake {

struct SqpEnd {
    MinimizeStop stop = MinimizeStop::failed;
    std::string reason;
    int shrinks = 0;
    int accepted = 0;           ///< steps
    double radius = 0;          ///< of the trust region at the end
    Eigen::MatrixXd hessian;    ///< the model at the end
    int softenings = 0;         ///< directions that were found longer than the metric knew
    bool is_at_border = false;  ///< of what fails; what more there is to gain lies along it
    Eigen::MatrixXd doubt;      ///< columns, by which the gradient at the best point may be off; empty: none
};

/// Starts at the guard's best point, which is evaluated and differentiated; leaves the best in the guard.
/// @param least_curvature of the first model over the metric; 0: such that its step has the length `first_step`
/// @throws nlopt::forced_stop never: `guard.cause` of the end is turned into `stop`.
SqpEnd minimize_by_sqp(Guard& guard, double least_curvature = 0);

}  // namespace strake
