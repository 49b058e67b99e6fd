#pragma once
#include "optimize/nlp/model/quadratic_model.hpp"
#include "optimize/nlp/sqp/hessian_model.hpp"
#include "optimize/nlp/sqp/merit.hpp"

/// The quadratic model of a step of sqp within the trust region. Internal.
namespace strake {

class StepModel {
public:
    StepModel(SqpIterate& now, const HessianModel& hessian, const Merit& merit)
        : radius(now.guard.options.first_step), now_(now), hessian_(hessian), merit_(merit) {}

    double radius;
    std::optional<FailureCut> cut;  ///< the next step keeps to its side; none: no border of failures is known

    /// With the cut, if there is one.
    QuadraticModel model(const Eigen::VectorXd& constraints, double damping) const;
    QuadraticModel model_without_cut(const Eigen::VectorXd& constraints, double damping) const;
    /// The model of the last step.
    QuadraticModel last_model() const { return model(now_.at.constraints, damping_); }

    /// From now on the model keeps to these conditions, too, on steps from the present point: until the search moves
    /// on.
    void add_limits(const StepLimits& limits) { append(limits_, limits); }
    void forget_limits() { limits_ = {}; }

    /// The model's step, no longer than the radius: the damping that it takes is found by bisection of its logarithm,
    /// or by secants (`MinimizeOptions::damps_by_secants`). Empty: the model cannot be solved.
    Eigen::VectorXd step(const Eigen::VectorXd& constraints);
    /// From the present constraints. Where the metric at this point finds the step too long (a direction has become
    /// soft), the metric is updated, positive definite (BFGS with the exact product), and the step is computed again.
    Eigen::VectorXd step_in_present_metric();

    /// The active set of a model's step d, by the numbers of the program's own constraints.
    ActiveSet active(const QuadraticModel& model, const Eigen::VectorXd& d) const;

    /// Without the cut the step would be another one.
    bool is_cut_off(const Eigen::VectorXd& d) const;
    /// The radius shortened the last step.
    bool is_limited() const { return is_limited_; }
    double length(const Eigen::VectorXd& d) const { return metric_norm(now_.program, d); }
    double damping() const { return damping_; }

private:
    Eigen::VectorXd damped_by_secants(const Eigen::VectorXd& constraints, double undamped, double size);

    SqpIterate& now_;
    const HessianModel& hessian_;
    const Merit& merit_;
    StepLimits limits_;  ///< on steps from the present point, beside those of its evaluation
    double damping_ = 0;
    bool is_limited_ = false;
};

/// Multipliers of the constraints of the set at `evaluation`.
Eigen::VectorXd multipliers_of(const SqpIterate& now, const Evaluation& evaluation, const ActiveSet& set);

}  // namespace strake
