#pragma once
#include "optimize/nlp/program/nonlinear_program.hpp"

/// First-order conditions at a point. Internal.
namespace strake {

Eigen::VectorXd values_of(const Evaluation& evaluation);  ///< the objective (first) and the constraints

struct ActiveSet {
    std::vector<Eigen::Index> rows;       ///< constraints that may have a multiplier
    std::vector<Eigen::Index> variables;  ///< whose conditions count: not at an active bound
};

/// Multipliers m that minimize gradient + jacobian^T m in the norm of the inverse metric (n x n), zero outside the set.
/// Inequalities (the first rows) with a negative multiplier are dropped once; where others become negative by that, or
/// rows depend on each other, the multipliers of inequalities are the non-negative ones that minimize it.
Eigen::VectorXd least_squares_multipliers(const Eigen::MatrixXd& metric, const Eigen::VectorXd& gradient,
                                          const Eigen::MatrixXd& jacobian, int num_inequalities, const ActiveSet& set);

/// Least-squares multipliers of the constraints that are active or nearly so (a short step in the metric leads there),
/// by the variables that are not at an active bound, because there the bound carries part of the gradient.
/// `evaluation` is that at x, differentiated.
Eigen::VectorXd multipliers(const NonlinearProgram& program, const Eigen::VectorXd& x, const Evaluation& evaluation);

/// The same with those of the limits near x (`Evaluation::limits`), which carry part of the gradient, too.
struct Multipliers {
    Eigen::VectorXd constraints, limits;
};
Multipliers all_multipliers(const NonlinearProgram& program, const Eigen::VectorXd& x, const Evaluation& evaluation);
/// By the active set of the constraints, and by those limits that a short step in the metric reaches.
Multipliers all_multipliers(const Eigen::MatrixXd& metric, const Evaluation& evaluation, int num_inequalities,
                            const ActiveSet& set);

/// gradient + jacobian^T multipliers + slopes^T multipliers of the limits.
Eigen::VectorXd lagrangian_gradient(const NonlinearProgram& program, const Eigen::VectorXd& x,
                                    const Evaluation& evaluation);

/// Variable j is at a bound (to rounding) and the direction leads out.
bool leaves_bounds(const NonlinearProgram& program, const Eigen::VectorXd& x, Eigen::Index j, double direction);

/// Direction of a first step: -metric^-1 (gradient + jacobian^T multipliers), without components that leave the bounds.
Eigen::VectorXd descent_direction(const NonlinearProgram& program, const Eigen::VectorXd& x,
                                  const Evaluation& evaluation);

/// The program's metric, n x n: the identity where it names none.
Eigen::MatrixXd metric_of(const NonlinearProgram& program);
/// sqrt(d.metric.d), and its dual sqrt(g.metric^-1.g).
double metric_norm(const NonlinearProgram& program, const Eigen::VectorXd& d);
double dual_norm(const NonlinearProgram& program, const Eigen::VectorXd& g);

/// Sum of the constraint violations.
double total_violation(const NonlinearProgram& program, const Eigen::VectorXd& constraints);
double largest_violation(const NonlinearProgram& program, const Eigen::VectorXd& constraints);

}  // namespace strake
