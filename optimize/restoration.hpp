#pragma once
#include "optimize/guard.hpp"

/// Onto the constraints. Internal.
namespace strake {

struct Restoration {
    enum class End {
        feasible,
        stationary,  ///< to first order no step reduces all violations
        gave_up      ///< the guard's limits, failures, or too many steps
    } end = End::gave_up;
    Eigen::VectorXd x;
    Sample sample;  ///< at x; with the Jacobian when stationary
};

/// Gauss-Newton steps (shortest in the metric) from x towards the constraints within the bounds, each reducing the sum
/// of the violations; a Jacobian serves as long as its steps halve it. Points are ranked by the guard as all others.
Restoration restore_feasibility(Guard& guard, const Eigen::VectorXd& from, int max_steps);

}  // namespace strake
