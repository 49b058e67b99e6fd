#pragma once
#include "optimize/nlp/program/guard.hpp"

/// Sequential quadratic programming in a trust region. Internal.
///
/// NLopt's driver of SLSQP cannot reject a point, starts from a unit Hessian and loses what it learned when it is
/// restarted. Here a dual active-set method solves the quadratic model of each step (model/quadratic_model.hpp);
/// NLopt's SLSQP is asked only where rounding stops it. The parts: iterate.hpp (where the search is), merit.hpp
/// (objective + penalty * violations, which accepts steps), hessian_model.hpp, gradient_model.hpp (gradients by
/// differences), step_model.hpp (the step within the radius), border_cut.hpp (steps along a border of failures),
/// trust_region.hpp (all thresholds), sqp_search.hpp (the loop).
namespace strake {

struct SqpEnd {
    MinimizeStop stop = MinimizeStop::failed;
    std::string reason;
    int shrinks = 0;
    int accepted = 0;                ///< steps
    double radius = 0;               ///< of the trust region at the end
    Eigen::MatrixXd hessian;         ///< the model at the end
    bool is_at_border = false;       ///< of what fails: further gains lie along it
    Eigen::MatrixXd gradient_error;  ///< columns, by which the gradient at the best point may be off; empty: none
    Eigen::VectorXd last_x;          ///< where the search stood, and its evaluation with gradients
    Evaluation last;
};

/// Starts at the guard's best point, which is evaluated and differentiated; leaves the best in the guard.
/// @param min_curvature of the first model over the metric; 0: such that its step has the length `first_step`
/// @throws nlopt::forced_stop never: `guard.cause` of the end is turned into `stop`.
SqpEnd minimize_by_sqp(Guard& guard, double min_curvature = 0);

}  // namespace strake
