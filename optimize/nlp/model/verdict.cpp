#include "optimize/nlp/model/verdict.hpp"

#include "core/error.hpp"
#include "optimize/nlp/program/first_order.hpp"

namespace strake {

using Eigen::VectorXd;

namespace {

constexpr double probe = 1e-3;          ///< in the metric
constexpr double max_difference = 0.2;  ///< of the slope

bool at_bound(const NonlinearProgram& p, const VectorXd& x, Eigen::Index j, bool upper) {
    const double range = p.upper[j] - p.lower[j];
    const double slack = 1e-7 * (std::isfinite(range) ? range : 1.0);
    return upper ? x[j] >= p.upper[j] - slack : x[j] <= p.lower[j] + slack;
}

/// @pre the best point has gradients.
VectorXd lagrangian_gradient(const Guard& guard) {
    return strake::lagrangian_gradient(guard.program, guard.best_x, guard.best);
}

/// A slope by extrapolation from a step and half of it. False: they do not agree, or rounding hides it.
bool slope_of(double here, double half, double full, double by_gradient, double& slope) {
    const double by_full = full - here, by_half = 2 * (half - here);
    slope = 2 * by_half - by_full;
    const double noise = 1e-11 * std::max({std::abs(here), std::abs(full), std::numeric_limits<double>::min()});
    return std::abs(by_gradient) > noise &&
           std::abs(by_full - by_half) < 0.1 * std::max(std::abs(by_gradient), std::abs(slope));
}

/// A step of length `probe` at most; empty: there is none.
VectorXd probing_step(const Guard& guard, const VectorXd& x, const Evaluation& at) {
    const NonlinearProgram& p = guard.program;
    VectorXd d = descent_direction(p, x, at);
    if (!guard.best_feasible) {
        d.setZero();
        for (Eigen::Index i = 0; i < at.constraints.size(); ++i) {
            const bool equality = i >= p.num_inequalities;
            if ((equality ? std::abs(at.constraints[i]) : at.constraints[i]) > guard.options.constraint_tolerance)
                d -= (at.constraints[i] > 0 ? 1.0 : -1.0) * at.jacobian.row(i).transpose();
        }
        // Into the bounds: variables at one can go nowhere else.
        for (Eigen::Index j = 0; j < d.size(); ++j)
            if (at_bound(p, x, j, d[j] > 0)) d[j] = -d[j];
    } else if (!(metric_norm(p, d) > 0))
        d = -at.gradient;
    d *= probe / std::max(metric_norm(p, d), std::numeric_limits<double>::min());
    d = (x + d).cwiseMax(p.lower).cwiseMin(p.upper) - x;
    return d.allFinite() && metric_norm(p, d) > 0.01 * probe ? d : VectorXd();
}

}  // namespace

bool expects_more(const Guard& guard) {
    if (guard.best.gradient.size() == 0) return false;
    const NonlinearProgram& p = guard.program;
    VectorXd d = -lagrangian_gradient(guard);
    for (Eigen::Index j = 0; j < d.size(); ++j)
        if (p.lower[j] == p.upper[j] || at_bound(p, guard.best_x, j, d[j] > 0)) d[j] = 0;
    const double length = metric_norm(p, d);
    return length > 0 &&
           d.squaredNorm() / length * probe > 10 * guard.options.objective_tolerance * std::abs(guard.best.objective);
}

void check_slopes(Guard& guard, MinimizeResult& result) {
    if (guard.evaluations + 3 > guard.limit || guard.cause != StopCause::none || !guard.has_best) return;
    const VectorXd x = guard.best_x;
    Evaluation at, half, full;
    if (!guard.try_at(x, true, at)) return;
    const VectorXd d = probing_step(guard, x, at);
    if (d.size() == 0) return;
    // Where a limit lets nothing go there, the values say nothing of the gradient.
    const auto is_moved = [&](const VectorXd& to) { return guard.inside(to) != to; };
    if (is_moved((x + 0.5 * d).cwiseMax(guard.program.lower).cwiseMin(guard.program.upper)) ||
        is_moved((x + d).cwiseMax(guard.program.lower).cwiseMin(guard.program.upper)))
        return;
    if (!guard.try_at(x + 0.5 * d, false, half) || !guard.try_at(x + d, false, full)) {
        if (guard.cause == StopCause::failure) guard.cause = StopCause::none;
        return;
    }
    const VectorXd v0 = values_of(at), v1 = values_of(half), v2 = values_of(full);
    for (Eigen::Index i = 0; i < v0.size(); ++i) {
        const VectorXd g = i == 0 ? at.gradient : VectorXd(at.jacobian.row(i - 1));
        const double by_gradient = g.dot(d);
        double slope = 0;
        // A direction that is nearly along the level set measures the errors of the direction.
        if (std::abs(by_gradient) < 0.02 * g.cwiseProduct(d).cwiseAbs().sum() ||
            !slope_of(v0[i], v1[i], v2[i], by_gradient, slope))
            continue;
        const double ratio = slope / by_gradient;
        if (std::abs(ratio - 1) <= max_difference) continue;
        result.gradient_inconsistent = true;
        result.slope_ratio = ratio;
        result.slope_of = static_cast<int>(i) - 1;
        result.reason += text("; the gradient is inconsistent with the values: along a short step ",
                              i == 0 ? std::string("the objective") : text("constraint ", i - 1), " changes by ",
                              std::round(1000 * ratio) / 1000, " of what its gradient says");
        return;
    }
}

int count_active_bounds(const Guard& guard) {
    const NonlinearProgram& p = guard.program;
    const bool has_gradient = guard.best.gradient.size() > 0;
    VectorXd slope;
    if (has_gradient) slope = lagrangian_gradient(guard);
    const double floor = has_gradient ? 1e-9 * guard.best.gradient.lpNorm<Eigen::Infinity>() : 0;
    int count = 0;
    for (const int j : guard.free)
        for (const bool upper : {false, true})
            count += at_bound(p, guard.best_x, j, upper) && (!has_gradient || (upper ? -slope[j] : slope[j]) > floor);
    return count;
}

}  // namespace strake
