#pragma once
#include "optimize/minimizer.hpp"

#include <vector>

/// Steps that try whether a border of failing evaluations lies as it is thought to. Internal.
namespace strake {

/// At a point x where steps down the gradient fail, the border is thought to be across the gradient; where it is not,
/// half of the steps along it, tilted a little down, give values and gain. Steps in opposite pairs, each along another
/// tangent of what is active at x (at most `pairs`, the same for the same problem), each as long and as tilted as the
/// model `hessian` needs to promise `gain` > 0. Within the bounds; none where nothing is free beside the gradient.
std::vector<Eigen::VectorXd> border_probes(const NonlinearProgram& program, const Eigen::VectorXd& x,
                                           const Sample& sample, const Eigen::MatrixXd& hessian, double gain,
                                           int pairs);

}  // namespace strake
