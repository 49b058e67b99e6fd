#include "optimize/coarse_to_fine.hpp"

#include "core/error.hpp"
#include "optimize/constraints.hpp"
#include "optimize/first_order.hpp"
#include "optimize/refinement.hpp"
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
        for (std::optional<Front> front;;) {
            x = state_.next_level(x, front ? &*front : nullptr);
            if (state_.space.size() == 0) {
                state_.end_level("no variable of this level moves anything");
            } else {
                any = true;
                level = run_level(x);
                x = level.x;
                state_.end_level(level_words(level));
            }
            if (!goes_on(level) || !state_.can_refine() || !choose_front(x, front)) break;
        }
        if (!any)
            throw InvalidInput("nothing to optimize: no variable of any level moves anything; is all of it fixed?");
        conclude(level);
        return state_.result;
    }

private:
    /// The last differentiated design of a level that was its best by then.
    struct Known {
        Eigen::VectorXd x;
        Rank rank;
        Sample sample;
        std::vector<ShellSensitivities> sensitivities;
        Points dJ_dv;
    };

    double sign() const { return state_.problem.maximize ? -1 : 1; }

    bool goes_on(const MinimizeResult& level) const {
        return level.stop != MinimizeStop::failed && state_.evaluations_left() > 0 && state_.seconds_left() > 0;
    }

    /// The front of the next level where the run chooses it. False: refining promises nothing.
    bool choose_front(const Eigen::VectorXd& x, std::optional<Front>& front) {
        front.reset();
        const SplitRule rule = state_.rest->parameters.split;
        if (rule == SplitRule::tree) return true;
        if (known_.sensitivities.empty()) {
            // Without sensitivities, or without variables: every patch.
            const Front& present = *state_.space.front;
            front = split_front(*state_.rest->tree, present, std::vector<char>(present.depth.size(), 1));
            return true;
        }
        Eigen::VectorXd weight = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(known_.sensitivities.size()));
        weight[0] = sign();
        const Eigen::VectorXd lambda = multipliers(program_, known_.sample);
        for (std::size_t i = 0; i < rows_.rows.size(); ++i)
            weight[rows_.rows[i].gradient] +=
                lambda[static_cast<Eigen::Index>(i)] * rows_.rows[i].sign / rows_.rows[i].scale;
        const RefinementPlan plan =
            plan_refinement({state_.space, x, weighted_sum(known_.sensitivities, weight), curvature_, known_.dJ_dv});
        state_.note(text("refinement: ", plan.words()));
        if (plan.promises.empty()) return false;
        const double now = state_.level_best_objective;
        const double floor = 0.1 * state_.problem.optimize.objective_tolerance *
                             std::max(std::abs(now), std::abs(state_.result.objective_start - now));
        if (rule == SplitRule::sensitivity && hessian_.size() > 0 && plan.promised <= floor) {
            refining_is_idle_ = true;
            return false;
        }
        front = plan.front;
        return true;
    }

    /// What the level before knows of the Hessian, in the variables of this one.
    Eigen::MatrixXd inherited_hessian(const Eigen::VectorXd& weight_before) const {
        if (hessian_.size() == 0 || state_.prolongation.cols() != hessian_.cols()) return {};
        const Eigen::MatrixXd P =
            weight_.asDiagonal() * state_.prolongation * weight_before.cwiseInverse().asDiagonal();
        return carried_hessian(hessian_, P, program_.metric, curvature_);
    }

    MinimizeResult run_level(const Eigen::VectorXd& start) {
        const OptimizeOptions& options = state_.problem.optimize;
        const bool last = state_.levels_left() == 0;
        const Eigen::VectorXd weight_before = weight_;
        // The optimizer works in y = weight * x, in which every variable has the same size.
        weight_ = state_.space.metric.diagonal().cwiseSqrt();
        program_ = NonlinearProgram();
        program_.start = start.cwiseProduct(weight_);
        program_.lower = state_.space.lower.cwiseProduct(weight_);
        program_.upper = state_.space.upper.cwiseProduct(weight_);
        program_.num_inequalities = num_inequalities_;
        program_.num_equalities = num_equalities_;
        program_.evaluate = [&](const Eigen::VectorXd& y) { return evaluate(unscaled(y)); };
        program_.differentiate = [&](const Eigen::VectorXd&, Sample& sample) { differentiate(sample); };
        program_.metric =
            weight_.cwiseInverse().asDiagonal() * state_.space.metric * weight_.cwiseInverse().asDiagonal();
        program_.present_metric = [&](const Eigen::VectorXd& y, const Eigen::VectorXd& d) {
            const Eigen::VectorXd product = state_.evaluator.metric_product(unscaled(y), d.cwiseQuotient(weight_));
            return product.size() > 0 ? Eigen::VectorXd(product.cwiseQuotient(weight_)) : product;
        };
        program_.hessian = inherited_hessian(weight_before);
        known_ = {};
        MinimizeOptions how;
        how.method = options.method;
        how.objective_tolerance = options.objective_tolerance;
        how.step_tolerance = options.step_tolerance;
        how.constraint_tolerance = options.constraint_tolerance;
        how.max_evaluations = std::max(1, state_.evaluations_left() / (state_.levels_left() + 1));
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
        MinimizeResult result = minimize(program_, how);
        hessian_ = result.hessian;
        curvature_ = hessian_.size() > 0 ? mean_curvature(hessian_, program_.metric) : 1;
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
        current_x_ = x;
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
            current_rank_ = rank;
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
        if (known_.sensitivities.empty() || current_rank_.better_than(known_.rank))
            known_ = {current_x_, current_rank_, sample, current_.sensitivities, current_.dJ_dv[0]};
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
        return text("; bounds active on ", active, " of ", r.space.size(), " variables of level ", r.space.level,
                    " (a larger max_displacement would give them room)");
    }

    void conclude(const MinimizeResult& level) {
        RunResult& r = state_.result;
        r.level = state_.space.level;
        const std::string words = level_words(level);
        const bool on_last = refining_is_idle_ || state_.levels_left() == 0;
        const std::string idle = refining_is_idle_ ? "; no progress is expected from further refinement" : "";
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
                r.reason = on_last ? text("converged on level ", r.level, ": ", words, idle, bounds_note())
                                   : text("the budget ended on level ", r.level, bounds_note());
                break;
            case MinimizeStop::roundoff:
                r.status = "roundoff";
                r.reason = text("stopped on level ", r.level, ": ", words, bounds_note());
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
                r.reason = text(words, " on level ", r.level, state_.can_refine() ? ", which is not the finest" : "",
                                "; raise optimize.budget to go on", bounds_note());
        }
    }

    std::vector<std::string> differentiated_;
    RunState state_;
    int objective_ = 0, num_inequalities_ = 0, num_equalities_ = 0;
    std::vector<int> constrained_, gradient_row_;
    ConstraintRows rows_;
    NonlinearProgram program_;  ///< of the present level, in y
    Eigen::VectorXd weight_;
    Eigen::MatrixXd hessian_;  ///< at the end of the level, in y; empty: not known
    double curvature_ = 1, first_step_ = 0.5;
    ShapeEvaluation current_;
    Eigen::VectorXd current_x_;
    Rank current_rank_;
    Known known_;
    bool refining_is_idle_ = false;
    bool quantity_failed_ = false;
};

}  // namespace

RunResult optimize(const Problem& problem, const RunEvents& events) { return Optimization(problem, events).run(); }

}  // namespace strake
