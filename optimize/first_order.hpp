#pragma once
#include "optimize/minimizer.hpp"

/// First-order conditions at a point. Internal.
namespace strake {

Eigen::VectorXd values_of(const Sample& sample);  ///< the objective (first) and the constraints

struct ActiveSet {
    std::vector<Eigen::Index> rows;       ///< constraints that may have a multiplier
    std::vector<Eigen::Index> variables;  ///< whose conditions count: no bound holds them
};

/// Multipliers m that make gradient + jacobian^T m least in the norm of the inverse metric (n x n), zero outside of the
/// set; of an inequality (the first rows) >= 0, else it is dropped once.
Eigen::VectorXd least_squares_multipliers(const Eigen::MatrixXd& metric, const Eigen::VectorXd& gradient,
                                          const Eigen::MatrixXd& jacobian, int num_inequalities, const ActiveSet& set);

/// Least-squares multipliers of the constraints that are active or nearly so (a short step in the metric leads there),
/// by the variables that no bound holds: at the others the bound takes a share. `sample` is that at x, differentiated.
Eigen::VectorXd multipliers(const NonlinearProgram& program, const Eigen::VectorXd& x, const Sample& sample);

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
