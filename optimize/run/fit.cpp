#include "optimize/run/fit.hpp"

#include "core/error.hpp"
#include "optimize/least_squares/fit_residuals.hpp"
#include "optimize/run/fit_verdict.hpp"
#include "optimize/run/run_state.hpp"
#include "optimize/run/run_verdict.hpp"

#include <utility>

namespace strake {
namespace {

using Eigen::VectorXd;

/// Slow iterations in a row that are borne: damped first steps of a level are slow, too, and on the last level there is
/// nothing to refine.
constexpr int fit_patience = 3, patience_on_last_level = 10;

constexpr double jacobian_tolerance = 1e-11;  ///< of Jacobians
constexpr double first_radius = 3;  ///< Ceres' own start is a full Gauss-Newton step, on a soft surface far too long

/// Share of the first root mean square residual that is as good as zero.
constexpr double recovered = 1e-8;

/// More than what separates two solutions of the same equilibrium.
constexpr double motion_slack = 5e-7;

class Fit {
public:
    Fit(const Problem& problem, const RunEvents& events, Journal* journal)
        : residuals_(problem), state_(problem, events, {}, journal) {
        if (!problem.program_parameters.empty())
            throw InvalidInput("a fit moves the shape alone, and has no variables beside it");
        for (const VariableKind kind : problem.parameters.kinds)
            if (kind == VariableKind::stiffness)
                throw InvalidInput("stiffness variables cannot be fitted; use load, normal or strain");
    }

    RunResult run() {
        state_.run([this] { walk(); });
        return std::move(state_.result);
    }

private:
    void walk() {
        state_.evaluator.limit_motion();
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
            while (end_ == FitEnd::budget && state_.limits_were_raised()) {
                state_.begin_level_again();
                x = run_level(x);
            }
            describe_level(state_.result.levels.back(), state_.level_best_objective, end_, words_);
            state_.end_level(state_.result.levels.back().stop);
        } while (goes_on() && state_.space.level < state_.last_level());
        if (!any) throw InvalidInput("nothing to fit: no variable of any level moves anything; is all of it fixed?");
        state_.result.level = state_.space.level;
        state_.result.motion = motion_of(state_.result, state_.evaluator.motion_limit(), motion_slack);
        conclude_fit(state_.result, end_, words_, state_.last_level(), is_shape_refused_);
    }

    bool goes_on() {
        return end_ != FitEnd::failed && end_ != FitEnd::no_design && end_ != FitEnd::recovered &&
               state_.evaluations_left() > 0 && state_.seconds_left() > 0;
    }

    bool out_of_budget() {
        out_of_budget_ = state_.result.evaluations - state_.result.levels.back().evaluations >= level_budget_ ||
                         state_.seconds_left() <= 0;
        return out_of_budget_;
    }

    void fail(const std::string& why) {
        failed_ = true;
        words_ = text("evaluation ", state_.result.evaluations, ": ", why);
    }

    /// An error in a quantity is a failed evaluation, after which the fit continues only if the quantity says
    /// so; a wrong problem is still an exception.
    ShapeEvaluation shape_at(const VectorXd& x) {
        try {
            return state_.evaluate(x);
        } catch (const UnheldPart&) {
            throw;
        } catch (const InvalidInput&) {
            throw;
        } catch (const OutputError&) {
            throw;
        } catch (const std::exception& error) {
            ShapeEvaluation none;
            none.status = EvaluationStatus::quantity_failed;
            none.reason = error.what();
            none.may_go_on = false;
            return none;
        }
    }

    /// Residuals of a shape, for the record with the true matches and for the solver with the kept ones.
    double measured(ShapeEvaluation& shape) {
        try {
            const TriMesh surface = with_vertices(state_.rest->surface, shape.vertices);
            rows_ = residuals_.at(surface, surface);
            const double objective = rows_.r.squaredNorm();
            if (matched_.num_vertices() > 0) rows_ = residuals_.at(surface, matched_);
            return objective;
        } catch (const std::exception& error) {
            shape.status = EvaluationStatus::quantity_failed;
            shape.reason = error.what();
            shape.may_go_on = dynamic_cast<const ResidualsUndefined*>(&error) != nullptr;
            return std::numeric_limits<double>::quiet_NaN();
        }
    }

    /// Sets rows_ and ok_. Not again for the same x and matches.
    void measure(const VectorXd& asked) {
        if (current_x_.size() == asked.size() && current_x_ == asked) return;
        current_x_ = asked;
        const VectorXd x = state_.evaluator.within(asked, motion_slack);
        ShapeEvaluation shape = shape_at(x);
        double objective = std::numeric_limits<double>::quiet_NaN();
        if (shape.status == EvaluationStatus::ok) objective = measured(shape);
        ok_ = shape.status == EvaluationStatus::ok;
        Rank rank;
        if (ok_) rank = {true, 0, objective}, vertices_ = shape.vertices;
        if (!ok_) is_shape_refused_ = shape.status != EvaluationStatus::quantity_failed;
        if (!ok_ && !shape.may_go_on)
            fail(shape.reason);
        else if (!ok_)
            words_ = shape.reason;
        if (state_.record(x, shape, objective, rank, {})) level_x_ = x;
    }

    bool evaluate(const VectorXd& x, VectorXd& r, RowMajorMatrix* dr_dx) {
        if (failed_ || ((x.size() != current_x_.size() || x != current_x_) && out_of_budget())) return false;
        measure(x);
        if (!ok_) return false;
        r = rows_.r;
        if (!dr_dx) return true;
        dr_dx->resize(r.size(), state_.space.size());
        try {
            design_response(
                state_.space, state_.evaluator.shell(),
                [&](int j, const Points& dv) { FitResiduals::set_column(rows_, j, dv, *dr_dx); }, jacobian_tolerance,
                &vertices_, &x);
        } catch (const SolverError& error) {
            fail(error.what());
            return false;
        }
        return true;
    }

    /// Asked after every iteration.
    bool go_on(int iteration) {
        if (failed_ || out_of_budget_) return false;
        const double rms = std::sqrt(state_.level_best_objective);
        if (first_rms_ < 0) first_rms_ = rms;
        is_recovered_ = rms <= recovered * first_rms_;
        if (is_recovered_) return false;
        // At active bounds Ceres projects its step, which may go on for long with little gain.
        const double before = std::exchange(previous_rms_, rms);
        if (iteration == 0) return true;
        const bool last = state_.space.level == state_.last_level();
        const bool slow = before - rms < state_.problem.optimize.progress_below * before;
        slow_iterations_ = slow ? slow_iterations_ + 1 : 0;
        return slow_iterations_ < (last ? patience_on_last_level : fit_patience);
    }

    LeastSquaresResult solve(const VectorXd& start) {
        const OptimizeOptions& how = state_.problem.optimize;
        LeastSquares problem{start, state_.space.lower, state_.space.upper, static_cast<int>(rows_.r.size()), {}, {}};
        problem.evaluate = [&](const VectorXd& x, VectorXd& r, RowMajorMatrix* dr_dx) { return evaluate(x, r, dr_dx); };
        problem.go_on = [&](int iteration) { return go_on(iteration); };
        LeastSquaresOptions options;
        options.max_iterations = level_budget_;
        options.objective_tolerance = how.objective_tolerance;
        options.step_tolerance = how.step_tolerance;
        options.radius = radius_;
        slow_iterations_ = 0;
        const LeastSquaresResult end = least_squares(problem, options);
        radius_ = std::clamp(end.radius, first_radius, 1e3 * first_radius);
        return end;
    }

    VectorXd run_level(const VectorXd& start) {
        level_budget_ = std::max(1, state_.evaluations_left() / (state_.last_level() - state_.space.level + 1));
        level_x_ = start;
        out_of_budget_ = is_recovered_ = false;
        current_x_.resize(0);
        matched_ = TriMesh();
        measure(start);
        if (failed_ || !ok_) {
            end_ = failed_ ? FitEnd::failed : FitEnd::no_design;
            return start;
        }
        const int solves = std::max(1, state_.problem.fitting.icp_iterations);
        for (int i = 0; i < solves; ++i) {
            const double before = state_.level_best_objective;
            if (state_.problem.fitting.icp_iterations > 0) keep_matches(i);
            end_ = end_of(solve(level_x_).stop);
            const bool gains =
                before - state_.level_best_objective > state_.problem.optimize.objective_tolerance * before;
            if (end_ != FitEnd::converged && end_ != FitEnd::slackened) break;
            if (!gains) break;
        }
        return level_x_;
    }

    void keep_matches(int solve) {
        matched_ = with_vertices(state_.rest->surface, state_.level_best_vertices);
        if (solve > 0) current_x_.resize(0);  // its residuals are those of the matches before
    }

    FitEnd end_of(LeastSquaresStop stop) const {
        if (failed_) return FitEnd::failed;
        if (is_recovered_) return FitEnd::recovered;
        if (out_of_budget_) return FitEnd::budget;
        switch (stop) {
            case LeastSquaresStop::converged:
                return FitEnd::converged;
            case LeastSquaresStop::no_valid_step:
                return FitEnd::no_valid_step;
            case LeastSquaresStop::stopped:
                return FitEnd::slackened;
            case LeastSquaresStop::limit:
                return FitEnd::budget;
            default:
                return FitEnd::roundoff;
        }
    }

    FitResiduals residuals_;
    RunState state_;
    FitResiduals::Rows rows_;  ///< at current_x_
    Points vertices_;          ///< the same
    TriMesh matched_;          ///< where closest places are kept from; no vertices: found anew
    VectorXd current_x_, level_x_;
    bool ok_ = false, failed_ = false, out_of_budget_ = false, is_recovered_ = false;
    int level_budget_ = 0, slow_iterations_ = 0;
    double radius_ = first_radius, first_rms_ = -1, previous_rms_ = 0;
    FitEnd end_ = FitEnd::no_design;
    std::string words_;  ///< why the last refused evaluation gave nothing
    bool is_shape_refused_ = true;
};

}  // namespace

RunResult fit(const Problem& problem, const RunEvents& events, Journal* journal) {
    Problem own = problem;
    own.parameters = with_stated_limit(problem.parameters);
    return Fit(own, events, journal).run();
}

}  // namespace strake
