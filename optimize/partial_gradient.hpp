#pragma once
#include "optimize/minimizer.hpp"

/// Gradients by differences that are paid only where they are not known well enough already. Internal.
namespace strake {

/// A gradient before differences are paid for it.
struct GradientGuess {
    Eigen::VectorXd gradient;
    Eigen::MatrixXd jacobian;
    Eigen::MatrixXd directions;  ///< n x k, of size about 1 in the metric: the slopes along these are to be paid
    Eigen::MatrixXd metric;      ///< of all gradients with these slopes the one nearest to the guess is taken
    bool is_complete = false;    ///< with these slopes nothing is guessed any more
};

/// Slopes along the guess's directions, and along variables that a bound keeps from taking part in them; the sample's
/// gradient is the guess with these slopes. Rows of the constraints that have gradients of their own keep them.
/// False: a point failed on either side; the sample is as it was.
/// @param evaluate as the program's, and counts. @param expect told the points before they are evaluated; may be empty.
bool differentiate_along(const NonlinearProgram& program, const Eigen::VectorXd& x, Sample& sample,
                         const GradientGuess& guess, const std::function<Sample(const Eigen::VectorXd& x)>& evaluate,
                         const std::function<void(const std::vector<Eigen::VectorXd>&)>& expect = {});

/// How well the gradient at the present point of a search is known, direction by direction of the metric's
/// eigenvectors.
class GradientDoubt {
public:
    GradientDoubt() = default;
    /// @param known_before columns: gradients by which what is known at the start may be off; may be empty.
    GradientDoubt(const Eigen::MatrixXd& metric, const Eigen::MatrixXd& known_before);

    bool is_certain() const { return squared_.size() == 0 || squared_.isZero(0); }
    /// A step over which the gradient is expected to change by this, and may change by as much more.
    void moved(const Eigen::VectorXd& change);
    /// Directions that hold this share of the doubt, the most doubtful first; 1: all that are in doubt.
    std::vector<int> most_doubtful(double share) const;
    Eigen::MatrixXd directions(const std::vector<int>& which) const { return modes_(Eigen::all, which); }
    void paid(const std::vector<int>& which) { squared_(which).setZero(); }
    void paid_all() { squared_.setZero(); }
    Eigen::MatrixXd remaining() const;  ///< as `known_before` of the next search
    const Eigen::MatrixXd& metric() const { return metric_; }

private:
    Eigen::MatrixXd metric_;
    Eigen::MatrixXd modes_;    ///< of size 1 in the metric, orthogonal in it
    Eigen::MatrixXd duals_;    ///< metric * modes
    Eigen::VectorXd squared_;  ///< doubt along each mode; empty: none
};

/// What a level knows of its first gradient from the one above it: the slopes along the columns of `prolongation` are
/// those of the gradient there, only those of the details have to be paid. None where that gradient is not known.
/// @param doubt of the parent, as GradientDoubt takes it; may be empty
std::optional<StartGradient> inherited_gradient(const Sample& parent, const Eigen::MatrixXd& doubt,
                                                const Eigen::MatrixXd& prolongation, const Eigen::MatrixXd& metric);

}  // namespace strake
