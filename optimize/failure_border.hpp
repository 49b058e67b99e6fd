#pragma once
#include <Eigen/Core>
#include <deque>
#include <optional>

/// Where evaluations fail: a plane learned from the points that did and those that did not. Internal.
///
/// Flow solvers fail beyond some thickness, shells beyond some load: near the best design the border of what fails is
/// nearly flat. Shortening the step ends at the first point of it; a search that knows the border goes on along it.
namespace strake {

/// normal . x <= limit holds where evaluations are expected to give values.
struct FailureCut {
    Eigen::VectorXd normal;  ///< of length 1 in the dual metric
    double limit = 0;
};

class FailureBorder {
public:
    void add_sound(const Eigen::VectorXd& x);
    void add_failed(const Eigen::VectorXd& x);

    /// The plane of widest margin (support vector machine without slack: Boser, Guyon, Vapnik 1992) between the points
    /// that gave values, x among them, and those that failed, in the metric (n x n, positive definite). Margins count
    /// relative to the distance from x, so that far points say about the direction of the plane what near ones say
    /// about its place. Where no plane parts them, the failed points far from x are left out, for the border may be
    /// curved. Nothing: even the closest cannot be parted from the others, or fewer than two points have failed.
    /// @param caution ratio of the margin to the failed points over that to the others
    std::optional<FailureCut> cut(const Eigen::VectorXd& x, const Eigen::MatrixXd& metric, double caution = 1) const;

private:
    std::deque<Eigen::VectorXd> sound_, failed_;  ///< the latest
};

/// The border as a search goes on: each failure makes the next plane more careful, each new point bolder, so that
/// about every other step along it fails until it is known.
class BorderWatch {
public:
    explicit BorderWatch(const FailureBorder& border) : border_(border) {}
    void look(const Eigen::VectorXd& x, const Eigen::MatrixXd& metric);
    void has_moved(const Eigen::VectorXd& x, const Eigen::MatrixXd& metric);   ///< to x
    void has_failed(const Eigen::VectorXd& x, const Eigen::MatrixXd& metric);  ///< to move from x

    const std::optional<FailureCut>& cut() const { return cut_; }
    /// As far out as what failed allows.
    std::optional<FailureCut> furthest(const Eigen::VectorXd& x, const Eigen::MatrixXd& metric) const;

private:
    const FailureBorder& border_;
    std::optional<FailureCut> cut_;
    int failed_ = 0, moved_ = 1;  ///< in a row
};

}  // namespace strake
