#pragma once
#include "optimize/nlp/surrogate/local_models.hpp"

#include <memory>

/// Directions that nothing is known of, and what a search by models expects of them. Internal.
namespace strake {

/// The directions in which a search has been: those of the steps in z from its start to points with values, and from
/// where it stands to what has failed.
class TriedDirections {
public:
    /// @param more points in z, not evaluated yet @param reach what failed farther from `centre` may be tried again,
    /// nearer
    TriedDirections(const SampledPoints& points, const Eigen::VectorXd& centre,
                    const std::vector<Eigen::VectorXd>& more, double reach);

    bool are_all() const { return basis_.cols() == basis_.rows(); }
    /// The share of a step's length that is orthogonal to them.
    double share_beyond(const Eigen::VectorXd& step) const;
    /// Of the first of some orthonormal directions that is for a half or more orthogonal to them, else of the one that
    /// is most, that part: a unit vector. Not where they `are_all`.
    Eigen::VectorXd first_beyond(const Eigen::MatrixXd& directions) const;

private:
    Eigen::MatrixXd beyond(const Eigen::MatrixXd& steps) const;

    Eigen::MatrixXd basis_;  ///< orthonormal columns
};

/// How far a search steps along what it knows nothing of: half of a radius that failures alone make shorter. What is
/// wrong about known directions says nothing of others.
class UntriedSteps {
public:
    explicit UntriedSteps(double first_step) : first_radius_(first_step), radius_(first_step) {}

    /// Null: all directions have been tried. Those that have failed are tried last, nearer and on the other side.
    std::unique_ptr<TriedDirections> tried(const SampledPoints& points, const Eigen::VectorXd& centre,
                                           const std::vector<Eigen::VectorXd>& more);
    /// Nothing can be evaluated along this direction: it counts as tried.
    void leave(const Eigen::VectorXd& direction) { left_.push_back(direction); }
    double radius() const { return radius_; }
    double length() const { return share_ * radius_; }  ///< after `tried`; < 0: against the direction
    /// @param has_failed most of a batch @param has_looked a batch that only looks around has not
    void learn(bool has_failed, bool has_looked);

private:
    double first_radius_, radius_, share_ = 0;
    std::vector<Eigen::VectorXd> left_;
};

/// The standard deviation of slopes along directions that nothing is known of, whatever values a model has: a radius r
/// says how far away its minimum is, so with the model's mean curvature c the gradient is some c r, in each of d
/// directions u = c r / sqrt(d). A likelihood does not know this: where the first slopes are zero, it is sure that all
/// are. Of n points the model's own deviation s / l, if it is smaller, has the weight n - 1, at most d, and u that of
/// six more (the variance of a scaled inverse chi-squared prior). Zero where the model is concave.
double unknown_slope(const GaussianProcess& model, const Eigen::VectorXd& z, double radius);

/// What such a direction lets a model fall by, once its slope is known: u^2 / 2 c.
double unknown_decrease(const GaussianProcess& model, const Eigen::VectorXd& z, double radius);

/// The factor by which standard deviations of the model fall short of such slopes, >= 1. The slope of a direction far
/// from all points has the deviation s / l.
double shortfall(const GaussianProcess& model, const Eigen::VectorXd& z, double radius);

}  // namespace strake
