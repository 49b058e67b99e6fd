#pragma once
#include "optimize/minimizer.hpp"

#include <chrono>
#include <exception>

/// What stands between NLopt and a nonlinear program: evaluates every x once, refuses NaN, keeps the cause of every
/// failure and the best point seen. Used by minimize() only.
namespace strake {

/// Why the guard ended NLopt.
enum class Cause { none, failure, fatal, evaluations, time, stopped, asked_nonfinite, exception };

/// The guard stops NLopt by this; it must not meet another type of exception.
class Guard {
public:
    Guard(const NonlinearProgram& program, const MinimizeOptions& options);

    /// Sample at the free variables `z`. @throws nlopt::forced_stop with `cause` set when there is none.
    const Sample& at(const double* z, bool gradient);
    const Sample& at_all(const Eigen::VectorXd& x, bool gradient);  ///< the same for all variables

    const NonlinearProgram& program;
    const MinimizeOptions& options;
    std::vector<int> free;  ///< numbers of the variables whose bounds differ
    bool wants_gradient = true;
    double scale = 1;    ///< NLopt sees objective / scale
    double penalty = 0;  ///< of a unit of violation, in the merit that is told
    double best_merit = std::numeric_limits<double>::infinity();
    Eigen::VectorXd best_x;
    Sample best;
    bool has_best = false, best_feasible = false;
    double best_violation = 0;
    Cause cause = Cause::none;
    std::exception_ptr exception;
    std::string failure;
    Eigen::VectorXd failed_x;
    int evaluations = 0;

private:
    [[noreturn]] void stop(Cause why);
    const Sample& sample_at(const Eigen::VectorXd& x, bool gradient);
    void evaluate(const Eigen::VectorXd& x);
    void rank(const Eigen::VectorXd& x);
    void differentiate(const Eigen::VectorXd& x);
    bool tell(const MinimizeStep& step) const { return !options.on_step || options.on_step(step); }

    Sample last_;
    Eigen::VectorXd last_x_;
    std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

}  // namespace strake
