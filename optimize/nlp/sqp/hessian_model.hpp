#pragma once
#include "optimize/nlp/sqp/iterate.hpp"

/// What sqp knows of the Lagrangian's Hessian. Internal.
namespace strake {

/// Starts as a multiple of the metric or as what the program knows, and learns by damped BFGS updates, by the curvature
/// that active constraints have shown, and by rejected steps.
class HessianModel {
public:
    /// Empty until started.
    /// @param min_curvature of the first model over the metric; 0: such that its step has the length `first_step`
    HessianModel(const SqpIterate& now, double min_curvature);

    const Eigen::MatrixXd& matrix() const { return B_; }
    /// As the last accepted step left it.
    const Eigen::MatrixXd& accepted() const { return accepted_; }
    void mark_accepted() { accepted_ = B_; }

    /// A multiple of the metric: the first step has the length of the first radius, or less where more is known.
    void start();
    /// What the program knows, with its guessed part.
    void start_from(const Eigen::MatrixXd& known);

    /// Powell's damped BFGS update: the Lagrangian's gradient has changed by y along the step s. Where it is damped,
    /// the largest curvature does not outgrow what was there.
    void update(const Eigen::VectorXd& s, const Eigen::VectorXd& y);
    /// Notes the least curvature that each constraint has shown along the step d to `trial`, in the metric.
    void measure_constraints(const Evaluation& trial, const Eigen::VectorXd& d);
    /// Adds, in every direction, the curvature that constraints have shown and their multipliers need. Otherwise their
    /// curvature is met in one direction after the other, by steps that end far outside of them.
    void add_constraint_curvature(const Eigen::VectorXd& multipliers);
    /// Adds the Lagrangian's curvature along the rejected step d, where it exceeds the model's. No more than makes the
    /// model's own step along d as long as the radius: a wall further out is not curvature here.
    void add_rejected_curvature(const Evaluation& trial, const Eigen::VectorXd& d, const Eigen::VectorXd& multipliers,
                                double radius);
    /// Removes this share of the program's guessed part, if the model has started from it: the first step turned out
    /// too short by it.
    void remove_guess(double share);

private:
    const SqpIterate& now_;
    double min_curvature_;
    bool holds_guess_ = false;
    Eigen::MatrixXd B_, accepted_;
    Eigen::VectorXd curvature_;  ///< of the constraints
    Eigen::VectorXd included_;   ///< multiplier times curvature that B has got
};

/// Of the Lagrangian, with the least-squares multipliers at the present point.
Eigen::VectorXd lagrangian_gradient(const SqpIterate& now);

}  // namespace strake
