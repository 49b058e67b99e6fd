#include "optimize/coarse_to_fine.hpp"

#include "core/error.hpp"
#include "optimize/constraints.hpp"
#include "optimize/run_state.hpp"

namespace strake {
namespace {

constexpr int failures_before_refining = 4;  ///< the last level the minimizer's own limits hold

/// Names whose gradients are needed: the objective first, then constrained values, each once.
std::vector<std::string> differentiated_names(const Problem& problem) {
    if (problem.objective.empty()) throw InvalidInput("the case has no objective: give minimize or maximize");
    if (problem.optimize.method == Method::cobyla) return {};
    std::vector<std::string> names{problem.objective};
    for (const Constraint& c : problem.constraints)
        if (std::find(names.begin(), names.end(), c.quantity) == names.end()) names.push_back(c.quantity);
    return names;
}

class Optimization {
public:
    Optimization(const Problem& problem, const RunEvents& events)
        : differentiated_(differentiated_names(problem)), state_(problem, events, differentiated_) {
        objective_ = state_.evaluator.index_of(problem.objective);
        for (const Constraint& c : problem.constraints) {
            constrained_.push_back(state_.evaluator.index_of(c.quantity));
            const auto at = std::find(differentiated_.begin(), differentiated_.end(), c.quantity);
            gradient_row_.push_back(static_cast<int>(at - differentiated_.begin()));
        }
        std::tie(num_inequalities_, num_equalities_) = count_constraints(problem.constraints);
    }

    RunResult run() {
        Eigen::VectorXd x;
        MinimizeResult level;
        level.stop = MinimizeStop::converged;
        bool any = false;
        do {
            x = state_.next_level(x);
            if (state_.space.size() == 0) {
                state_.end_level("no variable of this level moves anything");
                continue;
            }
            any = true;
            level = run_level(x);
            x = level.x;
            state_.end_level(level_words(level));
        } while (goes_on(level) && state_.space.level < state_.last_level());
        if (!any)
            throw InvalidInput("nothing to optimize: no variable of any level moves anything; is all of it fixed?");
        conclude(level);
        return state_.result;
    }

private:
    double sign() const { return state_.problem.maximize ? -1 : 1; }

    bool goes_on(const MinimizeResult& level) const {
        return level.stop != MinimizeStop::failed && state_.evaluations_left() > 0 && state_.seconds_left() > 0;
    }

    MinimizeResult run_level(const Eigen::VectorXd& start) {
        const OptimizeOptions& options = state_.problem.optimize;
        const bool last = state_.space.level == state_.last_level();
        // The optimizer works in y = weight * x, in which every variable has the same size.
        weight_ = state_.space.metric.diagonal().cwiseSqrt();
        NonlinearProgram program;
        program.start = start.cwiseProduct(weight_);
        program.lower = state_.space.lower.cwiseProduct(weight_);
        program.upper = state_.space.upper.cwiseProduct(weight_);
        program.num_inequalities = num_inequalities_;
        program.num_equalities = num_equalities_;
        program.evaluate = [&](const Eigen::VectorXd& y) { return evaluate(unscaled(y)); };
        program.differentiate = [&](const Eigen::VectorXd&, Sample& sample) { differentiate(sample); };
        program.metric =
            weight_.cwiseInverse().asDiagonal() * state_.space.metric * weight_.cwiseInverse().asDiagonal();
        MinimizeOptions how;
        how.method = options.method;
        how.objective_tolerance = options.objective_tolerance;
        how.step_tolerance = options.step_tolerance;
        how.constraint_tolerance = options.constraint_tolerance;
        how.max_evaluations = std::max(1, state_.evaluations_left() / (state_.last_level() - state_.space.level + 1));
        how.max_seconds = options.max_seconds > 0 ? std::max(state_.seconds_left(), 1e-9) : 0;
        how.confirm = last;
        how.first_step = first_step_;
        if (!last) how.max_shrinks = how.max_failures = failures_before_refining;
        // The rule says when to refine: on the last level only convergence and the budget end the search.
        ProgressWatch watch(last ? 0 : options.progress_below);
        how.on_step = [&](const MinimizeStep& step) {
            const bool slackened = watch.slackened(step.merit, step.violation);
            return !(slackened && state_.run_best.feasible);  // not before there is something to refine
        };
        how.on_event = [&](const std::string& words) { state_.note(text("level ", state_.space.level, ": ", words)); };
        MinimizeResult result = minimize(program, how);
        result.x = unscaled(result.x);
        // What was too far on this level is too far on the next.
        if (result.radius > 0) first_step_ = std::clamp(2 * result.radius, 0.05, 0.5);
        return result;
    }

    Eigen::VectorXd unscaled(const Eigen::VectorXd& y) const {
        return y.cwiseQuotient(weight_).cwiseMax(state_.space.lower).cwiseMin(state_.space.upper);
    }

    Sample evaluate(const Eigen::VectorXd& x) {
        Sample sample;
        current_ = state_.evaluate(x);
        Rank rank;
        double objective = std::numeric_limits<double>::quiet_NaN();
        if (current_.status == EvaluationStatus::ok) {
            if (rows_.rows.empty() && !constrained_.empty())
                rows_ = constraint_rows(state_.problem.constraints, constrained_, gradient_row_, current_.values);
            objective = current_.values[objective_];
            sample.objective = sign() * objective;
            sample.constraints.resize(static_cast<Eigen::Index>(rows_.rows.size()));
            rank.violation = 0;
            for (std::size_t i = 0; i < rows_.rows.size(); ++i) {
                const double c = rows_.rows[i].of(current_.values[rows_.rows[i].value]);
                sample.constraints[static_cast<Eigen::Index>(i)] = c;
                const bool equality = static_cast<int>(i) >= rows_.num_inequalities;
                rank.violation = std::max(rank.violation, equality ? std::abs(c) : c);
            }
            rank.merit = sample.objective;
            rank.feasible = rank.violation <= state_.problem.optimize.constraint_tolerance;
        } else {
            sample.failure = current_.reason;
            sample.is_fatal = current_.status == EvaluationStatus::quantity_failed;
            quantity_failed_ |= sample.is_fatal;
        }
        state_.record(x, current_, objective, rank, current_.dJ_dv.empty() ? Points() : current_.dJ_dv[0]);
        return sample;
    }

    void differentiate(Sample& sample) {
        state_.evaluator.differentiate(current_);
        sample.gradient = sign() * current_.gradients.row(0).transpose().cwiseQuotient(weight_);
        sample.jacobian.resize(static_cast<Eigen::Index>(rows_.rows.size()), state_.space.size());
        for (std::size_t i = 0; i < rows_.rows.size(); ++i)
            sample.jacobian.row(static_cast<Eigen::Index>(i)) =
                rows_.rows[i].sign / rows_.rows[i].scale *
                current_.gradients.row(rows_.rows[i].gradient).cwiseQuotient(weight_.transpose());
    }

    static std::string level_words(const MinimizeResult& level) {
        return level.stop == MinimizeStop::stopped ? "progress slackened" : level.reason;
    }

    /// Variables of the best design that lie at a bound.
    std::string bounds_note() const {
        const RunResult& r = state_.result;
        int active = 0;
        for (int j = 0; j < r.space.size(); ++j)
            active += r.x[j] <= r.space.lower[j] + 1e-6 || r.x[j] >= r.space.upper[j] - 1e-6;
        if (active == 0) return "";
        return text("; bounds active on ", active, " of ", r.space.size(),
                    " variables (a larger max_displacement would give them room)");
    }

    void conclude(const MinimizeResult& level) {
        RunResult& r = state_.result;
        r.level = state_.space.level;
        const std::string words = level_words(level);
        const bool on_last = state_.space.level == state_.last_level();
        if (quantity_failed_) {
            r.status = "evaluation_failed";
            r.reason = text("evaluation ", r.evaluations, ": ", level.reason);
            return;
        }
        if (r.best_evaluation == 0) {
            r.status = "failed";
            r.reason = text(words, "; reduce the given loads and strains, or fix less");
            return;
        }
        if (!state_.run_best.feasible) {
            r.status = "infeasible";
            r.reason = text("no design meets the constraints, the least violation is ", r.max_violation, " (", words,
                            "); relax the constraint with the largest violation or allow a larger max_displacement",
                            bounds_note());
            return;
        }
        switch (level.stop) {
            case MinimizeStop::converged:
                r.status = on_last ? "converged" : "budget";
                r.reason = on_last ? text("converged on level ", r.level, ": ", words, bounds_note())
                                   : text("the budget ended on level ", r.level, bounds_note());
                break;
            case MinimizeStop::roundoff:
                r.status = "roundoff";
                r.reason = text("stopped on level ", r.level, ": ", words, bounds_note());
                break;
            case MinimizeStop::stopped:
                r.status = "progress";
                r.reason =
                    text("progress slackened on the last level", bounds_note(),
                         "; for the last digits set refine_when.progress_below to 0, for more freedom add a level");
                break;
            case MinimizeStop::blocked:
                r.status = "blocked";
                r.reason = text(words,
                                "; the surface buckles or folds there: allow a smaller max_displacement, or give a "
                                "larger thickness");
                break;
            case MinimizeStop::failed:
                r.status = "failed";
                r.reason = words;
                break;
            default:
                r.status = "budget";
                r.reason = text(words, " on level ", r.level, " of ", state_.last_level(),
                                "; raise optimize.budget to go on", bounds_note());
        }
    }

    std::vector<std::string> differentiated_;
    RunState state_;
    int objective_ = 0, num_inequalities_ = 0, num_equalities_ = 0;
    std::vector<int> constrained_, gradient_row_;
    ConstraintRows rows_;
    Eigen::VectorXd weight_;
    double first_step_ = 0.5;
    ShapeEvaluation current_;
    bool quantity_failed_ = false;
};

}  // namespace

RunResult optimize(const Problem& problem, const RunEvents& events) { return Optimization(problem, events).run(); }

}  // namespace strake
