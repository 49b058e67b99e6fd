#pragma once
#include "optimize/minimizer.hpp"

/// First-order conditions at a point. Internal.
namespace strake {

/// Least-squares multipliers of the constraints that are active or nearly so (of an inequality >= 0, else it is dropped
/// once), zero for the others, in the norm of the inverse metric. `sample` is differentiated.
Eigen::VectorXd multipliers(const NonlinearProgram& program, const Sample& sample);

/// Variable j is at a bound (to rounding) and the direction leads out.
bool leaves_bounds(const NonlinearProgram& program, const Eigen::VectorXd& x, Eigen::Index j, double direction);

/// Where a first step would lead: -metric^-1 (gradient + jacobian^T multipliers), without what the bounds forbid.
Eigen::VectorXd descent_direction(const NonlinearProgram& program, const Eigen::VectorXd& x, const Sample& sample);

/// The program's metric, n x n: the identity where it names none.
Eigen::MatrixXd metric_of(const NonlinearProgram& program);
/// sqrt(d.metric.d), and its dual sqrt(g.metric^-1.g).
double metric_norm(const NonlinearProgram& program, const Eigen::VectorXd& d);
double dual_norm(const NonlinearProgram& program, const Eigen::VectorXd& g);

/// Sum of the constraint violations.
double total_violation(const NonlinearProgram& program, const Eigen::VectorXd& constraints);
double largest_violation(const NonlinearProgram& program, const Eigen::VectorXd& constraints);

}  // namespace strake
