#pragma once
#include "optimize/nlp/program/first_order.hpp"

/// The model problem of one step of sequential quadratic programming. Internal.
namespace strake {

/// min g.d + d.H d / 2   s.t.  lower <= d <= upper,  c_i + a_i.d <= 0 (the first `num_inequalities` rows), = 0 (the
/// rest).
struct QuadraticModel {
    Eigen::VectorXd gradient;  ///< n
    Eigen::MatrixXd hessian;   ///< n x n, positive definite
    Eigen::VectorXd lower, upper;
    Eigen::VectorXd constraints;
    Eigen::MatrixXd jacobian;  ///< rows x n
    int num_inequalities = 0;
    /// In the Hessian's norm over the root of its mean diagonal. With violated constraints the penalty is measured by a
    /// step of this length where the gradient asks for a shorter one: otherwise no curvature, however large, shortens
    /// the way to the constraints from where the objective is stationary. 0: there is no such length.
    double min_step = 0;

    /// One more: value + slope.d <= 0.
    void add_inequality(const Eigen::VectorXd& slope, double value);
    void add_inequalities(const StepLimits& limits);
};

/// `more` rows below those of `all`.
void append(StepLimits& all, const StepLimits& more);

/// The step d. Where the linearized constraints cannot all be met within the bounds, a large penalty reduces their
/// violation. Solved in coordinates in which the Hessian is the identity (least_distance.hpp), by NLopt's SLSQP where
/// rounding stops that. An empty vector: the Hessian is not positive definite, or both failed.
Eigen::VectorXd solve_model(const QuadraticModel& model);

/// Active set of the model's solution d: constraints without slack, and variables that are at no bound.
ActiveSet active_set(const QuadraticModel& model, const Eigen::VectorXd& d);

}  // namespace strake
