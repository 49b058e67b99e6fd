#include "optimize/least_squares/least_squares.hpp"

#include "core/error.hpp"

#include <ceres/ceres.h>
#include <glog/logging.h>
#include <limits>

namespace strake {
namespace {

using Eigen::VectorXd;

constexpr int line_search_steps = 3;  ///< along a step that was projected onto the bounds

/// Ceres' own library must neither print nor write log files (it logs to stderr or /tmp by default).
void silence_glog() {
    FLAGS_logtostderr = true;
    FLAGS_minloglevel = google::GLOG_FATAL;
    FLAGS_stderrthreshold = google::GLOG_FATAL;
}

/// Everything that Ceres would answer with an abort.
void validate(const LeastSquares& p, const LeastSquaresOptions& o) {
    if (p.start.size() < 1 || p.num_residuals < 1)
        throw InvalidInput(text("least squares: ", p.start.size(), " variables and ", p.num_residuals,
                                " residuals; there must be at least one of each"));
    if (p.lower.size() != p.start.size() || p.upper.size() != p.start.size())
        throw InvalidInput("least squares: start and bounds differ in size");
    for (Eigen::Index j = 0; j < p.start.size(); ++j)
        if (!(p.lower[j] <= p.start[j] && p.start[j] <= p.upper[j]) || !std::isfinite(p.start[j]))
            throw InvalidInput(text("least squares: start ", p.start[j], " of variable ", j, " must lie in [",
                                    p.lower[j], ", ", p.upper[j], "]"));
    if (o.max_iterations < 0 || o.max_failures < 1 || !(o.radius > 0) || !(o.objective_tolerance >= 0) ||
        !(o.step_tolerance >= 0))
        throw InvalidInput(text("least squares: iterations ", o.max_iterations, ", failures ", o.max_failures,
                                ", radius ", o.radius, ", tolerances ", o.objective_tolerance, " and ",
                                o.step_tolerance, "; a limit is below its least value"));
}

/// What stands between Ceres and the caller's functions.
struct Watch {
    const LeastSquares& problem;
    const LeastSquaresOptions& options;
    VectorXd best_x = problem.start;
    double best = std::numeric_limits<double>::infinity();
    int failures = 0;  ///< trials in a row
    bool stopped = false;
    std::exception_ptr exception = nullptr;

    bool evaluate(const double* at, double* residuals, double* jacobian) {
        try {
            if (exception) return false;
            const VectorXd x = VectorXd::Map(at, problem.start.size());
            VectorXd r;
            RowMajorMatrix J;
            bool ok = x.allFinite() && problem.evaluate(x, r, jacobian ? &J : nullptr) &&
                      r.size() == problem.num_residuals && r.allFinite() && std::isfinite(r.squaredNorm());
            if (ok && jacobian) ok = J.rows() == r.size() && J.cols() == x.size() && J.allFinite();
            failures = ok ? 0 : failures + 1;
            if (!ok) return false;
            VectorXd::Map(residuals, r.size()) = r;
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

class Cost : public ceres::CostFunction {
public:
    explicit Cost(Watch& watch) : watch_(watch) {
        set_num_residuals(watch.problem.num_residuals);
        mutable_parameter_block_sizes()->push_back(static_cast<int>(watch.problem.start.size()));
    }
    bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
        return watch_.evaluate(x[0], residuals, jacobians ? jacobians[0] : nullptr);
    }

private:
    Watch& watch_;
};

class AfterIteration : public ceres::IterationCallback {
public:
    explicit AfterIteration(Watch& watch) : watch_(watch) {}
    ceres::CallbackReturnType operator()(const ceres::IterationSummary& step) override {
        return watch_.go_on(step.iteration) ? ceres::SOLVER_CONTINUE : ceres::SOLVER_ABORT;
    }

private:
    Watch& watch_;
};

LeastSquaresStop stop_of(const Watch& watch, const ceres::Solver::Summary& summary) {
    if (!std::isfinite(watch.best)) return LeastSquaresStop::no_start;
    if (watch.stopped) return LeastSquaresStop::stopped;
    // Steps that were refused often enough are short: Ceres takes that for convergence.
    if (watch.failures > 1) return LeastSquaresStop::no_valid_step;
    if (summary.termination_type == ceres::CONVERGENCE) return LeastSquaresStop::converged;
    if (summary.termination_type == ceres::NO_CONVERGENCE) return LeastSquaresStop::limit;
    return LeastSquaresStop::no_better_step;
}

}  // namespace

LeastSquaresResult least_squares(const LeastSquares& problem, const LeastSquaresOptions& options) {
    validate(problem, options);
    silence_glog();
    Watch watch{problem, options};
    VectorXd x = problem.start;
    ceres::Problem ceres_problem;
    ceres_problem.AddResidualBlock(new Cost(watch), nullptr, x.data());
    for (int j = 0; j < static_cast<int>(x.size()); ++j) {
        ceres_problem.SetParameterLowerBound(x.data(), j, problem.lower[j]);
        ceres_problem.SetParameterUpperBound(x.data(), j, problem.upper[j]);
    }
    AfterIteration after(watch);
    ceres::Solver::Options how;
    how.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
    how.logging_type = ceres::SILENT;
    how.max_num_iterations = options.max_iterations;
    how.max_num_consecutive_invalid_steps = 10;
    how.function_tolerance = options.objective_tolerance;
    how.parameter_tolerance = options.step_tolerance;
    how.initial_trust_region_radius = options.radius;
    how.max_trust_region_radius = std::max(how.max_trust_region_radius, options.radius);
    how.gradient_tolerance = 0;  // has the unit of the objective; the two above decide
    how.num_threads = 1;
    how.max_num_line_search_step_size_iterations = line_search_steps;
    how.callbacks.push_back(&after);
    ceres::Solver::Summary summary;
    ceres::Solve(how, &ceres_problem, &summary);
    if (watch.exception) std::rethrow_exception(watch.exception);
    LeastSquaresResult result{watch.best_x, stop_of(watch, summary), options.radius};
    if (!summary.iterations.empty()) result.radius = summary.iterations.back().trust_region_radius;
    return result;
}

}  // namespace strake
