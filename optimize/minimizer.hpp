#pragma once
#include "optimize/problem.hpp"

#include <Eigen/Core>
#include <functional>
#include <string>

/// NLopt behind a guard. NLopt 2.7 swallows exceptions, accepts NaN with a positive code, can return a point that is
/// not its best, and runs away without limits; nothing of that passes here (DESIGN section 6).
namespace strake {

/// Values at one x. Constraints are scaled: inequalities g <= 0 first, then equalities h = 0.
struct Sample {
    double objective = std::numeric_limits<double>::quiet_NaN();
    Eigen::VectorXd constraints;
    Eigen::VectorXd gradient;  ///< empty until differentiated
    Eigen::MatrixXd jacobian;  ///< constraints x variables
    std::string failure;       ///< not empty: there is no value, and why
    bool is_fatal = false;     ///< with a failure: end instead of shrinking the step
};

struct NonlinearProgram {
    Eigen::VectorXd start, lower, upper;
    int num_inequalities = 0, num_equalities = 0;
    std::function<Sample(const Eigen::VectorXd& x)> evaluate;
    /// Adds the gradients to the sample of the last `evaluate`. Not called by gradient-free methods.
    std::function<void(const Eigen::VectorXd& x, Sample& sample)> differentiate;
    /// n x n, positive definite: the size of a step d is sqrt(d.metric.d), about 1 for the largest reasonable one.
    /// Empty: the identity.
    Eigen::MatrixXd metric;
};

/// One evaluation, told as it happens.
struct MinimizeStep {
    const Eigen::VectorXd& x;
    const Sample& sample;
    double violation = 0;  ///< largest scaled constraint violation
    bool is_best =
        false;  ///< the best point so far: feasible and lowest, or while none is feasible the least violation
    bool is_feasible = false;
    double merit = 0;  ///< least of objective + penalty * violations so far
};

struct MinimizeOptions {
    Method method = Method::slsqp;
    int max_evaluations = 200;           ///< >= 1
    double max_seconds = 0;              ///< 0: no limit
    double objective_tolerance = 1e-6;   ///< relative change
    double step_tolerance = 1e-6;        ///< change of every variable
    double constraint_tolerance = 1e-6;  ///< scaled
    int max_shrinks = 8;                 ///< cuts of the step after failures: in a row with slsqp, else in all
    int max_failures = 12;               ///< slsqp: in all
    double first_step = 0.5;             ///< in the metric
    bool confirm = true;                 ///< converged only when a fresh start at the end gains nothing more
    std::function<bool(const MinimizeStep&)> on_step;  ///< return false to stop here
    std::function<void(const std::string&)> on_event;  ///< restarts and box changes, in words
};

enum class MinimizeStop {
    converged,
    roundoff,     ///< the algorithm can do no more in double precision: usable
    evaluations,  ///< limit
    time,         ///< limit
    stopped,      ///< on_step said so
    blocked,      ///< failures remain however small the step
    failed        ///< the start or a fatal evaluation failed, or the algorithm broke down at once
};

struct MinimizeResult {
    Eigen::VectorXd x;  ///< the best point we saw; the start if nothing could be evaluated
    Sample best;
    double violation = 0;
    bool is_feasible = false;
    MinimizeStop stop = MinimizeStop::failed;
    std::string reason;  ///< one sentence
    int evaluations = 0, shrinks = 0;
    double radius = 0;  ///< slsqp: the last length of step that was allowed
};

/// Minimizes from `start` within the bounds. Variables with equal bounds are removed first. Every x is evaluated once,
/// however often the algorithm asks. Exceptions of the callbacks come out unchanged.
/// @throws InvalidInput: sizes, start outside bounds, a method that cannot take these constraints.
MinimizeResult minimize(const NonlinearProgram& program, const MinimizeOptions& options);

}  // namespace strake
