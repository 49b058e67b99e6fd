#pragma once
#include "optimize/nlp/program/nonlinear_program.hpp"

/// What the values of an expensive program say of its cheap one: f = rho f_low + r, and r is small and smooth.
/// Internal.
///
/// About the present point x, r(x + d) = r(x) + s.d + d.Q d / 2. rho, s and Q are the mean of a normal distribution,
/// given all differences of values between evaluated points and x, each over its length, and all known slopes. Before
/// them rho has the first scale with a deviation as large; s in any direction of length 1 in the metric the deviation
/// sigma, and Q over a step of length 1 changes slopes by as much. sigma over the slope of the cheap program is the one
/// of a few ratios that the data, and a preference for a small residual, find most likely: the less the cheap program
/// has to do with the expensive one, the larger it becomes, and the less of rho remains.
namespace strake {

class ResidualModel {
public:
    /// @param metric of the program, n x n. @param first_scale of rho, per value
    ResidualModel(const Eigen::MatrixXd& metric, std::vector<LowFidelityValue> kinds, Eigen::VectorXd first_scale);

    /// Values (objective first) of both programs at x.
    void add_point(const Eigen::VectorXd& x, const Eigen::VectorXd& values, const Eigen::VectorXd& low);
    /// Slopes at x along columns of length 1 in the metric: directions x values.
    void add_slopes(const Eigen::VectorXd& x, const Eigen::MatrixXd& directions, const Eigen::MatrixXd& slopes,
                    const Eigen::MatrixXd& low_slopes);

    /// About x, an added point, with the gradients of the cheap program there (n x values).
    void fit(const Eigen::VectorXd& x, const Eigen::MatrixXd& low_gradients);

    /// The rest is of the last fit.
    const Eigen::VectorXd& rho() const { return rho_; }
    const Eigen::MatrixXd& slopes() const { return slopes_; }  ///< s, n x values
    const Eigen::MatrixXd& hessian(Eigen::Index value) const { return hessians_[static_cast<std::size_t>(value)]; }
    /// The gradients of the expensive program: rho g_low + s.
    Eigen::MatrixXd gradients() const;
    /// Of the slopes of value i, what the cheap program says of them: the largest that it had, times rho, against
    /// sigma.
    double share(Eigen::Index value) const { return share_[value]; }
    /// Covariance of the weighted sum of the gradients in whitened variables z = root() x; weights of different values
    /// are taken as independent.
    Eigen::MatrixXd covariance(const Eigen::VectorXd& weights) const;
    const Eigen::MatrixXd& root() const { return root_; }  ///< metric = root^T root
    /// Value i has neither data nor a cheap slope: nothing is known of where it falls.
    bool is_blind(Eigen::Index value) const {
        return kinds_[static_cast<std::size_t>(value)] != LowFidelityValue::same && deviation_[value] == 0;
    }

private:
    struct Point {
        Eigen::VectorXd z, values, low;
    };
    struct Slopes {
        Eigen::VectorXd z;
        Eigen::MatrixXd directions;  ///< whitened
        Eigen::MatrixXd slopes, low;
    };
    /// Functionals s.a + <Q, p v^T + v p^T> / 2, and what they are of each value.
    struct Data {
        Eigen::MatrixXd a, p, v;    ///< columns
        Eigen::MatrixXd high, low;  ///< data x values
        Eigen::VectorXd reach;      ///< distance from x
        Eigen::VectorXd unknown;    ///< what third derivatives may add, over sigma
    };
    Data data_about(const Eigen::VectorXd& z) const;
    void fit_value(Eigen::Index i, const Data& data, const Eigen::MatrixXd& kernel);

    Eigen::MatrixXd root_;
    std::vector<LowFidelityValue> kinds_;
    Eigen::VectorXd first_scale_;
    std::vector<Point> points_;
    std::vector<Slopes> slopes_known_;
    Eigen::VectorXd largest_low_slope_;
    Eigen::MatrixXd low_gradients_;  ///< whitened, n x values
    Eigen::VectorXd rho_, deviation_, share_;
    Eigen::MatrixXd slopes_;
    std::vector<Eigen::MatrixXd> hessians_, covariances_;
};

}  // namespace strake
