#include "optimize/nlp/surrogate/local_models.hpp"

#include "optimize/nlp/program/first_order.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int max_points = 200, max_points_per_term = 30;  ///< whichever is less: cost is cubic in them
constexpr double reach = 20;                               ///< radii
constexpr int min_points_per_term = 4;
/// With so many points a coordinate, and few coordinates, each has a length scale of its own.
constexpr int points_per_length = 5;
constexpr Eigen::Index max_lengths = 12, max_quadratic = 10;
constexpr double shortest_length = 1.1;  ///< that models may have, in spacings of their points
constexpr double beside = 0.1;  ///< of its distance from the start, that a point has from the directions of a search
constexpr double min_curvature = 0.1;         ///< of the mean: what models do not know bends at least so
constexpr double min_curvature_share = 0.01;  ///< of its size that is not the metric's

}  // namespace

SampledPoints::SampledPoints(const Guard& guard)
    : program_(guard.program), free_(guard.free), min_length_(guard.options.follows_short_waves ? 0 : shortest_length) {
    const MatrixXd metric = metric_of(program_);
    U_ = MatrixXd(metric(free_, free_)).llt().matrixU();
    const MatrixXd& second = program_.second_curvature;
    if (second.size() == 0 || dimensions() > max_variables_with_curvature) return;
    const auto half_by_z = [&](const MatrixXd& of) -> MatrixXd {
        return U_.triangularView<Eigen::Upper>().transpose().solve(of);
    };
    MatrixXd by_z = half_by_z(half_by_z(second(free_, free_)).transpose());
    const double d = static_cast<double>(dimensions()), size = by_z.norm();
    by_z.diagonal().array() -= by_z.trace() / d;
    if (!(by_z.norm() > min_curvature_share * size)) return;
    curvature_ = std::sqrt(d) / (2 * by_z.norm()) * (by_z + by_z.transpose());
}

VectorXd SampledPoints::whitened(const VectorXd& x) const {
    const VectorXd d = x - program_.start;
    const VectorXd all = U_ * d(free_);
    return Q_.size() > 0 ? VectorXd(Q_.transpose() * all) : all;
}

VectorXd SampledPoints::variables(const VectorXd& z) const {
    VectorXd x = program_.start;
    const VectorXd all = Q_.size() > 0 ? VectorXd(Q_ * z) : z;
    x(free_) += U_.triangularView<Eigen::Upper>().solve(all);  // not of a matrix: other bits
    return x.cwiseMax(program_.lower).cwiseMin(program_.upper);
}

VectorXd SampledPoints::within_directions(const VectorXd& x) const {
    return Q_.size() > 0 ? variables(whitened(x)) : x;
}

VectorXd SampledPoints::unwhitened(const VectorXd& gradient) const {
    VectorXd g = VectorXd::Zero(program_.start.size());
    g(free_) = U_.transpose() * (Q_.size() > 0 ? VectorXd(Q_ * gradient) : gradient);
    return g;
}

VectorXd SampledPoints::gradient_by_z(const VectorXd& gradient) const {
    const VectorXd all = U_.triangularView<Eigen::Upper>().transpose().solve(VectorXd(gradient(free_)));
    return Q_.size() > 0 ? VectorXd(Q_.transpose() * all) : all;
}

MatrixXd SampledPoints::by_variables() const { return Q_.size() > 0 ? MatrixXd(Q_.transpose() * U_) : U_; }

MatrixXd SampledPoints::free_along(const MatrixXd& directions) const {
    return U_.triangularView<Eigen::Upper>().solve(Q_.size() > 0 ? MatrixXd(Q_ * directions) : directions);
}

void SampledPoints::restrict_to(const MatrixXd& Q) {
    Q_ = Q_.size() > 0 ? MatrixXd(Q_ * Q) : Q;
    if (curvature_.size() > 0) curvature_ = Q.transpose() * curvature_ * Q;
    const auto is_forgotten = [&](const Point& point) { return is_beside(point.x); };
    points_.erase(std::remove_if(points_.begin() + 1, points_.end(), is_forgotten), points_.end());  // not the start
    for (Point& point : points_) point.z = whitened(point.x);
    for (VectorXd& z : failed_) z = Q.transpose() * z;
}

/// Its values would be taken for those of another design.
bool SampledPoints::is_beside(const VectorXd& x) const {
    if (Q_.size() == 0) return false;
    const VectorXd d = x - program_.start, all = U_ * d(free_);
    return (all - Q_ * (Q_.transpose() * all)).norm() > beside * all.norm();
}

void SampledPoints::add(const VectorXd& x, const Evaluation& evaluation) {
    if (is_beside(x)) return;
    if (evaluation.failure.empty())
        points_.push_back({x, whitened(x), values_of(evaluation)});
    else
        failed_.push_back(whitened(x));
}

MatrixXd SampledPoints::positive_hessian(const MatrixXd& by_z) const {
    const Eigen::SelfAdjointEigenSolver<MatrixXd> of(0.5 * (by_z + by_z.transpose()));
    const double mean = of.eigenvalues().cwiseAbs().mean();
    if (!(mean > 0)) return {};
    const VectorXd curvature = of.eigenvalues().cwiseMax(min_curvature * mean);
    MatrixXd hessian = metric_of(program_) * mean;
    const MatrixXd z_by_x = by_variables();
    if (z_by_x.rows() == z_by_x.cols()) {
        const MatrixXd root = z_by_x.transpose() * of.eigenvectors() * curvature.cwiseSqrt().asDiagonal();
        hessian(free_, free_) = root * root.transpose();
    } else {
        const MatrixXd more =
            of.eigenvectors() * (curvature.array() - mean).matrix().asDiagonal() * of.eigenvectors().transpose();
        hessian(free_, free_) += z_by_x.transpose() * more * z_by_x;
    }
    return hessian;
}

bool SampledPoints::knows(const VectorXd& z, double distance) const {
    const auto is_near = [&](const VectorXd& other) { return (other - z).norm() <= distance; };
    return std::ranges::any_of(points_, is_near, &Point::z) || std::ranges::any_of(failed_, is_near);
}

std::vector<VectorXd> SampledPoints::steps(const VectorXd& centre, double reach) const {
    std::vector<VectorXd> steps;
    for (std::size_t i = 1; i < points_.size(); ++i) steps.push_back(points_[i].z - points_[0].z);
    for (const VectorXd& failed : failed_)
        if (const VectorXd step = failed - centre; step.norm() <= reach) steps.push_back(step);
    return steps;
}

std::vector<int> SampledPoints::nearest(const VectorXd& z, double reach, int min, int max) const {
    std::vector<int> order(points_.size());
    std::iota(order.begin(), order.end(), 0);
    const auto distance = [&](int i) { return ((*this)[i].z - z).norm(); };
    std::ranges::stable_sort(order, {}, distance);
    auto used = static_cast<std::size_t>(std::min(size(), max));
    while (used > static_cast<std::size_t>(min) && distance(order[used - 1]) > reach) --used;
    order.resize(used);
    std::ranges::sort(order);
    return order;
}

LocalModels::LocalModels(const SampledPoints& points, const VectorXd& z, double radius, bool shares_curvature,
                         const LocalModels* before) {
    const Eigen::Index d = points.dimensions();
    const int terms = static_cast<int>(d + 1);
    used_ = points.nearest(z, reach * radius, min_points_per_term * terms,
                           std::min(max_points, max_points_per_term * terms));
    const auto n = static_cast<Eigen::Index>(used_.size());
    MatrixXd at(n, d);
    for (Eigen::Index i = 0; i < n; ++i) at.row(i) = points[used_[static_cast<std::size_t>(i)]].z;
    GaussianProcessOptions options;
    options.min_length = points.min_length();
    options.trend = d <= max_quadratic ? Trend::quadratic : Trend::linear;
    if (shares_curvature) {
        options.square_about = z;
        options.square_form = points.curvature();
    }
    const bool has_lengths = d <= max_lengths && n >= points_per_length * d;
    if (!has_lengths) options.group.assign(static_cast<std::size_t>(d), 0);
    for (Eigen::Index row = 0; row < points[0].values.size(); ++row) {
        VectorXd values(n);
        for (Eigen::Index i = 0; i < n; ++i) values[i] = points[used_[static_cast<std::size_t>(i)]].values[row];
        rows_.emplace_back(at, values, options, before ? &(*before)[row].kernel() : nullptr);
    }
}

bool LocalModels::has_curvature() const {
    return std::ranges::any_of(rows_, [](const GaussianProcess& row) { return row.has_form(); });
}

VectorXd LocalModels::means(const VectorXd& z) const {
    VectorXd values(size());
    for (Eigen::Index i = 0; i < size(); ++i) values[i] = (*this)[i].mean(z);
    return values;
}

void LocalModels::believe(const VectorXd& z) {
    for (GaussianProcess& row : rows_) {
        MatrixXd points(row.points().rows() + 1, z.size());
        points << row.points(), z.transpose();
        VectorXd values(points.rows());
        values << row.values(), row.mean(z);
        row = row.with_points(std::move(points), std::move(values));
    }
}

}  // namespace strake
