#pragma once
#include "optimize/nlp/nlopt/nlopt_run.hpp"

/// Restarts NLopt's algorithms after failures and to confirm their ends. Internal.
namespace strake {

struct SearchEnd {
    MinimizeStop stop = MinimizeStop::failed;
    std::string reason;
    int shrinks = 0;
    Eigen::VectorXd x;          ///< where the algorithm ended, feasible or not
    Evaluation at;              ///< with a Lagrangian: values there
    bool is_at_border = false;  ///< of what fails; sqp may go on along it
    bool is_final = true;       ///< false: the guard's limit of evaluations, which may be for a part of the search only
};

struct RestartOptions {
    double objective_tolerance, step_tolerance;
    int max_shrinks;  ///< in a row, without a better point between them
    int confirmations;
};

/// Runs the method from `start` (evaluated before). A failure restarts it at the best point with the box of allowed x
/// halved; the box grows again when the best point lies on its side or the algorithm has converged inside. An end is
/// final when a fresh start from there gains nothing. With a Lagrangian the best point is that of its lowest value,
/// otherwise the guard's.
SearchEnd run_with_restarts(Guard& guard, const MethodFacts& method, const Lagrangian* lagrangian,
                            const Eigen::VectorXd& start, const RestartOptions& options);

/// Stop and reason for `guard.cause`, when the search ended by it.
SearchEnd end_by_cause(const Guard& guard);

/// With this scale, the first step of a method that starts with a unit Hessian has the length `first_step`.
double objective_scale(const Guard& guard);

}  // namespace strake
