#include "optimize/fit.hpp"

#include "core/error.hpp"
#include "optimize/run_state.hpp"

#include <ceres/ceres.h>
#include <glog/logging.h>
#include <utility>

namespace strake {
namespace {

using Eigen::VectorXd;

/// Ceres' own library must neither print nor write log files (it logs to stderr or /tmp unless told otherwise).
void silence_glog() {
    FLAGS_logtostderr = true;
    FLAGS_minloglevel = google::GLOG_FATAL;
    FLAGS_stderrthreshold = google::GLOG_FATAL;
}

/// Slow iterations in a row that are borne on the last level, where there is nothing to refine.
constexpr int patience_on_last_level = 10;
constexpr int line_search_steps = 3;  ///< along a step that was projected onto the bounds

constexpr double first_radius = 3;  ///< Ceres' damping is 1 / radius of the squared column norms

/// Share of the first root mean square residual that is as good as zero.
constexpr double recovered = 1e-8;

class Fit {
public:
    Fit(const Problem& problem, const RunEvents& events) : state_(problem, events, {}) {
        if (problem.fit.empty()) throw InvalidInput("the case has nothing to fit: give fit: [quantity, ...]");
        for (const std::string& name : problem.fit) {
            const Quantity* found = nullptr;
            for (const Quantity& quantity : problem.quantities)
                if (quantity.names.size() == 1 && quantity.names[0] == name) found = &quantity;
            state_.evaluator.index_of(name);  // throws with the known names
            if (!found || !found->residuals)
                throw InvalidInput(
                    text("quantity '", name, "' has no residuals and cannot be fitted; use target_shape"));
            fitted_.push_back(found);
        }
        for (const VariableKind kind : problem.parameters.kinds)
            if (kind == VariableKind::stiffness)
                throw InvalidInput("stiffness variables cannot be fitted; use load, load_normal or strain");
    }

    RunResult run() {
        VectorXd x;
        bool any = false;
        do {
            x = state_.next_level(x);
            if (state_.space.size() == 0) {
                state_.end_level("no variable of this level moves anything");
                continue;
            }
            any = true;
            x = run_level(x);
            state_.end_level(words_);
        } while (!failed_ && state_.space.level < state_.last_level() && state_.evaluations_left() > 0 &&
                 state_.seconds_left() > 0);
        if (!any) throw InvalidInput("nothing to fit: no variable of any level moves anything; is all of it fixed?");
        conclude();
        return state_.result;
    }

    /// Residuals and Jacobian (rows x size(), row-major) at x; false where there are none.
    bool evaluate(const VectorXd& x, double* residuals, double* jacobian) {
        try {
            if (!(current_x_.size() == x.size() && current_x_ == x)) {
                if (out_of_budget()) return false;
                measure(x);
            }
            if (!ok_) return false;
            VectorXd::Map(residuals, num_residuals()) = residual_;
            if (jacobian) differentiate(jacobian);
            return true;
        } catch (...) {
            exception_ = std::current_exception();
            return false;
        }
    }

    int num_residuals() const { return 3 * state_.rest->surface.num_vertices() * static_cast<int>(fitted_.size()); }
    int num_variables() const { return state_.space.size(); }

    /// Called by Ceres after every iteration.
    ceres::CallbackReturnType go_on(const ceres::IterationSummary& step) {
        if (exception_ || failed_ || out_of_budget_) return ceres::SOLVER_ABORT;
        const double rms = std::sqrt(state_.level_best_objective);
        if (first_rms_ < 0) first_rms_ = rms;
        if (step.iteration == 0) previous_rms_ = rms;
        if (rms <= recovered * first_rms_ || rms == 0) {
            is_recovered_ = true;
            return ceres::SOLVER_TERMINATE_SUCCESSFULLY;
        }
        if (step.iteration == 0) return ceres::SOLVER_CONTINUE;
        // At active bounds Ceres projects its step, which may go on for long with little gain.
        const double before = std::exchange(previous_rms_, rms);
        const bool last = state_.space.level == state_.last_level();
        const bool slow = before - rms < state_.problem.optimize.progress_below * before;
        slow_iterations_ = slow ? slow_iterations_ + 1 : 0;
        if (slow_iterations_ < (last ? patience_on_last_level : 1)) return ceres::SOLVER_CONTINUE;
        slackened_ = true;
        return ceres::SOLVER_TERMINATE_SUCCESSFULLY;
    }

private:
    bool out_of_budget() {
        out_of_budget_ = state_.result.evaluations - state_.result.levels.back().evaluations >= level_budget_ ||
                         state_.seconds_left() <= 0;
        return out_of_budget_;
    }

    void measure(const VectorXd& x) {
        current_x_ = x;
        current_ = state_.evaluate(x);
        ok_ = current_.status == EvaluationStatus::ok;
        failed_ |= current_.status == EvaluationStatus::quantity_failed;
        Rank rank;
        double objective = std::numeric_limits<double>::quiet_NaN();
        if (ok_) {
            const TriMesh surface = with_vertices(state_.rest->surface, current_.vertices);
            const int rows = 3 * surface.num_vertices();
            residual_.resize(num_residuals());
            dr_dv_.clear();
            for (std::size_t i = 0; i < fitted_.size(); ++i) {
                PointResiduals r = fitted_[i]->residuals(surface);
                residual_.segment(static_cast<Eigen::Index>(i) * rows, rows) = VectorXd::Map(r.r.data(), rows);
                dr_dv_.push_back(std::move(r.dr_dv));
            }
            if (!residual_.allFinite()) throw SolverError("a residual of the fit is not finite");
            objective = residual_.squaredNorm();
            rank = {true, 0, objective};
        } else if (state_.result.best_evaluation == 0 || failed_) {
            words_ = current_.reason;
        }
        if (state_.record(x, current_, objective, rank, {})) level_x_ = x;
    }

    /// dr/dx column by column from dv/dx at the equilibrium of the last evaluation.
    void differentiate(double* jacobian) {
        using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
        Eigen::Map<RowMajor> J(jacobian, num_residuals(), num_variables());
        const int n = state_.rest->surface.num_vertices();
        design_response(state_.space, state_.evaluator.shell(), [&](int j, const Points& dv) {
            if (!dv.allFinite()) throw SolverError("the response to a variable is not finite");
            for (std::size_t i = 0; i < dr_dv_.size(); ++i)
                for (int k = 0; k < n; ++k)
                    J.block<3, 1>(3 * (static_cast<Eigen::Index>(i) * n + k), j) = dr_dv_[i][k] * dv.row(k).transpose();
        });
    }

    VectorXd run_level(const VectorXd& start);

    void conclude() {
        RunResult& r = state_.result;
        const int level = state_.space.level;
        r.level = level;
        if (failed_) {
            r.status = "evaluation_failed";
            r.reason = text("evaluation ", r.evaluations, ": ", words_);
            return;
        }
        if (r.best_evaluation == 0) {
            r.status = "failed";
            r.reason = text(words_, "; reduce the given loads and strains, or fix less");
            return;
        }
        const double explained = 100 * (1 - std::sqrt(r.objective / r.objective_start));
        const std::string found =
            r.objective_start > 0 ? text("the fit explains ", explained, " % of the difference; ") : std::string();
        const bool on_last = level == state_.last_level() || is_recovered_;
        r.status = converged_ && on_last ? "converged"
                   : out_of_budget_      ? "budget"
                   : slackened_          ? "progress"
                                         : "roundoff";
        r.reason =
            text(found, words_, " on level ", level, r.status == "budget" ? "; raise optimize.budget to go on" : "");
    }

    RunState state_;
    std::vector<const Quantity*> fitted_;
    ShapeEvaluation current_;
    VectorXd current_x_, level_x_, residual_;
    std::vector<std::vector<Eigen::Matrix3d>> dr_dv_;
    bool ok_ = false, failed_ = false, out_of_budget_ = false, slackened_ = false, converged_ = false,
         is_recovered_ = false;
    int level_budget_ = 0, slow_iterations_ = 0;
    double radius_ = first_radius, first_rms_ = -1, previous_rms_ = 0;
    std::string words_;
    std::exception_ptr exception_;
};

/// Ceres' view of the fit: one block of all variables, one block of all residuals.
class AllResiduals : public ceres::CostFunction {
public:
    explicit AllResiduals(Fit& fit) : fit_(fit) {
        set_num_residuals(fit.num_residuals());
        mutable_parameter_block_sizes()->push_back(fit.num_variables());
    }
    bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
        return fit_.evaluate(VectorXd::Map(parameters[0], fit_.num_variables()), residuals,
                             jacobians ? jacobians[0] : nullptr);
    }

private:
    Fit& fit_;
};

class AfterIteration : public ceres::IterationCallback {
public:
    explicit AfterIteration(Fit& fit) : fit_(fit) {}
    ceres::CallbackReturnType operator()(const ceres::IterationSummary& step) override { return fit_.go_on(step); }

private:
    Fit& fit_;
};

VectorXd Fit::run_level(const VectorXd& start) {
    const OptimizeOptions& how = state_.problem.optimize;
    level_budget_ = std::max(1, state_.evaluations_left() / (state_.last_level() - state_.space.level + 1));
    slackened_ = converged_ = is_recovered_ = false;
    current_x_.resize(0);
    VectorXd x = start;
    level_x_ = start;
    slow_iterations_ = 0;
    ceres::Problem problem;
    problem.AddResidualBlock(new AllResiduals(*this), nullptr, x.data());
    for (int j = 0; j < num_variables(); ++j) {
        problem.SetParameterLowerBound(x.data(), j, state_.space.lower[j]);
        problem.SetParameterUpperBound(x.data(), j, state_.space.upper[j]);
    }
    AfterIteration after(*this);
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
    options.logging_type = ceres::SILENT;
    options.max_num_iterations = level_budget_;
    options.max_num_consecutive_invalid_steps = 10;
    options.function_tolerance = how.objective_tolerance;
    options.parameter_tolerance = how.step_tolerance;
    // Ceres' own start is a full Gauss-Newton step, on a soft surface far too long.
    options.initial_trust_region_radius = radius_;
    options.gradient_tolerance = 0;  // has the unit of the objective; the two above decide
    options.num_threads = 1;
    options.max_num_line_search_step_size_iterations = line_search_steps;
    options.callbacks.push_back(&after);
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    if (exception_) std::rethrow_exception(exception_);
    if (!summary.iterations.empty())
        radius_ = std::clamp(summary.iterations.back().trust_region_radius, first_radius, 1e3 * first_radius);
    converged_ = (summary.termination_type == ceres::CONVERGENCE && !slackened_) || is_recovered_;
    if (out_of_budget_)
        words_ = text("the limit of evaluations or time is reached");
    else if (is_recovered_)
        words_ = "the target is recovered to round-off";
    else if (slackened_)
        words_ = text("an iteration removed less than ", 100 * how.progress_below, " % of the residual");
    else if (converged_)
        words_ = "residual and variables change by less than the tolerances";
    else if (state_.result.best_evaluation > 0 && !failed_)
        words_ = "the solver found no better step";
    return level_x_;
}

}  // namespace

RunResult fit(const Problem& problem, const RunEvents& events) {
    silence_glog();
    return Fit(problem, events).run();
}

}  // namespace strake
