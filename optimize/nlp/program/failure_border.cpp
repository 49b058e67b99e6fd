#include "optimize/nlp/program/failure_border.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::size_t max_sound = 120, max_failed = 60;
constexpr std::size_t min_failed = 2;
/// The border may be curved: a point at distance 1 in the metric determines the plane's angle to this accuracy only.
constexpr double curving = 0.2;
constexpr double max_misfit = 2;  ///< times that, a point may lie on the wrong side
constexpr int max_sweeps = 40;
constexpr double converged = 1e-4;     ///< change of the mean, from one sweep to the next
constexpr double min_variance = 1e-9;  ///< relative to the variance before: nothing divides by zero

void add(std::deque<VectorXd>& points, const VectorXd& x, std::size_t max_count) {
    if (!points.empty() && points.back() == x) return;
    points.push_back(x);
    if (points.size() > max_count) points.pop_front();
}

/// phi(z) / Phi(z) of the standard normal distribution.
double hazard(double z) {
    if (z < -30) return -z - 1 / z + 2 / (z * z * z);
    return std::exp(-0.5 * z * z) / (std::sqrt(2 * M_PI) * 0.5 * std::erfc(-z / M_SQRT2));
}

/// The standard normal distribution of w, given that a.w + noise > 0 for every column a of `sides`, as the normal
/// distribution that expectation propagation finds. False: it diverged.
bool cut_to_sides(const MatrixXd& sides, const VectorXd& noise, VectorXd& mean, MatrixXd& covariance) {
    const Eigen::Index n = sides.rows(), count = sides.cols();
    VectorXd precision = VectorXd::Zero(count), shift = VectorXd::Zero(count);
    mean = VectorXd::Zero(n);
    covariance = MatrixXd::Identity(n, n);
    for (int sweep = 0; sweep < max_sweeps; ++sweep) {
        const VectorXd before = mean;
        for (Eigen::Index i = 0; i < count; ++i) {
            const VectorXd v = covariance * sides.col(i);
            const double variance = sides.col(i).dot(v), at = sides.col(i).dot(mean);
            const double rest = 1 / variance - precision[i];  // precision by the others
            if (!(variance > 0) || !(rest > 0)) continue;
            const double centre = (at / variance - shift[i]) / rest, all = 1 + noise[i] * noise[i] * rest;
            const double z = centre * std::sqrt(rest / all), r = hazard(z);
            const double cut_mean = centre + r / std::sqrt(rest * all);
            const double cut_variance = std::max(1 - r * (z + r) / all, min_variance) / rest;
            const double more = std::max(1 / cut_variance - rest, 0.0) - precision[i];
            const double shift_more = cut_mean / cut_variance - centre * rest - shift[i];
            precision[i] += more;
            shift[i] += shift_more;
            mean += (shift_more - more * at) / (1 + more * variance) * v;
            covariance -= more / (1 + more * variance) * v * v.transpose();
        }
        const MatrixXd all = MatrixXd::Identity(n, n) + sides * precision.asDiagonal() * sides.transpose();
        covariance = all.llt().solve(MatrixXd::Identity(n, n));
        mean = covariance * (sides * shift);
        if (!mean.allFinite()) return false;
        if ((mean - before).norm() <= converged * mean.norm()) break;
    }
    return true;
}

}  // namespace

VectorXd FailureClassifier::coordinates(const VectorXd& x) const {
    VectorXd z(x.size() + 1);
    z << U * (x - origin) / unit, 1;
    return z;
}

double FailureClassifier::z_score(const VectorXd& x) const {
    const VectorXd z = coordinates(x);
    return -mean.dot(z) / std::sqrt(z.dot(covariance * z));
}

FailureCut FailureClassifier::cut(const VectorXd& x, double z_score) const {
    const VectorXd z = coordinates(x), v = covariance * z;
    const VectorXd w = mean + z_score / std::sqrt(z.dot(v)) * v;
    const Eigen::Index n = x.size();
    const double length = std::max(w.head(n).norm(), std::numeric_limits<double>::min());
    FailureCut cut;
    cut.normal = U.transpose() * w.head(n) / length;
    cut.limit = cut.normal.dot(origin) - w[n] * unit / length;
    return cut;
}

void FailureBorder::add_sound(const VectorXd& x) { add(sound_, x, max_sound); }
void FailureBorder::add_failed(const VectorXd& x) { add(failed_, x, max_failed); }

std::optional<FailureClassifier> FailureBorder::classifier(const VectorXd& x, const MatrixXd& metric) const {
    if (failed_.size() < min_failed) return {};
    FailureClassifier b;
    b.origin = x;
    b.U = metric.llt().matrixU();
    b.unit = std::numeric_limits<double>::infinity();
    for (const VectorXd& f : failed_) b.unit = std::min(b.unit, (b.U * (f - x)).norm());
    if (!(b.unit > 0)) return {};
    const auto first = static_cast<Eigen::Index>(sound_.size()) + 1;
    MatrixXd sides(x.size() + 1, first + static_cast<Eigen::Index>(failed_.size()));
    VectorXd noise(sides.cols());
    const auto set = [&](Eigen::Index i, const VectorXd& point, double sign) {
        const VectorXd z = b.coordinates(point);
        sides.col(i) = sign * z.normalized();
        noise[i] = curving * b.unit * z.head(x.size()).norm();
    };
    Eigen::Index count = 0;
    set(count++, x, -1);
    for (const VectorXd& s : sound_) set(count++, s, -1);
    for (const VectorXd& f : failed_) set(count++, f, 1);
    for (; count > first; --count) {
        if (!cut_to_sides(sides.leftCols(count), noise.head(count), b.mean, b.covariance)) return {};
        const VectorXd off = sides.leftCols(count).transpose() * b.mean + max_misfit * noise.head(count);
        if (off.minCoeff() > 0) return b;
        Eigen::Index worst = 0;
        off.tail(count - first).minCoeff(&worst);
        sides.col(first + worst) = sides.col(count - 1);
        noise[first + worst] = noise[count - 1];
    }
    return {};
}

}  // namespace strake
