#pragma once
#include "optimize/nlp/surrogate/gaussian_process.hpp"

/// The kernel of a Gaussian process that explains given values best. Internal to it.
namespace strake {

/// Covariances of the points (n x d, one a row) over s^2, the nugget on the diagonal.
Eigen::MatrixXd correlations(const Eigen::MatrixXd& points, const Kernel& kernel);

/// Restricted likelihood of a kernel, with priors: lower is better.
class Likelihood {
public:
    /// That the prior prefers: spreads of the coordinate times the root of the number of coordinates.
    static constexpr double usual_length = 3;

    /// @param terms n x p, of full rank, p < n @param options what bounds the kernel
    Likelihood(const Eigen::MatrixXd& points, const Eigen::VectorXd& values, const Eigen::MatrixXd& terms,
               std::vector<int> group, const GaussianProcessOptions& options);

    /// -2 log of likelihood times priors at theta = (log length of each group, log nugget), and its gradient; infinite
    /// where the correlations are not positive definite.
    double operator()(const Eigen::VectorXd& theta, Eigen::VectorXd& gradient) const;

    /// The best theta from `start`, or without one from fixed starts.
    Kernel best(const Kernel* start) const;
    Kernel kernel(const Eigen::VectorXd& theta) const;
    /// Log lengths that the prior prefers, in the middle of the bounds.
    const Eigen::VectorXd& usual() const { return usual_; }

private:
    Eigen::VectorXd theta_of(const Kernel& kernel) const;
    double descend(Eigen::VectorXd& theta) const;

    const Eigen::MatrixXd& points_;
    const Eigen::VectorXd& values_;
    const Eigen::MatrixXd& terms_;
    std::vector<int> group_;
    std::vector<Eigen::MatrixXd> square_distance_;  ///< of each group, n x n
    Eigen::VectorXd usual_, lower_, upper_;
};

}  // namespace strake
