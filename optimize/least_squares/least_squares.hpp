#pragma once
#include <Eigen/Core>
#include <functional>

/// Ceres behind a guard. Ceres aborts on wrong input, logs through glog, calls a run whose every step failed converged,
/// and must not be left by an exception; nothing of that passes here.
namespace strake {

using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

struct LeastSquares {
    Eigen::VectorXd start, lower, upper;  ///< n; lower <= start <= upper
    int num_residuals = 0;
    /// r at x and, unless null, dr/dx (num_residuals x n). Returns false where there are none; then the step is
    /// shortened. Numbers that are not finite count as none.
    std::function<bool(const Eigen::VectorXd& x, Eigen::VectorXd& r, RowMajorMatrix* dr_dx)> evaluate;
    /// Asked after every iteration (0: the start); false ends the search. Empty: never.
    std::function<bool(int iteration)> go_on;
};

struct LeastSquaresOptions {
    int max_iterations = 100;           ///< >= 0
    double objective_tolerance = 1e-6;  ///< relative
    double step_tolerance = 1e-6;       ///< relative to |x|
    double radius = 1e4;                ///< of the first trust region: damping is 1/radius of the squared column norms
    int max_failures = 5;               ///< ends after so many trials without residuals in a row, >= 1
};

enum class LeastSquaresStop {
    converged,       ///< by a tolerance, and the last trials had residuals
    no_valid_step,   ///< the trials next to the best point have no residuals
    no_better_step,  ///< round-off, or the model is wrong
    stopped,         ///< by `go_on`
    limit,           ///< of iterations
    no_start         ///< no residuals at the start
};

struct LeastSquaresResult {
    Eigen::VectorXd x;  ///< the best point with residuals that we saw; the start if there was none
    LeastSquaresStop stop = LeastSquaresStop::no_start;
    double radius = 0;  ///< of the trust region at the end
};

/// Levenberg-Marquardt within bounds, dense normal equations, one thread: deterministic.
/// @throws InvalidInput for sizes, bounds or options that make no problem; what `evaluate` throws.
LeastSquaresResult least_squares(const LeastSquares& problem, const LeastSquaresOptions& options);

}  // namespace strake
