#pragma once
#include "optimize/first_order.hpp"
#include "optimize/guard.hpp"
#include "optimize/quadratic_model.hpp"
#include "optimize/sqp.hpp"

/// The search behind minimize_by_sqp(): steps in sqp.cpp, ends and failures in sqp_ends.cpp. Internal.
namespace strake {

class SqpSearch {
public:
    SqpSearch(Guard& guard, double least_curvature)
        : guard_(guard), p_(guard.program), x_(guard.best_x), at_(guard.best), least_curvature_(least_curvature) {
        p_.metric = metric_of(p_);
        const Eigen::Index rows = at_.constraints.size();
        curvature_ = Eigen::VectorXd::Constant(rows, std::numeric_limits<double>::infinity());
        included_ = Eigen::VectorXd::Zero(rows);
    }

    SqpEnd run();

private:
    static constexpr int restorations = 3;  ///< evaluations spent at the end on meeting the constraints

    double tolerance() const { return guard_.options.constraint_tolerance; }
    /// A hair inside of the inequalities, so that round-off and curvature do not leave the last point a hair outside.
    Eigen::VectorXd tightened(Eigen::VectorXd constraints) const;
    double merit(const Sample& s) const {
        return s.objective + guard_.penalty * total_violation(p_, tightened(s.constraints));
    }

    Eigen::VectorXd lagrangian_gradient() const {
        return at_.gradient + at_.jacobian.transpose() * multipliers(p_, x_, at_);
    }

    /// B = beta metric, so that the first step has the length of the first radius, or less where more is known.
    void start_hessian();

    /// Somebody knows of something better than what this model still expects.
    bool is_outpaced();

    void raise_penalty(double least) { guard_.penalty = std::max(guard_.penalty, least); }
    /// After an accepted step: half way to what its multipliers need, where that is less (Powell 1978). A penalty that
    /// is much too large takes the curvature of the constraints for a reason to make short steps.
    void adapt_penalty(double needed, bool feasible) {
        raise_penalty(needed);
        if (needed > 0 && feasible) guard_.penalty = 0.5 * (guard_.penalty + needed);
    }

    QuadraticModel model(const Eigen::VectorXd& constraints, double damping) const {
        return model(constraints, damping, cut_);
    }
    QuadraticModel model(const Eigen::VectorXd& constraints, double damping,
                         const std::optional<FailureCut>& cut) const;

    /// The model's step, no longer than the radius: the damping that it takes is found by bisection of its logarithm.
    Eigen::VectorXd model_step(const Eigen::VectorXd& constraints);

    /// What holds the step d of a model, of the program's own constraints.
    ActiveSet held(const QuadraticModel& of, const Eigen::VectorXd& d) const;
    Eigen::VectorXd multipliers_at(const Sample& sample, const ActiveSet& set) const;

    /// The model's step. Where the present metric finds it too long (a direction has become soft), the metric learns of
    /// it by an update that keeps it positive definite (BFGS with the exact product), and the step is made anew.
    Eigen::VectorXd careful_step();

    /// Evaluates x; false with the guard's cause set when there is no value.
    bool evaluate(const Eigen::VectorXd& x, bool gradient, Sample& sample);

    /// A gradient costs an evaluation for each of many variables.
    bool is_dear() const;

    /// Evaluates and differentiates x, the end of the step d; by differences it pays only for what the model and the
    /// values do not tell well enough.
    bool differentiate(const Eigen::VectorXd& x, Sample& trial);
    GradientGuess guess(const Sample& trial, const Eigen::VectorXd& d) const;

    /// Pays for all that is guessed of the gradient at x_. False: it was exact, or could not be evaluated.
    bool pay_doubt();

    /// One step. True: the end.
    bool step();
    /// What is guessed of the gradient is paid before it is said that nothing is left to gain. False: it goes on.
    bool ends_here();

    /// A second-order correction: the same model with the curvature that the trial met added to the constraints.
    bool correct(Sample& trial, Eigen::VectorXd& d);

    /// The same where a gradient costs many evaluations: a step that misses the constraints is brought nearer to them
    /// before the next one is paid. False: the search has to end.
    bool meet_constraints(Sample& trial, Eigen::VectorXd& d);

    /// Where a gradient costs an evaluation for each variable, the parabola through the values is followed along a step
    /// that turns out too short, before the next gradient is paid. Longer steps replace `trial` and `d`.
    void stretch(Sample& trial, Eigen::VectorXd& d, double slope);

    bool accept(const Eigen::VectorXd& x, Sample& trial, double decrease, const ActiveSet& set);

    /// Powell's damped BFGS update.
    void update(const Eigen::VectorXd& s, const Eigen::VectorXd& y);

    bool is_little(double promise) const;

    /// The model promises nothing more: converged, if nothing but the tolerances keeps it from a longer step.
    bool is_at_rest(const Eigen::VectorXd& d, double predicted);

    /// Least curvatures that the constraints have shown along a step, in the metric.
    void measure_curvature(const Sample& trial, const Eigen::VectorXd& d);

    /// The Hessian of the Lagrangian gets the share of constraints that have become active: as much as they have shown,
    /// in every direction. Else their curvature is met one direction after the other, by steps far out of them.
    void bend(const Eigen::VectorXd& lambda);

    /// What a rejected step tells for nothing: the Lagrangian's curvature along d, where it is more than the model's.
    /// No more than makes the model's own step along d as long as the radius: a wall further out is not curvature here.
    void stiffen(const Sample& trial, const Eigen::VectorXd& d, const Eigen::VectorXd& lambda);

    bool failed_at(const Eigen::VectorXd& d);

    /// Without the border the step would be another one.
    bool is_cut_off(const Eigen::VectorXd& d) const;
    double so_far() const { return guard_.highest - at_.objective; }

    /// Nothing is left to gain on this side of the border: believed when steps through it fail, too.
    bool end_at_border();

    /// The decrease of the merit that the model promises for d.
    double promised(const Eigen::VectorXd& d) const;

    /// Where the border may lie, seen from x_, and the cut that the next step keeps to: bold ones promise much and
    /// fail, careful ones promise little; the one with the largest product of promise and probability is taken.
    void look_at_border();

    bool rejected(double length);

    bool model_failed();

    bool ended_by_guard();

    bool needs_restoration() const {
        return p_.num_inequalities + p_.num_equalities > 0 && largest_violation(p_, at_.constraints) > tolerance();
    }

    /// Steps onto the constraints from the last point, where that is better than the best feasible one.
    void restore();

    bool end(MinimizeStop stop, const std::string& reason);
    void tell(const std::string& event) const {
        if (guard_.options.on_event) guard_.options.on_event(event);
    }

    Guard& guard_;
    NonlinearProgram p_;  ///< its metric may be renewed
    Eigen::VectorXd x_;
    Sample at_;  ///< at x_, with gradients
    Eigen::MatrixXd B_;
    Eigen::VectorXd curvature_;  ///< of the constraints
    Eigen::VectorXd included_;   ///< multiplier times curvature that B has got
    Eigen::MatrixXd of_steps_;   ///< B as the last accepted step left it
    double radius_ = guard_.options.first_step;
    double damping_ = 0;  ///< that kept the last of the model's steps within the radius
    double least_curvature_;
    std::optional<FailureCut> cut_;  ///< the next step keeps to its side; none: no border is known
    double expected_ = 0;            ///< decrease of the merit from a step that does, times its probability
    bool is_limited_ = false;
    int accepted_ = 0;
    GradientDoubt doubt_;  ///< of the gradient in at_
    int calm_ = 0, stuck_ = 0, failures_ = 0, rejections_ = 0, model_failures_ = 0;
    SqpEnd end_;
};

}  // namespace strake
