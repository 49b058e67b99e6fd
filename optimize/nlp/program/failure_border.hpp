#pragma once
#include <Eigen/Core>
#include <deque>
#include <optional>

/// Where evaluations fail: a plane learned from the points that failed and those that gave values. Internal.
///
/// Flow solvers fail beyond some thickness, shells beyond some load: near the best design the border of the failing
/// region is nearly flat. Shortening the step ends at its first point; a search that knows the border goes on along it.
namespace strake {

/// normal . x <= limit holds where evaluations are expected to give values.
struct FailureCut {
    Eigen::VectorXd normal;  ///< of length 1 in the dual metric
    double limit = 0;
};

/// The plane w.(u, 1) = 0, u = U (x - origin) / unit, as a normal distribution of w.
struct FailureClassifier {
    Eigen::VectorXd origin;
    Eigen::MatrixXd U;     ///< U^T U is the metric
    double unit = 1;       ///< distance from the origin to the closest point that failed
    Eigen::VectorXd mean;  ///< n + 1
    Eigen::MatrixXd covariance;

    /// Distance of x from the plane on the side that gives values, in standard deviations: Phi of it is the probability
    /// of a value.
    double z_score(const Eigen::VectorXd& x) const;
    /// The points whose z-score is at least `z_score`, to first order about x.
    FailureCut cut(const Eigen::VectorXd& x, double z_score) const;
    Eigen::VectorXd coordinates(const Eigen::VectorXd& x) const;  ///< (u, 1)
};

class FailureBorder {
public:
    void add_sound(const Eigen::VectorXd& x);
    void add_failed(const Eigen::VectorXd& x);

    /// All planes that separate the points with values, x among them, from those that failed are equally likely (Bayes
    /// point machine: Herbrich, Graepel, Campbell 2001), by expectation propagation (Minka 2001), in the metric (n x n,
    /// positive definite). The border may be curved: the further a point is from x, the less it counts. Failures that
    /// fit no such plane are chance and dropped, the worst first. Nothing: none is left, or fewer than two points have
    /// failed.
    std::optional<FailureClassifier> classifier(const Eigen::VectorXd& x, const Eigen::MatrixXd& metric) const;

private:
    std::deque<Eigen::VectorXd> sound_, failed_;  ///< the latest
};

}  // namespace strake
