#pragma once
#include "optimize/minimizer.hpp"

/// Which constraints exclude each other. Internal.
namespace strake {

/// The smallest set, in the sense that without any one of its rows the others could be met, among the constraints
/// linearized at x within the bounds: what is inactive at the least common violation is left out, then a deletion
/// filter (Chinneck & Dravnieks 1991) goes over the rest. Empty: together they can be met, to first order.
/// `sample` has the Jacobian.
std::vector<int> conflicting_constraints(const NonlinearProgram& program, const Eigen::VectorXd& x,
                                         const Sample& sample, double tolerance);

}  // namespace strake
