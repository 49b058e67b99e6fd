#pragma once
#include "optimize/nlp/program/nonlinear_program.hpp"
#include "optimize/nlp/program/value_noise.hpp"

/// What the values of a search say of its gradients, without an evaluation more. Internal.
///
/// Between differentiated points x and x + d a value changes by (g(x) + g(x + d)).d / 2, up to the third order of d
/// (trapezoidal rule). Steps along which this holds confirm the gradient in their direction; where it does not, the
/// step was long, the value noisy, or the gradient is wrong.
namespace strake {

/// A value whose change is not what its gradient says.
struct SlopeMismatch {
    int row = -1;  ///< -1: the objective, otherwise of the constraints
    double expected = 0, found = 0;
    double ratio() const { return found / expected; }
};

class GradientEvidence {
public:
    /// Values at x, which were evaluated after those of the last call.
    void add_values(const Eigen::VectorXd& x, const Evaluation& evaluation);
    /// Gradients at x; values known from `add_values` or before.
    void add_gradients(const Eigen::VectorXd& x, const Evaluation& evaluation);

    /// Steps whose direction is confirmed for all values that changed measurably.
    const std::vector<Eigen::VectorXd>& confirmed() const { return confirmed_; }
    /// The last steps, or the last ever shorter attempts from one point, do not follow the gradient.
    bool is_contradicted() const;
    /// A value followed its gradient times the same factor, which is not 1, over the last three steps or more: the
    /// last of them.
    std::optional<SlopeMismatch> wrong_factor() const;
    /// How far the last confirmed steps are from the rule, per value (objective first): a bound of the noise. Empty:
    /// there is no such step.
    Eigen::VectorXd deviations() const;
    double noise() const { return noise_.level(); }  ///< of the objective; 0: not known
    /// The last differentiated point; empty: none.
    const Eigen::VectorXd& base() const { return x_; }
    const Evaluation& at_base() const { return at_; }

private:
    struct Step {
        bool is_confirmed = false, is_contradicted = false;
        Eigen::VectorXd expected, found;  ///< per value; NaN: not measurable
    };
    void add_step(const Eigen::VectorXd& x, const Evaluation& evaluation);
    void add_attempt(const Eigen::VectorXd& d, double found);

    Eigen::VectorXd x_;
    Evaluation at_;
    std::vector<Eigen::VectorXd> confirmed_;
    std::vector<Step> steps_;                  ///< the last ones
    std::vector<double> lengths_;              ///< of the attempts from x in a row that do not follow the gradient
    Eigen::VectorXd direction_;                ///< of the last attempt
    std::vector<Eigen::VectorXd> deviations_;  ///< of the last confirmed steps
    ValueNoise noise_;
};

}  // namespace strake
