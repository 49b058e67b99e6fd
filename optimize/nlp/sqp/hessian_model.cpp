#include "optimize/nlp/sqp/hessian_model.hpp"

#include "optimize/nlp/sqp/trust_region.hpp"

#include <algorithm>

namespace strake {

using Eigen::MatrixXd;
using Eigen::VectorXd;

HessianModel::HessianModel(const SqpIterate& now, double min_curvature) : now_(now), min_curvature_(min_curvature) {
    const Eigen::Index rows = now.at.constraints.size();
    curvature_ = VectorXd::Constant(rows, std::numeric_limits<double>::infinity());
    included_ = VectorXd::Zero(rows);
}

void HessianModel::start() {
    const NonlinearProgram& p = now_.program;
    const double slope = std::max(dual_norm(p, lagrangian_gradient(now_)),
                                  trust_region.min_slope_share * dual_norm(p, now_.at.gradient));
    B_ = std::max(slope > 0 ? slope / now_.guard.options.first_step : 1.0, min_curvature_) * p.metric;
    holds_guess_ = false;
}

void HessianModel::start_from(const MatrixXd& known) {
    B_ = known;
    holds_guess_ = true;
}

void HessianModel::update(const VectorXd& s, const VectorXd& y) {
    const VectorXd Bs = B_ * s;
    const double sBs = s.dot(Bs), sy = s.dot(y);
    if (!(sBs > 0)) return;
    constexpr double share = trust_region.min_curvature_share;
    double theta = sy >= share * sBs ? 1.0 : (1 - share) * sBs / (sBs - sy);
    VectorXd r = theta * y + (1 - theta) * Bs;
    // Along negative curvature s.r is small however long y is: what is added would outgrow the rest until B is
    // singular to rounding. It may be as large as what it replaces, or as the mean curvature.
    const double largest = std::max(Bs.squaredNorm() / sBs, B_.trace() / static_cast<double>(s.size()));
    for (int i = 0; i < trust_region.max_damped_cuts && theta < 1 && r.squaredNorm() > largest * s.dot(r); ++i) {
        theta *= 0.5;
        r = theta * y + (1 - theta) * Bs;
    }
    B_ += r * r.transpose() / s.dot(r) - Bs * Bs.transpose() / sBs;
    B_ = 0.5 * (B_ + B_.transpose()).eval();
}

void HessianModel::measure_constraints(const Evaluation& trial, const VectorXd& d) {
    const double length2 = d.dot(now_.program.metric * d);
    const VectorXd change = trial.constraints - now_.at.constraints - now_.at.jacobian * d;
    const double rounding = trust_region.constraint_rounding * now_.tolerance();
    for (Eigen::Index i = 0; i < change.size(); ++i) {
        if (std::abs(change[i]) > rounding && length2 > 0)
            curvature_[i] = std::min(curvature_[i], std::max(2 * change[i] / length2, 0.0));
    }
}

void HessianModel::add_constraint_curvature(const VectorXd& multipliers) {
    for (Eigen::Index i = 0; i < multipliers.size(); ++i) {
        const double needed = std::isfinite(curvature_[i]) ? multipliers[i] * curvature_[i] : 0;
        if (!(needed > included_[i])) continue;
        B_ += (needed - included_[i]) * now_.program.metric;
        included_[i] = needed;
    }
}

void HessianModel::add_rejected_curvature(const Evaluation& trial, const VectorXd& d, const VectorXd& multipliers,
                                          double radius) {
    const Evaluation& at = now_.at;
    const VectorXd Md = now_.program.metric * d;
    const VectorXd slope = at.gradient + at.jacobian.transpose() * multipliers;
    const double rise =
        trial.objective - at.objective + multipliers.dot(trial.constraints - at.constraints) - slope.dot(d);
    const double length2 = d.dot(Md), known = d.dot(B_ * d);
    const double largest = std::abs(slope.dot(d)) * std::sqrt(length2) / radius;
    const double excess = std::min(2 * rise, largest) - known;
    const double rounding =
        now_.guard.options.is_relative_to_objective
            ? trust_region.rounding_share * now_.guard.options.objective_tolerance * std::abs(at.objective)
            : std::max(trust_region.rounding_share * now_.guard.decrease_tolerance(at.objective),
                       resolution(at.objective, now_.guard.evidence.noise()));
    if (excess > rounding && length2 > 0) B_ += excess / (length2 * length2) * Md * Md.transpose();
}

void HessianModel::remove_guess(double share) {
    if (holds_guess_ && now_.program.guessed.size() > 0) B_ -= share * now_.program.guessed;
}

VectorXd lagrangian_gradient(const SqpIterate& now) { return lagrangian_gradient(now.program, now.x, now.at); }

}  // namespace strake
