#pragma once
#include "optimize/finite_differences.hpp"
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
    /// With a failure: it tells of the way to this x rather than of x (a solve that did not converge from where it
    /// began), and so nothing of where others fail.
    bool is_of_step = false;
    bool is_partly_guessed = false;  ///< the gradient: not all of its differences were paid
};

/// What is known of the gradient at the start of a program with differences.
struct StartGradient {
    Eigen::VectorXd gradient;
    Eigen::MatrixXd jacobian;
    Eigen::MatrixXd details;  ///< n x k: the slopes along these are not known yet
    Eigen::MatrixXd doubt;    ///< columns: gradients by which what is known may be off; empty: none
};

struct NonlinearProgram {
    Eigen::VectorXd start, lower, upper;
    int num_inequalities = 0, num_equalities = 0;
    std::function<Sample(const Eigen::VectorXd& x)> evaluate;
    /// Adds the gradients to the sample of the last `evaluate`, which was at this x. Not called by local gradient-free
    /// methods; by global ones for the polish at their end. Empty: differences.
    std::function<void(const Eigen::VectorXd& x, Sample& sample)> differentiate;
    /// Told the points that will be evaluated next, in this order, where they are known before: all of a gradient by
    /// differences. May be empty.
    std::function<void(const std::vector<Eigen::VectorXd>& points)> expect;
    /// Gradients that are made of differences, instead of what `differentiate` gave for them (if there is one).
    std::optional<Differences> differences;
    /// n x n, positive definite: the size of a step d is sqrt(d.metric.d), about 1 for the largest reasonable one.
    /// Empty: the identity.
    Eigen::MatrixXd metric;
    /// The metric as it is at x, times d: near buckling some directions become long. May be empty, and may return an
    /// empty vector. Cheap beside an evaluation. Used by slsqp.
    std::function<Eigen::VectorXd(const Eigen::VectorXd& x, const Eigen::VectorXd& d)> present_metric;
    /// n x n, positive definite: what is known of the Lagrangian's Hessian at the start. Empty: nothing. Used by slsqp.
    Eigen::MatrixXd hessian;
    /// The part of it, positive semidefinite, whose shape is known and whose size is a guess. Empty: none.
    Eigen::MatrixXd guessed;
    /// Of the gradient at the start, where differences make it. Used by slsqp.
    std::optional<StartGradient> start_gradient;
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
    double objective_scale = 0;          ///< what changes are relative to where the objective is smaller; slsqp
    double step_tolerance = 1e-6;        ///< change of every variable
    double constraint_tolerance = 1e-6;  ///< scaled
    int max_shrinks = 8;                 ///< cuts of the step after failures in a row
    int max_failures = 12;               ///< slsqp: in all; others: four times max_shrinks
    double first_step = 0.5;             ///< in the metric
    bool confirm = true;                 ///< converged only when a fresh start at the end gains nothing more
    int starts =
        1;  ///< the given one, then random ones within the bounds (which must be finite); they share the budget
    unsigned seed = 1;                                 ///< of random starts and of NLopt's random methods
    bool exceptions_are_failures = false;              ///< of the callbacks; except InvalidInput and std::bad_alloc
    std::function<bool(const MinimizeStep&)> on_step;  ///< return false to stop here; not told of differences
    /// slsqp: the decrease that the model still expects, and its Hessian, told at every differentiated point that meets
    /// the constraints nearly; return false to stop here.
    std::function<bool(double expected, const Eigen::MatrixXd& hessian)> on_model;
    std::function<void(const std::string&)> on_event;  ///< restarts, starts and box changes, in words
    std::function<double()> clock;                     ///< seconds, for max_seconds; empty: the wall clock
};

enum class MinimizeStop {
    converged,
    roundoff,     ///< the algorithm can do no more in double precision: usable
    evaluations,  ///< limit
    time,         ///< limit
    stopped,      ///< on_step said so
    outpaced,     ///< on_model said so
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
    int failures = 0;  ///< evaluations without a value, or whose gradient failed
    /// Rows of the constraints that cannot be met together within the bounds, to first order at the point of least
    /// violation: without any one of them the others could. Empty: none found.
    std::vector<int> conflict;
    /// Steps were rejected however short, and the values change by `slope_ratio` of what the gradient says, by
    /// differences along `slope_of` (-1: the objective, else a row of the constraints).
    bool gradient_inconsistent = false;
    double slope_ratio = std::numeric_limits<double>::quiet_NaN();
    int slope_of = -1;
    int active_bounds = 0;    ///< variables that a bound keeps from a better value (without gradients: that lie at one)
    bool is_flat = false;     ///< no evaluation gave another objective, or its gradient is zero at a start
    double radius = 0;        ///< slsqp: the last length of step that was allowed
    Eigen::MatrixXd hessian;  ///< slsqp: model of the Lagrangian's Hessian at the end, n x n; empty: none
    Eigen::MatrixXd doubt;    ///< slsqp: columns, by which the gradient of `best` may be off; empty: none
};

/// Minimizes from `start` within the bounds. Variables with equal bounds are removed first. Every x is evaluated once,
/// however often the algorithm asks. Constraints that the method cannot take go into an augmented Lagrangian around it.
/// Exceptions of the callbacks come out unchanged.
/// @throws InvalidInput: sizes, start outside bounds, a global method or several starts without finite bounds.
MinimizeResult minimize(const NonlinearProgram& program, const MinimizeOptions& options);

}  // namespace strake
