#include "optimize/border_probes.hpp"

#include "optimize/first_order.hpp"

#include <Eigen/Cholesky>
#include <random>

namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Takes what `v` has of the columns of `basis` (orthonormal) out of it; false: next to nothing is left.
bool orthogonalize(VectorXd& v, const std::vector<VectorXd>& basis) {
    const double length = v.norm();
    for (int round = 0; round < 2; ++round)
        for (const VectorXd& b : basis) v -= b.dot(v) * b;
    if (!(v.norm() > 1e-6 * length) || !(length > 0)) return false;
    v.normalize();
    return true;
}

}  // namespace

std::vector<VectorXd> border_probes(const NonlinearProgram& p, const VectorXd& x, const Sample& sample,
                                    const MatrixXd& hessian, double gain, int pairs) {
    const Eigen::Index n = x.size();
    const Eigen::LLT<MatrixXd> llt(metric_of(p));
    const VectorXd lambda = multipliers(p, sample);
    VectorXd g = sample.gradient;
    if (lambda.size() > 0) g += sample.jacobian.transpose() * lambda;
    std::vector<VectorXd> taken;  // in coordinates in which the metric is the identity
    const auto take = [&](const VectorXd& slope) {
        VectorXd v = llt.matrixL().solve(slope);
        if (orthogonalize(v, taken)) taken.push_back(v);
    };
    for (Eigen::Index j = 0; j < n; ++j)
        if (!(p.lower[j] < p.upper[j]) || x[j] <= p.lower[j] || x[j] >= p.upper[j])
            take(VectorXd::Unit(n, j)), g[j] = 0;
    for (Eigen::Index i = 0; i < lambda.size(); ++i)
        if (i >= p.num_inequalities || lambda[i] > 0) take(sample.jacobian.row(i).transpose());
    const VectorXd down = -llt.solve(g);
    const double slope = -g.dot(down);  // per unit of `down`
    if (!(slope > 0) || !(gain > 0)) return {};
    take(g);
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    std::vector<VectorXd> steps;
    for (int k = 0; k < pairs && static_cast<Eigen::Index>(taken.size()) < n; ++k) {
        VectorXd v = VectorXd::NullaryExpr(n, [&] { return normal(random); });
        if (!orthogonalize(v, taken)) break;
        taken.push_back(v);
        const VectorXd along = llt.matrixU().solve(v);
        const double curvature = along.dot(hessian * along);
        if (!(curvature > 0)) continue;
        const double length = std::sqrt(2 * gain / curvature);  // then the curvature costs `gain`, and the tilt gains 2
        for (const double sign : {1.0, -1.0}) {
            const VectorXd d = sign * length * along + 2 * gain / slope * down;
            steps.push_back((x + d).cwiseMax(p.lower).cwiseMin(p.upper) - x);
        }
    }
    return steps;
}

}  // namespace strake
