#pragma once
#include "optimize/least_squares/least_squares.hpp"

#include <exception>
#include <limits>

/// Internal to least_squares: what its two searches share.
namespace strake {

/// What stands between a search and the caller's functions: counts failures, keeps the best point and what was thrown.
struct LeastSquaresWatch {
    const LeastSquares& problem;
    const LeastSquaresOptions& options;
    Eigen::VectorXd best_x = problem.start;
    double best = std::numeric_limits<double>::infinity();
    int failures = 0;  ///< trials in a row
    bool stopped = false;
    std::exception_ptr exception = nullptr;

    bool evaluate(const double* at, double* residuals, double* jacobian) {
        try {
            if (exception) return false;
            const Eigen::VectorXd x = Eigen::VectorXd::Map(at, problem.start.size());
            Eigen::VectorXd r;
            RowMajorMatrix J;
            bool ok = x.allFinite() && problem.evaluate(x, r, jacobian ? &J : nullptr) &&
                      r.size() == problem.num_residuals && r.allFinite() && std::isfinite(r.squaredNorm());
            if (ok && jacobian) ok = J.rows() == r.size() && J.cols() == x.size() && J.allFinite();
            failures = ok ? 0 : failures + 1;
            if (!ok) return false;
            Eigen::VectorXd::Map(residuals, r.size()) = r;
            if (jacobian) Eigen::Map<RowMajorMatrix>(jacobian, J.rows(), J.cols()) = J;
            if (r.squaredNorm() < best) best = r.squaredNorm(), best_x = x;
            return true;
        } catch (...) {
            exception = std::current_exception();
            return false;
        }
    }

    bool go_on(int iteration) {
        try {
            if (exception || failures >= options.max_failures) return false;
            if (problem.go_on && !problem.go_on(iteration)) stopped = true;
        } catch (...) {
            exception = std::current_exception();
        }
        return !exception && !stopped;
    }
};

/// How a search ended by its own measures.
enum class LeastSquaresEnd { converged, limit, other };

/// One of these is linked: Ceres, or our own (STRAKE_GPL off). @return how it ended; `radius`: at the end.
LeastSquaresEnd search_least_squares(LeastSquaresWatch& watch, double& radius);
/// Our own, always there: Levenberg-Marquardt in the scaling of More (1978), with Nielsen's rule for the damping, steps
/// projected onto the bounds and shortened along the projection.
LeastSquaresEnd levenberg_marquardt(LeastSquaresWatch& watch, double& radius);

/// The contract of least_squares(), with a search of choice.
LeastSquaresResult least_squares_by(LeastSquaresEnd (*search)(LeastSquaresWatch&, double&), const LeastSquares& problem,
                                    const LeastSquaresOptions& options);

}  // namespace strake
