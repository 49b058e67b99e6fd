#include "optimize/first_order.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>

namespace strake {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double nearly_active = 1e-2;
constexpr double at_bound = 1e-9;  ///< of the range: rounding must not decide

/// L^-1 b with metric = L L^T.
MatrixXd whitened(const NonlinearProgram& p, const MatrixXd& b) {
    return p.metric.size() == 0 ? b : MatrixXd(Eigen::LLT<MatrixXd>(p.metric).matrixL().solve(b));
}

}  // namespace

MatrixXd metric_of(const NonlinearProgram& p) {
    return p.metric.size() > 0 ? p.metric : MatrixXd(MatrixXd::Identity(p.start.size(), p.start.size()));
}

VectorXd multipliers(const NonlinearProgram& p, const Sample& sample) {
    const Eigen::Index rows = sample.constraints.size();
    VectorXd result = VectorXd::Zero(rows);
    std::vector<Eigen::Index> active;
    for (Eigen::Index i = 0; i < rows; ++i)
        if (i >= p.num_inequalities || sample.constraints[i] > -nearly_active) active.push_back(i);
    if (active.empty()) return result;
    const VectorXd g = whitened(p, sample.gradient);
    const MatrixXd normals = whitened(p, sample.jacobian.transpose());
    for (int pass = 0; pass < 2 && !active.empty(); ++pass) {
        const VectorXd found = MatrixXd(normals(Eigen::all, active)).colPivHouseholderQr().solve(-g);
        std::vector<Eigen::Index> kept;
        result.setZero();
        for (std::size_t i = 0; i < active.size(); ++i)
            if (active[i] >= p.num_inequalities || found[static_cast<Eigen::Index>(i)] > 0) {
                kept.push_back(active[i]);
                result[active[i]] = found[static_cast<Eigen::Index>(i)];
            }
        if (kept.size() == active.size()) break;
        active = kept;
    }
    return result;
}

bool leaves_bounds(const NonlinearProgram& p, const VectorXd& x, Eigen::Index j, double direction) {
    const double range = p.upper[j] - p.lower[j], hair = std::isfinite(range) ? at_bound * range : 0;
    return (x[j] <= p.lower[j] + hair && direction < 0) || (x[j] >= p.upper[j] - hair && direction > 0);
}

VectorXd descent_direction(const NonlinearProgram& p, const VectorXd& x, const Sample& sample) {
    const VectorXd lagrangian = sample.gradient + sample.jacobian.transpose() * multipliers(p, sample);
    VectorXd direction = p.metric.size() == 0 ? -lagrangian : VectorXd(-p.metric.llt().solve(lagrangian));
    for (Eigen::Index j = 0; j < direction.size(); ++j)
        if (leaves_bounds(p, x, j, direction[j])) direction[j] = 0;
    return direction;
}

double metric_norm(const NonlinearProgram& p, const VectorXd& d) {
    return p.metric.size() == 0 ? d.norm() : std::sqrt(std::max(0.0, d.dot(p.metric * d)));
}

double dual_norm(const NonlinearProgram& p, const VectorXd& g) { return whitened(p, g).norm(); }

double total_violation(const NonlinearProgram& p, const VectorXd& c) {
    double sum = 0;
    for (Eigen::Index i = 0; i < c.size(); ++i) sum += i < p.num_inequalities ? std::max(0.0, c[i]) : std::abs(c[i]);
    return sum;
}

double largest_violation(const NonlinearProgram& p, const VectorXd& c) {
    double worst = 0;
    for (Eigen::Index i = 0; i < c.size(); ++i) worst = std::max(worst, i < p.num_inequalities ? c[i] : std::abs(c[i]));
    return worst;
}

}  // namespace strake
