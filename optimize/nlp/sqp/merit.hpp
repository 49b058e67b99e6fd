#pragma once
#include "optimize/nlp/sqp/iterate.hpp"

/// What decides about a step of sqp: objective + penalty * sum of the violations. Internal.
namespace strake {

/// The penalty itself is kept in the guard, which reports the merit of each point.
class Merit {
public:
    explicit Merit(const SqpIterate& now) : now_(now) {}

    double of(const Evaluation& evaluation) const;
    double at_present() const { return of(now_.at); }
    /// Moves the limits of the inequalities slightly inward.
    Eigen::VectorXd tightened(Eigen::VectorXd constraints) const;
    /// By how much the step d reduces the violations, to first order.
    double violation_decrease(const Eigen::VectorXd& d) const;
    /// The decrease that a model with this Hessian expects of d; `objective`: of the objective alone.
    double expected_decrease(const Eigen::MatrixXd& hessian, const Eigen::VectorXd& d) const;
    double expected_decrease(double objective, double violation) const;

    void raise_penalty(double minimum);
    /// After an accepted step: half way to what its multipliers need, where that is less (Powell 1978). A penalty that
    /// is much too large takes the curvature of the constraints for a reason to make short steps.
    void adapt_penalty(double needed, bool is_feasible);

private:
    const SqpIterate& now_;
};

/// The decrease of the objective that the quadratic model expects of d.
double model_decrease(const SqpIterate& now, const Eigen::MatrixXd& hessian, const Eigen::VectorXd& d);

}  // namespace strake
