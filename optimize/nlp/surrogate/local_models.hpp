#pragma once
#include "optimize/nlp/program/guard.hpp"
#include "optimize/nlp/surrogate/gaussian_process.hpp"

/// Models of a nonlinear program next to a point. Internal to the search by models.
namespace strake {

/// Points with values in whitened coordinates z = U (x - start) of the free variables, U^T U the metric: a length in
/// them is that of a step. Or z = Q^T U (x - start), of some orthonormal directions (`restrict_to`).
class SampledPoints {
public:
    explicit SampledPoints(const Guard& guard);

    Eigen::VectorXd whitened(const Eigen::VectorXd& x) const;   ///< of all variables
    Eigen::VectorXd variables(const Eigen::VectorXd& z) const;  ///< all of them, within the bounds
    /// A gradient by z as one by all variables.
    Eigen::VectorXd unwhitened(const Eigen::VectorXd& gradient) const;
    /// A gradient by all variables as one by z.
    Eigen::VectorXd gradient_by_z(const Eigen::VectorXd& gradient) const;
    void add(const Eigen::VectorXd& x, const Evaluation& evaluation);
    void forget_from(int point) { points_.erase(points_.begin() + point, points_.end()); }
    /// From here on z = Q^T U (x - start): the program is searched in these directions alone. Points beside them are
    /// forgotten, but for the first. @param Q orthonormal columns in the coordinates of before
    void restrict_to(const Eigen::MatrixXd& Q);
    /// x, or the design next to it that those directions have.
    Eigen::VectorXd within_directions(const Eigen::VectorXd& x) const;
    Eigen::MatrixXd by_variables() const;                                 ///< d z / d free variables
    Eigen::MatrixXd free_along(const Eigen::MatrixXd& directions) const;  ///< free variables by directions of z
    /// A Hessian by all variables, whose inverse makes steps: of a symmetric one by z, with curvatures of at least a
    /// tenth of their mean size; what z does not span has the metric's, as large as that mean. Empty: it is zero.
    Eigen::MatrixXd positive_hessian(const Eigen::MatrixXd& by_z) const;
    /// A point, with values or failed, is this near.
    bool knows(const Eigen::VectorXd& z, double distance) const;
    /// In z, from the first point to all others, and from `centre` to those that failed no farther away than `reach`.
    std::vector<Eigen::VectorXd> steps(const Eigen::VectorXd& centre, double reach) const;
    int size() const { return static_cast<int>(points_.size()); }
    Eigen::Index dimensions() const { return Q_.size() > 0 ? Q_.cols() : U_.cols(); }
    const std::vector<int>& free() const { return free_; }
    /// `NonlinearProgram::second_curvature` by z, without its mean (the metric has that), as large as the identity
    /// (Frobenius). Empty: the program has none, the metric is all of it, or there are too many variables.
    const Eigen::MatrixXd& curvature() const { return curvature_; }
    double min_length() const { return min_length_; }  ///< `GaussianProcessOptions::min_length` of their models

    struct Point {
        Eigen::VectorXd x, z, values;  ///< the objective first
    };
    const Point& operator[](int i) const { return points_[static_cast<std::size_t>(i)]; }
    /// The points that are nearest to z, in the order in which they came: at most `max`, and of those farther than
    /// `reach` only as many as make `min`.
    std::vector<int> nearest(const Eigen::VectorXd& z, double reach, int min, int max) const;

private:
    const NonlinearProgram& program_;
    const std::vector<int>& free_;
    bool is_beside(const Eigen::VectorXd& x) const;

    double min_length_;
    Eigen::MatrixXd U_, curvature_;
    Eigen::MatrixXd Q_;  ///< empty: all directions
    std::vector<Point> points_;
    std::vector<Eigen::VectorXd> failed_;
};

/// A Gaussian process for the objective and for each constraint, in z.
class LocalModels {
public:
    /// Of the points next to z. @param radius of the trust region: far beyond it points tell little.
    /// @param shares_curvature the trend has a curvature that all directions of z share: where the metric is right they
    /// have the same, and few points tell it; and that of `SampledPoints::curvature` beside it. @param before models of
    /// the step before, whose kernels are where the search for the new ones begins; may be null.
    LocalModels(const SampledPoints& points, const Eigen::VectorXd& z, double radius, bool shares_curvature,
                const LocalModels* before);

    const GaussianProcess& operator[](Eigen::Index row) const { return rows_[static_cast<std::size_t>(row)]; }
    Eigen::Index size() const { return static_cast<Eigen::Index>(rows_.size()); }
    const std::vector<int>& used() const { return used_; }  ///< numbers of the points
    /// A trend has `SampledPoints::curvature`: slopes are not combinations of directions to points.
    bool has_curvature() const;
    Eigen::VectorXd means(const Eigen::VectorXd& z) const;  ///< values, the objective first
    /// Takes the means at z for values there (kriging believer).
    void believe(const Eigen::VectorXd& z);

private:
    std::vector<GaussianProcess> rows_;
    std::vector<int> used_;
};

}  // namespace strake
