#pragma once
#include "optimize/nlp/program/nonlinear_program.hpp"

/// Which constraints exclude each other. Internal.
namespace strake {

/// A set of constraints that cannot be met together, linearized at x within the bounds; without any one of its rows the
/// others can. Rows that are inactive at the minimum common violation are dropped, then a deletion filter (Chinneck &
/// Dravnieks 1991) goes over the rest. Empty: all can be met together, to first order.
/// `evaluation` has the Jacobian.
std::vector<int> conflicting_constraints(const NonlinearProgram& program, const Eigen::VectorXd& x,
                                         const Evaluation& evaluation, double tolerance);

}  // namespace strake
