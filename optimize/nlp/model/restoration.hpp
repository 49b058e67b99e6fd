#pragma once
#include "optimize/nlp/program/guard.hpp"

/// Steps onto the constraints. Internal.
namespace strake {

struct Restoration {
    enum class End {
        feasible,
        stationary,  ///< to first order no step reduces all violations
        limited      ///< by the guard, failures, or the number of steps
    } end = End::limited;
    Eigen::VectorXd x;
    Evaluation evaluation;  ///< at x; with the Jacobian when stationary
};

/// Gauss-Newton steps (shortest in the metric) from x towards the constraints within the bounds, each reducing the sum
/// of the violations; a Jacobian is kept while its steps halve it. The guard ranks these points like all others.
Restoration restore_feasibility(Guard& guard, const Eigen::VectorXd& from, int max_steps);

}  // namespace strake
