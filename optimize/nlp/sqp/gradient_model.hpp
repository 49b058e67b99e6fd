#pragma once
#include "optimize/nlp/program/partial_gradient.hpp"
#include "optimize/nlp/sqp/hessian_model.hpp"

/// Gradients by differences below the first level: what the level above, the model and the values already give is not
/// evaluated. Internal.
namespace strake {

class GradientModel {
public:
    GradientModel(const SqpIterate& now, const HessianModel& hessian);

    bool is_exact() const { return error_.is_exact(); }
    /// Evaluates and differentiates x, where the search goes next; by differences in those directions only in which the
    /// model is not exact enough. False: there is no value or gradient, with the guard's cause.
    bool differentiate(const Eigen::VectorXd& x, Evaluation& trial);
    /// The gradient at x, which is evaluated already, as far as the model and the values give it; what it may be off by
    /// counts as its error. Nothing is evaluated.
    bool estimate(const Eigen::VectorXd& x, Evaluation& trial);
    /// Evaluates all that is guessed of the gradient at the present point. False: it was exact, or could not be
    /// evaluated; the guard's cause is kept unless it is a failure.
    bool complete(Evaluation& at);
    Eigen::MatrixXd remaining_error() const { return error_.remaining(); }

private:
    GradientGuess guess(const Evaluation& trial, const Eigen::VectorXd& d) const;

    const SqpIterate& now_;
    const HessianModel& hessian_;
    GradientError error_;  ///< of the gradient at the present point
};

}  // namespace strake
