#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "optimize/least_squares/least_squares_watch.hpp"

namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double accepted = 1e-3;          ///< share of the predicted decrease that a step must make
constexpr double min_radius = 1e-32;       ///< the damping is then all there is
constexpr int max_failures_in_a_row = 10;  ///< trials without residuals
constexpr int max_halvings = 3;            ///< along a step that was projected onto the bounds

struct Point {
    VectorXd x, r, gradient;  ///< gradient of |r|^2 / 2
    MatrixXd normal;          ///< J^T J
    double cost = 0;          ///< |r|^2 / 2
};

class Search {
public:
    Search(LeastSquaresWatch& watch, double& radius)
        : watch_(watch), options_(watch.options), radius_(radius), m_(watch.problem.num_residuals) {}

    LeastSquaresEnd run() {
        at_.x = watch_.problem.start;
        if (!linearize() || !watch_.go_on(0)) return LeastSquaresEnd::other;
        for (int iteration = 1; iteration <= options_.max_iterations; ++iteration) {
            if (at_.cost == 0) return LeastSquaresEnd::converged;
            if (radius_ < min_radius) return LeastSquaresEnd::converged;
            const Outcome outcome = try_step();
            if (outcome == Outcome::converged) return LeastSquaresEnd::converged;
            if (outcome == Outcome::broken || !watch_.go_on(iteration)) return LeastSquaresEnd::other;
        }
        return LeastSquaresEnd::limit;
    }

private:
    enum class Outcome { taken, refused, converged, broken };

    LeastSquaresWatch& watch_;
    const LeastSquaresOptions& options_;
    double& radius_;
    int m_;
    Point at_;
    VectorXd scale_;  ///< 1 / norm of each column at the start
    double shrink_ = 2;
    int failures_ = 0;

    /// Residuals and their derivatives at at_.x.
    bool linearize() {
        at_.r.resize(m_);
        RowMajorMatrix J(m_, at_.x.size());
        if (!watch_.evaluate(at_.x.data(), at_.r.data(), J.data())) return false;
        at_.cost = at_.r.squaredNorm() / 2;
        if (scale_.size() == 0) scale_ = (1 + J.colwise().norm().array()).inverse().matrix().transpose();
        at_.gradient = J.transpose() * at_.r;
        at_.normal = J.transpose() * J;
        return at_.normal.allFinite() && at_.gradient.allFinite();
    }
    /// The damped step in x; variables at a bound that the step would leave by stay there.
    VectorXd step() const {
        const Eigen::Index n = at_.x.size();
        MatrixXd H = scale_.asDiagonal() * at_.normal * scale_.asDiagonal();
        VectorXd g = scale_.cwiseProduct(at_.gradient);
        std::vector<char> stays(n, 0);
        for (Eigen::Index j = 0; j < n; ++j)
            stays[j] =
                (at_.x[j] <= watch_.problem.lower[j] && g[j] > 0) || (at_.x[j] >= watch_.problem.upper[j] && g[j] < 0);
        for (Eigen::Index j = 0; j < n; ++j) {
            H(j, j) += std::clamp(H(j, j), 1e-6, 1e32) / radius_;
            if (!stays[j]) continue;
            H.row(j).setZero();
            H.col(j).setZero();
            H(j, j) = 1;
            g[j] = 0;
        }
        return scale_.cwiseProduct(H.ldlt().solve(-g));
    }
    VectorXd inside(const VectorXd& x) const { return x.cwiseMax(watch_.problem.lower).cwiseMin(watch_.problem.upper); }
    double predicted(const VectorXd& d) const { return -at_.gradient.dot(d) - d.dot(at_.normal * d) / 2; }

    void refuse() {
        radius_ /= shrink_;
        shrink_ *= 2;
    }
    /// Residuals alone at x; infinity where there are none.
    double cost(const VectorXd& x) {
        VectorXd r(m_);
        const bool ok = watch_.evaluate(x.data(), r.data(), nullptr);
        failures_ = ok ? 0 : failures_ + 1;
        return ok ? r.squaredNorm() / 2 : std::numeric_limits<double>::infinity();
    }
    Outcome try_step() {
        const VectorXd whole = step();
        if (!whole.allFinite()) return refuse(), Outcome::refused;
        VectorXd x = inside(at_.x + whole);
        const bool projected = x != at_.x + whole;
        double expected = predicted(x - at_.x), there = 0;
        for (int halving = 0;; ++halving) {
            if ((x - at_.x).norm() <= options_.step_tolerance * (at_.x.norm() + options_.step_tolerance))
                return Outcome::converged;
            if (expected > 0) {
                there = cost(x);
                if (watch_.exception) return Outcome::broken;
                if (at_.cost - there > accepted * expected || !projected) break;
            }
            if (!projected || halving == max_halvings) break;
            x = inside(at_.x + std::pow(0.5, halving + 1) * whole);
            expected = predicted(x - at_.x);
        }
        if (!(expected > 0) || !(at_.cost - there > accepted * expected)) {
            if (failures_ >= max_failures_in_a_row) return Outcome::broken;
            return refuse(), Outcome::refused;
        }
        const double before = at_.cost, share = (before - there) / expected;
        at_.x = x;
        if (!linearize()) return Outcome::broken;
        radius_ = std::min(1e16, radius_ / std::max(1.0 / 3, 1 - std::pow(2 * share - 1, 3)));
        shrink_ = 2;
        return before - there <= options_.objective_tolerance * before ? Outcome::converged : Outcome::taken;
    }
};

}  // namespace

LeastSquaresEnd levenberg_marquardt(LeastSquaresWatch& watch, double& radius) { return Search(watch, radius).run(); }

}  // namespace strake
