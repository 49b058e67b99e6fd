#include "optimize/nlp/model/restoration.hpp"

#include "optimize/nlp/model/quadratic_model.hpp"
#include "optimize/nlp/program/first_order.hpp"

namespace strake {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

VectorXd shortest_step(const Guard& guard, const VectorXd& x, const VectorXd& constraints, const MatrixXd& jacobian,
                       const StepLimits& limits, double radius) {
    const NonlinearProgram& p = guard.program;
    QuadraticModel m;
    m.gradient = VectorXd::Zero(x.size());
    m.hessian = metric_of(p);
    m.lower = (p.lower - x).cwiseMax(-radius);
    m.upper = (p.upper - x).cwiseMin(radius);
    m.constraints = constraints;
    m.constraints.head(p.num_inequalities).array() += 0.5 * guard.options.constraint_tolerance;
    m.jacobian = jacobian;
    m.num_inequalities = p.num_inequalities;
    m.add_inequalities(limits);
    return solve_model(m);
}

/// To first order, what the limits are after a step.
void move(StepLimits& limits, const VectorXd& step) {
    if (limits.values.size() > 0) limits.values += limits.slopes * step;
}

}  // namespace

Restoration restore_feasibility(Guard& guard, const VectorXd& from, int max_steps) {
    const NonlinearProgram& p = guard.program;
    Restoration r;
    r.x = guard.inside(from.cwiseMax(p.lower).cwiseMin(p.upper));
    if (!guard.try_at(r.x, true, r.evaluation)) return r;
    MatrixXd jacobian = r.evaluation.jacobian;
    StepLimits limits = r.evaluation.limits;  // on steps from where the Jacobian is that of
    bool is_fresh = true;
    double radius = 1;
    for (int k = 0; k < max_steps; ++k) {
        const double violation = total_violation(p, r.evaluation.constraints);
        if (largest_violation(p, r.evaluation.constraints) <= guard.options.constraint_tolerance) {
            r.end = Restoration::End::feasible;
            return r;
        }
        const VectorXd d = shortest_step(guard, r.x, r.evaluation.constraints, jacobian, limits, radius);
        if (d.size() == 0) return r;
        const double expected = violation - total_violation(p, r.evaluation.constraints + jacobian * d);
        Evaluation trial;
        VectorXd there = r.x + d;
        double next = violation;
        if (expected > 1e-3 * violation) {
            if (radius < 1e-7) return r;
            there = guard.inside(there.cwiseMax(p.lower).cwiseMin(p.upper));
            if (guard.try_at(there, false, trial))
                next = total_violation(p, trial.constraints);
            else if (guard.cause != StopCause::failure)
                return r;
            guard.cause = StopCause::none;
        } else if (is_fresh) {
            r.end = Restoration::End::stationary;
            r.evaluation.jacobian = jacobian;
            return r;
        }
        const bool is_better = next < violation - 0.01 * expected;
        if (is_better) {
            move(limits, there - r.x);
            r.x = there;
            r.evaluation = trial;
            radius = std::min(2 * radius, 4.0);
        } else if (is_fresh) {
            radius = 0.25 * std::min(radius, d.lpNorm<Eigen::Infinity>());
            continue;
        }
        is_fresh = !(is_better && next < 0.5 * violation);
        if (!is_fresh) continue;
        if (!guard.try_at(r.x, true, r.evaluation)) return r;
        jacobian = r.evaluation.jacobian;
        limits = r.evaluation.limits;
    }
    return r;
}

}  // namespace strake
