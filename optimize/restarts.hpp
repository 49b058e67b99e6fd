#pragma once
#include "optimize/nlopt_run.hpp"

/// NLopt's algorithms started anew after failures and to confirm their ends. Internal.
namespace strake {

struct SearchEnd {
    MinimizeStop stop = MinimizeStop::failed;
    std::string reason;
    int shrinks = 0;
    double radius = 0;          ///< slsqp: of the trust region
    Eigen::VectorXd x;          ///< where the algorithm ended, which need not be feasible
    Sample at;                  ///< with a Lagrangian: values there
    bool is_at_border = false;  ///< of what fails; a search that knows it may go on
    bool is_final = true;       ///< false: the guard's limit of evaluations, which may be for a part of the search only
};

struct RestartOptions {
    double objective_tolerance, step_tolerance;
    int max_shrinks;  ///< in a row, without a better point between them; four times as many in all
    int confirmations;
};

/// Runs the method from `start` (evaluated before). After a failure it is started again at the best point with the box
/// of allowed x halved, which grows again when the best point lies on its border or the algorithm has converged inside.
/// An end is believed when a fresh start from there gains nothing. With a Lagrangian "best" is what has its least
/// value, else the guard's best.
SearchEnd run_with_restarts(Guard& guard, const MethodFacts& method, const Lagrangian* lagrangian,
                            const Eigen::VectorXd& start, const RestartOptions& options);

/// The words for `guard.cause`, when the search ended by it.
SearchEnd end_by_cause(const Guard& guard);

/// So that the first step of a method that starts with a unit Hessian has the wanted length.
double objective_scale(const Guard& guard);

}  // namespace strake
