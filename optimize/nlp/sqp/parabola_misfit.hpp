#pragma once
#include "optimize/nlp/sqp/iterate.hpp"

/// How little a step of the search looks like one along a parabola. Internal.
namespace strake {

/// Along a parabola the Lagrangian changes by the mean of its slopes at both ends of a step, times its length (the
/// trapezoidal rule). Returns by how much it does not, as a share of the larger slope's part: 0 for a parabola, at most
/// 1/2 where it is convex and falls all the way, and independent of units of variables and values. Where the step leads
/// across waves it is large, where it follows a smooth valley of nearly constant curvature it is a few per cent.
/// @param there the step's end, with gradients @param multipliers of the constraints, of both ends
double parabola_misfit(const SqpIterate& now, const Evaluation& there, const Eigen::VectorXd& multipliers,
                       const Eigen::VectorXd& step);

}  // namespace strake
