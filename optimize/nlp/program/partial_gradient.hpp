#pragma once
#include "optimize/nlp/program/nonlinear_program.hpp"

/// Gradients by differences that are evaluated only where they are not known well enough already. Internal.
namespace strake {

/// A gradient before its differences are evaluated.
struct GradientGuess {
    Eigen::VectorXd gradient;
    Eigen::MatrixXd jacobian;
    Eigen::MatrixXd directions;  ///< n x k, of size about 1 in the metric: the slopes along these are evaluated
    Eigen::MatrixXd metric;      ///< the nearest gradient to the guess with these slopes is taken
    bool is_complete = false;    ///< with these slopes nothing of the gradient is guessed
};

/// Evaluates slopes along the guess's directions, and along variables that a bound keeps out of them; the evaluation's
/// gradient becomes the guess with these slopes. Constraints with gradients of their own keep them.
/// False: a point failed on either side; the evaluation is unchanged.
/// @param evaluate the program's, counted. @param expect receives the points before they are evaluated; may be empty.
bool differentiate_along(const NonlinearProgram& program, const Eigen::VectorXd& x, Evaluation& evaluation,
                         const GradientGuess& guess,
                         const std::function<Evaluation(const Eigen::VectorXd& x)>& evaluate,
                         const std::function<void(const std::vector<Eigen::VectorXd>&)>& expect = {});

/// The error of the gradient at the present point of a search, along each eigenvector of the metric.
class GradientError {
public:
    GradientError() = default;
    /// @param at_start columns: gradients by which that at the start may be off; may be empty.
    GradientError(const Eigen::MatrixXd& metric, const Eigen::MatrixXd& at_start);

    bool is_exact() const { return squared_.size() == 0 || squared_.isZero(0); }
    /// After a step over which the gradient is expected to change by this, with an error of the same size.
    void add_change(const Eigen::VectorXd& change);
    /// Directions that hold this share of the squared error, the largest first; 1: all with an error.
    std::vector<int> largest(double share) const;
    Eigen::MatrixXd directions(const std::vector<int>& which) const { return modes_(Eigen::all, which); }
    void clear(const std::vector<int>& which) { squared_(which).setZero(); }
    void clear_all() { squared_.setZero(); }
    Eigen::MatrixXd remaining() const;  ///< `at_start` of the next search
    const Eigen::MatrixXd& metric() const { return metric_; }

private:
    Eigen::MatrixXd metric_;
    Eigen::MatrixXd modes_;    ///< of size 1 in the metric, orthogonal in it
    Eigen::MatrixXd duals_;    ///< metric * modes
    Eigen::VectorXd squared_;  ///< error along each mode; empty: none
};

/// The first gradient of a level as far as the level above gives it: the slopes along the columns of `prolongation` are
/// those of the gradient there, only those along new directions have to be evaluated. None without that gradient.
/// @param gradient_error of the parent: columns, by which its gradient may be off; may be empty
std::optional<StartGradient> inherited_gradient(const Evaluation& parent, const Eigen::MatrixXd& gradient_error,
                                                const Eigen::MatrixXd& prolongation, const Eigen::MatrixXd& metric);

}  // namespace strake
