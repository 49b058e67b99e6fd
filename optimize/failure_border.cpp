#include "optimize/failure_border.hpp"

#include "optimize/quadratic_model.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::size_t most_sound = 120, most_failed = 60;
constexpr std::size_t least_failed = 2;  ///< one may have been bad luck
constexpr double most_caution = 1e3;
constexpr double offset_weight = 1e-4;  ///< of the plane's offset beside its normal: as good as free

void add(std::deque<VectorXd>& points, const VectorXd& x, std::size_t most) {
    if (!points.empty() && points.back() == x) return;
    points.push_back(x);
    if (points.size() > most) points.pop_front();
}

/// Points as columns, in coordinates in which the metric is the identity, relative to x.
MatrixXd columns(const std::vector<const VectorXd*>& points, const VectorXd& x, const MatrixXd& U) {
    MatrixXd all(x.size(), static_cast<Eigen::Index>(points.size()));
    for (std::size_t i = 0; i < points.size(); ++i) all.col(static_cast<Eigen::Index>(i)) = U * (*points[i] - x);
    return all;
}

struct Plane {
    VectorXd normal;  ///< length 1; empty: no plane parts them
    double limit = 0;
};

/// The plane of the widest margin; margins count relative to the distance from the origin, which is sound, so that far
/// points say about the direction of the plane what near ones say about its place.
Plane widest_margin(const MatrixXd& sound, const MatrixXd& failed, double caution) {
    const Eigen::Index n = sound.rows(), first = sound.cols(), count = first + failed.cols();
    const double gap = failed.colwise().norm().minCoeff();
    if (!(gap > 0)) return {};
    // min |v|^2 + weight c^2 over v.s + c <= -distance, v.f + c >= distance in units of the gap.
    QuadraticModel m;
    m.gradient = VectorXd::Zero(n + 1);
    m.hessian = MatrixXd::Identity(n + 1, n + 1);
    m.hessian(n, n) = offset_weight;
    m.lower = VectorXd::Constant(n + 1, -1e6);
    m.upper = -m.lower;
    m.constraints = VectorXd::Ones(count);
    m.jacobian.resize(count, n + 1);
    m.jacobian.topLeftCorner(first, n) = sound.transpose() / gap;
    m.jacobian.bottomLeftCorner(failed.cols(), n) = -failed.transpose() / gap;
    m.jacobian.col(n).head(first).setOnes();
    m.jacobian.col(n).tail(failed.cols()).setConstant(-1);
    for (Eigen::Index i = 0; i < count; ++i) {
        const double distance = (i < first ? sound.col(i) : failed.col(i - first)).norm();
        m.jacobian.row(i) /= std::max(distance / gap, 1.0);
    }
    m.constraints.head(first) *= std::min(1.0, 1 / caution);
    m.constraints.tail(failed.cols()) *= std::min(1.0, caution);
    m.num_inequalities = static_cast<int>(count);
    const VectorXd v = solve_model(m);
    if (v.size() == 0 || !(v.head(n).norm() > 0)) return {};
    Plane plane{v.head(n).normalized(), -gap * v[n] / v.head(n).norm()};
    const bool parts = (plane.normal.transpose() * sound).maxCoeff() < plane.limit &&
                       plane.limit < (plane.normal.transpose() * failed).minCoeff();
    return parts ? plane : Plane{};
}

}  // namespace

void FailureBorder::add_sound(const VectorXd& x) { add(sound_, x, most_sound); }
void FailureBorder::add_failed(const VectorXd& x) { add(failed_, x, most_failed); }

std::optional<FailureCut> FailureBorder::cut(const VectorXd& x, const MatrixXd& metric, double caution) const {
    if (failed_.size() < least_failed) return {};
    const MatrixXd U = metric.llt().matrixU();
    std::vector<const VectorXd*> sound{&x}, failed;
    for (const VectorXd& s : sound_) sound.push_back(&s);
    for (const VectorXd& f : failed_) failed.push_back(&f);
    std::stable_sort(failed.begin(), failed.end(), [&](const VectorXd* a, const VectorXd* b) {
        return (U * (*a - x)).squaredNorm() < (U * (*b - x)).squaredNorm();
    });
    const MatrixXd inside = columns(sound, x, U);
    for (; !failed.empty(); failed.resize(failed.size() / 2)) {
        const MatrixXd outside = columns(failed, x, U);
        const Plane plane = widest_margin(inside, outside, caution);
        if (plane.normal.size() == 0) continue;
        FailureCut cut;
        cut.normal = U.transpose() * plane.normal;
        cut.limit = cut.normal.dot(x) + plane.limit;
        return cut;
    }
    return {};
}

void BorderWatch::look(const VectorXd& x, const MatrixXd& metric) {
    const double caution = failed_ > 0 ? std::pow(3.0, failed_ - 1) : std::pow(2.0, 1 - moved_);
    cut_ = border_.cut(x, metric, std::clamp(caution, 1 / most_caution, most_caution));
}

void BorderWatch::has_moved(const VectorXd& x, const MatrixXd& metric) {
    ++moved_;
    failed_ = 0;
    look(x, metric);
}

void BorderWatch::has_failed(const VectorXd& x, const MatrixXd& metric) {
    ++failed_;
    moved_ = 0;
    look(x, metric);
}

std::optional<FailureCut> BorderWatch::furthest(const VectorXd& x, const MatrixXd& metric) const {
    return border_.cut(x, metric, 1 / most_caution);
}

}  // namespace strake
