#pragma once
#include "optimize/nlp/sqp/border_cut.hpp"
#include "optimize/nlp/sqp/gradient_model.hpp"
#include "optimize/nlp/sqp/sqp.hpp"

/// The search behind minimize_by_sqp(): the loop over steps (sqp_search.cpp) and its ends (sqp_ends.cpp). Internal.
namespace strake {

class SqpSearch {
public:
    SqpSearch(Guard& guard, double min_curvature);

    SqpEnd run();

private:
    struct Trial {
        Evaluation evaluation;
        Eigen::VectorXd d;  ///< the step to it
        Eigen::VectorXd x = {};
        bool is_moved = false;  ///< from where the step was to lead: that was beyond a limit
    };
    /// Evaluates where the trial's step leads. False: there is no value.
    bool try_step(Trial& trial);
    /// The same where the trial has been placed; what has no valid shape fails without an evaluation.
    bool try_placed(Trial& trial);
    /// Where the trial's step leads, inside the limits.
    void place(Trial& trial);
    /// The step was moved back to where it began: a shorter one is tried, and nothing is paid. True: the search has
    /// ended.
    bool cut_back(const Eigen::VectorXd& d);
    /// The step of the model that knows the limits which d would go beyond.
    Eigen::VectorXd within_limits(Eigen::VectorXd d);

    /// One step. True: the search has ended.
    bool step();
    /// A second-order correction: the same model with the curvature that the trial met added to the constraints.
    /// False: its evaluation has no value.
    bool correct(Trial& trial);
    /// The same where a gradient costs many evaluations: a step that misses the constraints is brought nearer to them
    /// before the next gradient is evaluated. False: the search has to end.
    bool meet_constraints(Trial& trial);
    /// Where a gradient costs an evaluation for each variable: goes on along a step that turned out too short, as far
    /// as the parabola through the values says, before the next gradient is evaluated.
    void extrapolate(Trial& trial, double slope);
    /// The radius after a step with this actual over expected decrease.
    void resize(double ratio, double length);
    bool accept(const Eigen::VectorXd& x, Evaluation& trial, double decrease, const ActiveSet& set);
    /// The step to this trial is one that `MinimizeOptions::on_misfit` ends the search for.
    bool tells_of_waves(const Evaluation& trial, const Eigen::VectorXd& step, const Eigen::VectorXd& lambda) const;
    /// After many small decreases or stalled steps. True: the search has ended.
    bool ends_by_progress();
    /// Converged, or stalled where more is expected.
    bool end_by_small_steps();

    /// The model expects nothing more: converged, if nothing but the tolerances keeps it from a longer step.
    bool is_stationary(const Eigen::VectorXd& d, double predicted);
    bool is_small(double expected_decrease) const;
    /// Converged, or where it is noise that hides the decrease, stopped by it. @return true
    bool end_by_small(double expected_decrease);
    /// Of the Lagrangian, without what bounds carry, in the dual of the metric.
    double projected_gradient() const;
    /// What is guessed of the gradient is evaluated before the search ends. False: it goes on.
    bool ends_here();
    bool complete_gradient();
    /// More is expected elsewhere than this model still expects.
    bool is_outpaced();
    bool failed_at(const Eigen::VectorXd& d);
    /// Converged where nothing is expected anyway, otherwise without a valid step. @return true
    bool end_by_failures(bool knows_border);
    /// Nothing is left to gain on this side of the border: believed when steps through it fail, too.
    bool end_at_border();
    bool rejected(double length);
    bool model_failed();
    bool ended_by_guard();
    std::string failure_words() const;  ///< behind an opening bracket
    bool end(MinimizeStop stop, const std::string& reason);

    bool needs_restoration() const {
        return now_.program.num_inequalities + now_.program.num_equalities > 0 && !now_.is_met(now_.at);
    }
    /// Steps onto the constraints from the last point, where that is better than the best feasible one.
    void restore();

    int failed_in_row() const { return failures_ + refusals_; }
    double total_decrease() const { return guard_.highest - now_.at.objective; }
    void start_hessian();
    void report(const std::string& event) const {
        if (guard_.options.on_event) guard_.options.on_event(event);
    }

    Guard& guard_;
    SqpIterate now_;
    Merit merit_;
    HessianModel hessian_;
    StepModel steps_;
    BorderCut border_;
    GradientModel gradient_;
    int accepted_ = 0, without_shape_ = 0;
    bool was_paid_ = false;  ///< the present step has cost an evaluation
    /// In a row; refusals are failures that cost no evaluation.
    int small_decreases_ = 0, stalled_steps_ = 0, failures_ = 0, refusals_ = 0, rejections_ = 0, model_failures_ = 0;
    SqpEnd end_;
};

}  // namespace strake
