#pragma once
#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <vector>

/// A Gaussian process: a smooth model of a function from some of its values, with its own error (kriging; Rasmussen and
/// Williams 2006, chapters 2 and 5).
///   f(x) = h(x).beta + z(x),   cov(z(x), z(y)) = s^2 (exp(-sum_j ((x_j - y_j) / l_j)^2 / 2) + nugget [x is y])
/// beta by generalized least squares; l and the nugget maximize the restricted likelihood (Patterson and Thompson 1971)
/// times weak priors, from fixed starts: the same points give the same bits.
namespace strake {

enum class Trend {
    constant,
    linear,    ///< 1, x_j
    quadratic  ///< and x_j x_k
};

struct GaussianProcessOptions {
    Trend trend = Trend::linear;  ///< a lower one where there are fewer than two points for each of its terms
    /// Per coordinate the number of its group, from 0 on: one length scale for each group. Empty: one for each
    /// coordinate (automatic relevance determination). All zero: isotropic.
    std::vector<int> group = {};
    double min_nugget = 1e-10;  ///< in (0, 1); what noise there is beyond it is estimated
    /// Of length scales, in [0, 3], in spacings of the points: their spread, times sqrt(d) n^(-1/d). Points tell
    /// nothing of waves that are shorter than what lies between them: with a bound these are noise, without one (0)
    /// a likelihood of few points may follow them, and all space but the points is unknown.
    /// Without a kernel to start from, lengths of 3 / e^2 that nothing within the bound beats are kept, too.
    double min_length = 0;
    /// One more term of a constant or linear trend, |x - this|^2: a curvature that all directions share. Empty: none.
    Eigen::VectorXd square_about = {};
    /// d x d, symmetric: beside it (x - square_about).this (x - square_about), where the points tell them apart. Empty:
    /// none.
    Eigen::MatrixXd square_form = {};
};

/// What the likelihood decides.
struct Kernel {
    Eigen::VectorXd length;  ///< per coordinate, > 0
    double nugget = 0;       ///< noise variance over s^2
};

class GaussianProcess {
public:
    /// @param points n x d, one a row; equal ones are averaged by the nugget. @param values n
    /// @param start where the search for the kernel begins, for example that of fewer points; null: fixed starts.
    /// @throws InvalidInput: no point, sizes, numbers that are not finite, wrong groups.
    /// Cost: some 50 times 2 n^3 + n^2 d flops.
    GaussianProcess(Eigen::MatrixXd points, Eigen::VectorXd values, const GaussianProcessOptions& options = {},
                    const Kernel* start = nullptr);

    /// The same kernel with other points, and the same trend, where these tell its terms apart: O(n^3).
    GaussianProcess with_points(Eigen::MatrixXd points, Eigen::VectorXd values) const;

    double mean(const Eigen::VectorXd& x) const;
    Eigen::VectorXd gradient(const Eigen::VectorXd& x) const;  ///< of the mean
    Eigen::MatrixXd hessian(const Eigen::VectorXd& x) const;   ///< of the mean, d x d
    double variance(const Eigen::VectorXd& x) const;  ///< of f(x) without noise; the trend's error included; >= 0
    Eigen::VectorXd variance_gradient(const Eigen::VectorXd& x) const;

    /// What a model of all other points errs by at each point, in closed form (Dubrule 1983): value - prediction, and
    /// the standard deviation that such a model states. Zero where a point alone carries a term of the trend.
    struct LeaveOneOut {
        Eigen::VectorXd error, deviation;
    };
    LeaveOneOut leave_one_out() const;
    /// Share of the variance of the values that such predictions explain, <= 1; 1 for constant values.
    double predicted_share() const;

    const Eigen::MatrixXd& points() const { return points_; }
    const Eigen::VectorXd& values() const { return values_; }
    const Kernel& kernel() const { return kernel_; }
    Trend trend() const { return trend_; }
    double scale() const { return std_; }  ///< s; 0: the trend explains all values
    double noise() const;                  ///< standard deviation of repeated values
    int num_terms() const { return static_cast<int>(beta_.size()); }
    bool has_form() const { return form_.size() > 0; }  ///< the trend has the term of `square_form`

    /// The mean as a sum of products of functions of one coordinate: weight(t) prod_j factor(j, x_j)(t), first the
    /// terms of the trend, the squared distance in parts for each coordinate, then one for each point.
    /// @throws InvalidInput: `has_form()`, which couples coordinates.
    Eigen::VectorXd weights() const;
    Eigen::VectorXd factors(int coordinate, double x) const;

private:
    void check(const std::vector<int>& group) const;
    void choose_trend();
    void keep_constant_trend();
    void check_is_sum() const;
    void leave_out_form();
    void evaluate_terms();  ///< H of the points
    bool has_square() const { return square_about_.size() > 0; }
    Eigen::Index num_squares() const { return has_square() + has_form(); }
    Eigen::Index first_square() const { return H_.cols() - num_squares(); }
    void fit();
    Eigen::VectorXd kernel_to(const Eigen::VectorXd& x) const;
    Eigen::VectorXd terms(const Eigen::VectorXd& x) const;
    Eigen::MatrixXd term_slopes(const Eigen::VectorXd& x) const;  ///< terms x d
    Eigen::MatrixXd projected_inverse() const;                    ///< P: P y = C^-1 (y - H beta)

    Eigen::MatrixXd points_;
    Eigen::VectorXd values_;
    Trend trend_ = Trend::linear;
    Eigen::VectorXd centre_, unit_;  ///< of the trend's terms: they are of size 1
    Eigen::VectorXd square_about_;   ///< of the squared distance; empty: there is no such term
    Eigen::MatrixXd form_;           ///< of a second one; empty: there is no such term
    double square_unit_ = 1;
    Kernel kernel_;
    double std_ = 0;
    Eigen::MatrixXd H_;                    ///< n x terms
    Eigen::LLT<Eigen::MatrixXd> C_, HCH_;  ///< s^2 = 1
    Eigen::VectorXd beta_, alpha_;         ///< alpha = C^-1 (y - H beta)
    Eigen::MatrixXd CH_;                   ///< C^-1 H
};

}  // namespace strake
