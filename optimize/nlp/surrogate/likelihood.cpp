#include "optimize/nlp/surrogate/likelihood.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Of the logarithm of a length: a function of many coordinates depends a little on each, or much on few.
constexpr double length_deviation = 1.5;
constexpr double bounds = 5;  ///< of the logarithm of a length about the usual one
constexpr double max_nugget = 1;
constexpr int max_iterations = 40;
constexpr double enough = 1e-3;  ///< decrease of an iteration: less changes no prediction

/// Squared distances in the coordinates of a group.
MatrixXd square_distances(const MatrixXd& points, const std::vector<int>& group, int number) {
    const Eigen::Index n = points.rows();
    MatrixXd sum = MatrixXd::Zero(n, n);
    for (Eigen::Index j = 0; j < points.cols(); ++j)
        if (group[static_cast<std::size_t>(j)] == number)
            for (Eigen::Index k = 0; k < n; ++k) sum.col(k).array() += (points.col(j).array() - points(k, j)).square();
    return sum;
}

}  // namespace

MatrixXd correlations(const MatrixXd& points, const Kernel& kernel) {
    const MatrixXd scaled = points * kernel.length.cwiseInverse().asDiagonal();
    const Eigen::Index n = points.rows();
    MatrixXd C(n, n);
    for (Eigen::Index k = 0; k < n; ++k) {
        auto square = C.col(k).head(k);  // of distances; by coordinates, whose points lie together in memory
        square.setZero();
        for (Eigen::Index j = 0; j < points.cols(); ++j)
            square.array() += (scaled.col(j).head(k).array() - scaled(k, j)).square();
        C(k, k) = 1 + kernel.nugget;
        for (Eigen::Index i = 0; i < k; ++i) C(i, k) = C(k, i) = std::exp(-0.5 * square[i]);
    }
    return C;
}

Likelihood::Likelihood(const MatrixXd& points, const VectorXd& values, const MatrixXd& terms, std::vector<int> group,
                       const GaussianProcessOptions& options)
    : points_(points), values_(values), terms_(terms), group_(std::move(group)) {
    const int groups = 1 + *std::max_element(group_.begin(), group_.end());
    usual_.resize(groups + 1);
    lower_.resize(groups + 1);
    const double all = std::sqrt(static_cast<double>(points.cols()));
    // n points in d dimensions are so much nearer to their neighbours than to each other.
    const double spacing = std::pow(static_cast<double>(points.rows()), -1.0 / static_cast<double>(points.cols()));
    for (int g = 0; g < groups; ++g) {
        square_distance_.push_back(square_distances(points, group_, g));
        const auto members = static_cast<double>(std::count(group_.begin(), group_.end(), g));
        const double pairs = std::max(1.0, static_cast<double>(points.rows() * (points.rows() - 1)));
        const double spread = std::sqrt(square_distance_.back().sum() / pairs / 2 / members);
        usual_[g] = std::log((spread > 0 ? spread : 1) * usual_length * all);
        lower_[g] = usual_[g] + std::max(-bounds, std::log(options.min_length / usual_length * spacing));
    }
    upper_ = usual_.array() + bounds;
    lower_[groups] = std::log(options.min_nugget);
    upper_[groups] = std::log(max_nugget);
    usual_[groups] = std::log(std::max(options.min_nugget, 1e-4));
}

Kernel Likelihood::kernel(const VectorXd& theta) const {
    Kernel kernel{VectorXd(points_.cols()), std::exp(theta[theta.size() - 1])};
    for (Eigen::Index j = 0; j < points_.cols(); ++j)
        kernel.length[j] = std::exp(theta[group_[static_cast<std::size_t>(j)]]);
    return kernel;
}

VectorXd Likelihood::theta_of(const Kernel& kernel) const {
    VectorXd theta = usual_;
    for (Eigen::Index j = 0; j < points_.cols(); ++j)
        theta[group_[static_cast<std::size_t>(j)]] = std::log(kernel.length[j]);
    theta[theta.size() - 1] = std::log(kernel.nugget);
    return theta.cwiseMax(lower_).cwiseMin(upper_);
}

/// L = (n - p) log s^2 + log |C| + log |H' C^-1 H|,  dL = tr(P dC) - y' P dC P y / s^2,  s^2 = y' P y / (n - p).
double Likelihood::operator()(const VectorXd& theta, VectorXd& gradient) const {
    const Eigen::Index n = points_.rows(), p = terms_.cols(), groups = theta.size() - 1;
    constexpr double none = std::numeric_limits<double>::infinity();
    MatrixXd exponent = MatrixXd::Zero(n, n);
    for (Eigen::Index g = 0; g < groups; ++g)
        exponent += std::exp(-2 * theta[g]) * square_distance_[static_cast<std::size_t>(g)];
    const MatrixXd R = (-0.5 * exponent).array().exp();
    const double nugget = std::exp(theta[groups]);
    MatrixXd C = R;
    C.diagonal().array() += nugget;
    const Eigen::LLT<MatrixXd> llt(C);
    if (llt.info() != Eigen::Success) return none;
    MatrixXd P = llt.solve(MatrixXd::Identity(n, n));
    const MatrixXd CH = P * terms_, HCH = terms_.transpose() * CH;
    const Eigen::LLT<MatrixXd> inner(HCH);
    if (inner.info() != Eigen::Success) return none;
    P -= CH * inner.solve(CH.transpose());
    const VectorXd Py = P * values_;
    const double square = values_.dot(Py) / static_cast<double>(n - p);
    if (!(square > 0)) return none;
    const auto log_determinant = [](const Eigen::LLT<MatrixXd>& of) {
        return 2 * of.matrixLLT().diagonal().array().log().sum();
    };
    double value = static_cast<double>(n - p) * std::log(square) + log_determinant(llt) + log_determinant(inner);
    gradient.setZero(theta.size());
    const MatrixXd weight = (P - Py * Py.transpose() / square).cwiseProduct(R);
    for (Eigen::Index g = 0; g < groups; ++g) {
        const double off = (theta[g] - usual_[g]) / length_deviation;
        value += off * off;
        gradient[g] =
            std::exp(-2 * theta[g]) * weight.cwiseProduct(square_distance_[static_cast<std::size_t>(g)]).sum() +
            2 * off / length_deviation;
    }
    gradient[groups] = nugget * (P.trace() - Py.squaredNorm() / square);
    return value;
}

/// BFGS with projection onto the bounds.
double Likelihood::descend(VectorXd& theta) const {
    const Eigen::Index size = theta.size();
    VectorXd gradient;
    double value = (*this)(theta, gradient);
    if (!std::isfinite(value)) return value;
    MatrixXd inverse = MatrixXd::Identity(size, size) / std::max(1.0, gradient.norm());
    for (int i = 0; i < max_iterations; ++i) {
        VectorXd step = -(inverse * gradient);
        if (!(step.dot(gradient) < 0)) step = -gradient;
        step *= std::min(1.0, 2 / step.lpNorm<Eigen::Infinity>());
        VectorXd next, slope;
        double there = std::numeric_limits<double>::infinity();
        for (int cut = 0; cut < 12; ++cut, step *= 0.4) {
            next = (theta + step).cwiseMax(lower_).cwiseMin(upper_);
            there = (*this)(next, slope);
            if (there <= value + 1e-4 * gradient.dot(next - theta)) break;
        }
        if (!(there < value)) break;
        const VectorXd d = next - theta, y = slope - gradient;
        const double decrease = value - there;
        if (const double dy = d.dot(y); dy > 1e-10 * d.norm() * y.norm()) {
            if (i == 0) inverse = MatrixXd::Identity(size, size) * (dy / y.squaredNorm());
            const MatrixXd left = MatrixXd::Identity(size, size) - d * y.transpose() / dy;
            inverse = (left * inverse * left.transpose() + d * d.transpose() / dy).eval();
        }
        theta = next, gradient = slope, value = there;
        if (decrease < enough) break;
    }
    return value;
}

Kernel Likelihood::best(const Kernel* start) const {
    std::vector<VectorXd> starts;
    if (start) {
        starts.push_back(theta_of(*start));
    } else {
        starts.assign(2, usual_);
        // Short lengths have a basin of their own, which may end below the bound: few points are not held to that.
        starts[1].head(usual_.size() - 1).array() -= 2;
    }
    VectorXd best = usual_;
    double lowest = std::numeric_limits<double>::infinity();
    for (VectorXd theta : starts)
        if (const double value = descend(theta); value < lowest) lowest = value, best = theta;
    return kernel(best);
}

}  // namespace strake
