#include "bench/coarse_to_fine/cma_es.hpp"

#include "optimize/nlp/program/first_order.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

namespace strake::evidence {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// By violation first, then by the objective.
struct Rank {
    double violation = std::numeric_limits<double>::infinity(), objective = violation;
    auto operator<=>(const Rank&) const = default;
};

Rank rank_of(const NonlinearProgram& p, const VectorXd& y) {
    constexpr double feasible = 1e-6;
    const Evaluation at = p.evaluate(y);
    if (!at.failure.empty() || !std::isfinite(at.objective)) return {};
    const double violation = total_violation(p, at.constraints);
    return {violation <= feasible ? 0 : violation, at.objective};
}

}  // namespace

void minimize_by_cma_es(const NonlinearProgram& p, int evaluations, unsigned seed, double step) {
    const auto n = static_cast<int>(p.start.size());
    const Eigen::LLT<MatrixXd> metric(metric_of(p));
    const int lambda = 4 + static_cast<int>(3 * std::log(n)), mu = lambda / 2;
    VectorXd weight(mu);
    for (int i = 0; i < mu; ++i) weight[i] = std::log(0.5 * (lambda + 1)) - std::log(i + 1);
    weight /= weight.sum();
    const double mu_eff = 1 / weight.squaredNorm();
    const double c_sigma = (mu_eff + 2) / (n + mu_eff + 5);
    const double damping = 1 + 2 * std::max(0.0, std::sqrt((mu_eff - 1) / (n + 1)) - 1) + c_sigma;
    const double c_c = (4 + mu_eff / n) / (n + 4 + 2 * mu_eff / n);
    const double c_1 = 2 / (std::pow(n + 1.3, 2) + mu_eff);
    const double c_mu = std::min(1 - c_1, 2 * (mu_eff - 2 + 1 / mu_eff) / (std::pow(n + 2, 2) + mu_eff));
    const double usual = std::sqrt(n) * (1 - 1.0 / (4 * n) + 1.0 / (21.0 * n * n));

    VectorXd mean = VectorXd::Zero(n), p_sigma = mean, p_c = mean;  // whitened, from the start
    MatrixXd C = MatrixXd::Identity(n, n);
    std::mt19937_64 engine(seed);
    std::normal_distribution<double> normal;
    p.evaluate(p.start);
    for (int spent = 1, round = 1; spent + lambda <= evaluations; spent += lambda, ++round) {
        const Eigen::SelfAdjointEigenSolver<MatrixXd> of(C);
        const VectorXd root = of.eigenvalues().cwiseMax(0).cwiseSqrt();
        MatrixXd steps(n, lambda);
        std::vector<Rank> ranks;
        for (int k = 0; k < lambda; ++k) {
            VectorXd z(n);
            for (double& entry : z) entry = normal(engine);
            const VectorXd wanted = mean + step * (of.eigenvectors() * root.cwiseProduct(z));
            const VectorXd y = (p.start + metric.matrixU().solve(wanted)).cwiseMax(p.lower).cwiseMin(p.upper);
            steps.col(k) = (metric.matrixU() * (y - p.start) - mean) / step;
            ranks.push_back(rank_of(p, y));
        }
        std::vector<int> order(static_cast<std::size_t>(lambda));
        std::iota(order.begin(), order.end(), 0);
        std::ranges::stable_sort(order, {}, [&](int k) { return ranks[static_cast<std::size_t>(k)]; });
        VectorXd move = VectorXd::Zero(n);
        MatrixXd spread = MatrixXd::Zero(n, n);
        for (int i = 0; i < mu; ++i) {
            const VectorXd d = steps.col(order[static_cast<std::size_t>(i)]);
            move += weight[i] * d;
            spread += weight[i] * d * d.transpose();
        }
        mean += step * move;
        const VectorXd inverse_root = root.cwiseMax(1e-12).cwiseInverse();
        p_sigma = (1 - c_sigma) * p_sigma +
                  std::sqrt(c_sigma * (2 - c_sigma) * mu_eff) *
                      (of.eigenvectors() * inverse_root.asDiagonal() * of.eigenvectors().transpose() * move);
        const double length = p_sigma.norm() / std::sqrt(1 - std::pow(1 - c_sigma, 2 * round));
        const bool is_short = length < (1.4 + 2.0 / (n + 1)) * usual;
        p_c = (1 - c_c) * p_c + is_short * std::sqrt(c_c * (2 - c_c) * mu_eff) * move;
        const double held = is_short ? 0 : c_c * (2 - c_c);
        C = (1 - c_1 - c_mu + c_1 * held) * C + c_1 * p_c * p_c.transpose() + c_mu * spread;
        step *= std::exp(c_sigma / damping * (p_sigma.norm() / usual - 1));
    }
}

}  // namespace strake::evidence
