#include "optimize/least_squares/least_squares_watch.hpp"

#include <ceres/ceres.h>
#include <glog/logging.h>

namespace strake {
namespace {

constexpr int line_search_steps = 3;  ///< along a step that was projected onto the bounds

/// Ceres' own library must neither print nor write log files (it logs to stderr or /tmp by default).
void silence_glog() {
    FLAGS_logtostderr = true;
    FLAGS_minloglevel = google::GLOG_FATAL;
    FLAGS_stderrthreshold = google::GLOG_FATAL;
}

class Cost : public ceres::CostFunction {
public:
    explicit Cost(LeastSquaresWatch& watch) : watch_(watch) {
        set_num_residuals(watch.problem.num_residuals);
        mutable_parameter_block_sizes()->push_back(static_cast<int>(watch.problem.start.size()));
    }
    bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
        return watch_.evaluate(x[0], residuals, jacobians ? jacobians[0] : nullptr);
    }

private:
    LeastSquaresWatch& watch_;
};

class AfterIteration : public ceres::IterationCallback {
public:
    explicit AfterIteration(LeastSquaresWatch& watch) : watch_(watch) {}
    ceres::CallbackReturnType operator()(const ceres::IterationSummary& step) override {
        return watch_.go_on(step.iteration) ? ceres::SOLVER_CONTINUE : ceres::SOLVER_ABORT;
    }

private:
    LeastSquaresWatch& watch_;
};

}  // namespace

LeastSquaresEnd search_least_squares(LeastSquaresWatch& watch, double& radius) {
    silence_glog();
    const LeastSquares& problem = watch.problem;
    const LeastSquaresOptions& options = watch.options;
    Eigen::VectorXd x = problem.start;
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
    if (!summary.iterations.empty()) radius = summary.iterations.back().trust_region_radius;
    return summary.termination_type == ceres::CONVERGENCE      ? LeastSquaresEnd::converged
           : summary.termination_type == ceres::NO_CONVERGENCE ? LeastSquaresEnd::limit
                                                               : LeastSquaresEnd::other;
}

}  // namespace strake
