#include "optimize/first_order.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>

namespace strake {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double nearly_active = 0.02;  ///< in the metric: steps of 1 are the largest reasonable ones
constexpr int bound_passes = 5;         ///< in search of the bounds that hold their variables
constexpr double at_bound = 1e-9;       ///< of the range: rounding must not decide

/// L^-1 b with metric = L L^T.
MatrixXd whitened(const NonlinearProgram& p, const MatrixXd& b) {
    return p.metric.size() == 0 ? b : MatrixXd(Eigen::LLT<MatrixXd>(p.metric).matrixL().solve(b));
}

}  // namespace

MatrixXd metric_of(const NonlinearProgram& p) {
    return p.metric.size() > 0 ? p.metric : MatrixXd(MatrixXd::Identity(p.start.size(), p.start.size()));
}

VectorXd values_of(const Sample& s) {
    VectorXd all(1 + s.constraints.size());
    all << s.objective, s.constraints;
    return all;
}

VectorXd least_squares_multipliers(const MatrixXd& metric, const VectorXd& gradient, const MatrixXd& jacobian,
                                   int num_inequalities, const ActiveSet& set) {
    VectorXd result = VectorXd::Zero(jacobian.rows());
    std::vector<Eigen::Index> active = set.rows;
    if (active.empty() || set.variables.empty()) return result;
    const Eigen::LLT<MatrixXd> llt(MatrixXd(metric(set.variables, set.variables)));
    const VectorXd g = llt.matrixL().solve(gradient(set.variables));
    const MatrixXd normals = llt.matrixL().solve(jacobian(Eigen::all, set.variables).transpose());
    for (int pass = 0; pass < 2 && !active.empty(); ++pass) {
        const VectorXd found = MatrixXd(normals(Eigen::all, active)).colPivHouseholderQr().solve(-g);
        std::vector<Eigen::Index> kept;
        result.setZero();
        for (std::size_t i = 0; i < active.size(); ++i)
            if (active[i] >= num_inequalities || found[static_cast<Eigen::Index>(i)] > 0) {
                kept.push_back(active[i]);
                result[active[i]] = found[static_cast<Eigen::Index>(i)];
            }
        if (kept.size() == active.size()) break;
        active = kept;
    }
    return result;
}

VectorXd multipliers(const NonlinearProgram& p, const VectorXd& x, const Sample& sample) {
    if (sample.constraints.size() == 0) return {};
    const MatrixXd metric = metric_of(p), normals = whitened(p, sample.jacobian.transpose());
    ActiveSet set;
    for (Eigen::Index i = 0; i < sample.constraints.size(); ++i)
        if (i >= p.num_inequalities || sample.constraints[i] >= -nearly_active * normals.col(i).norm())
            set.rows.push_back(i);
    VectorXd result, slope = VectorXd::Zero(x.size());
    for (int pass = 0; pass < bound_passes; ++pass) {
        std::vector<Eigen::Index> moving;
        for (Eigen::Index j = 0; j < x.size(); ++j)
            if (p.lower[j] < p.upper[j] && !leaves_bounds(p, x, j, -slope[j])) moving.push_back(j);
        if (pass > 0 && moving == set.variables) break;
        set.variables = moving;
        result = least_squares_multipliers(metric, sample.gradient, sample.jacobian, p.num_inequalities, set);
        slope = sample.gradient + sample.jacobian.transpose() * result;
    }
    return result;
}

bool leaves_bounds(const NonlinearProgram& p, const VectorXd& x, Eigen::Index j, double direction) {
    const double range = p.upper[j] - p.lower[j], hair = std::isfinite(range) ? at_bound * range : 0;
    return (x[j] <= p.lower[j] + hair && direction < 0) || (x[j] >= p.upper[j] - hair && direction > 0);
}

VectorXd descent_direction(const NonlinearProgram& p, const VectorXd& x, const Sample& sample) {
    const VectorXd lagrangian = sample.gradient + sample.jacobian.transpose() * multipliers(p, x, sample);
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
