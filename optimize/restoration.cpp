#include "optimize/restoration.hpp"

#include "optimize/first_order.hpp"
#include "optimize/quadratic_model.hpp"

namespace strake {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

VectorXd shortest_step(const Guard& guard, const VectorXd& x, const VectorXd& constraints, const MatrixXd& jacobian,
                       double radius) {
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
    return solve_model(m);
}

}  // namespace

Restoration restore_feasibility(Guard& guard, const VectorXd& from, int max_steps) {
    const NonlinearProgram& p = guard.program;
    Restoration r;
    r.x = from;
    if (!guard.try_at(from, true, r.sample)) return r;
    MatrixXd jacobian = r.sample.jacobian;
    bool is_fresh = true;
    double radius = 1;
    for (int k = 0; k < max_steps; ++k) {
        const double violation = total_violation(p, r.sample.constraints);
        if (largest_violation(p, r.sample.constraints) <= guard.options.constraint_tolerance) {
            r.end = Restoration::End::feasible;
            return r;
        }
        const VectorXd d = shortest_step(guard, r.x, r.sample.constraints, jacobian, radius);
        if (d.size() == 0) return r;
        const double promised = violation - total_violation(p, r.sample.constraints + jacobian * d);
        Sample trial;
        double next = violation;
        if (promised > 1e-3 * violation) {
            if (radius < 1e-7) return r;
            if (guard.try_at(r.x + d, false, trial))
                next = total_violation(p, trial.constraints);
            else if (guard.cause != Cause::failure)
                return r;
            guard.cause = Cause::none;
        } else if (is_fresh) {
            r.end = Restoration::End::stationary;
            r.sample.jacobian = jacobian;
            return r;
        }
        const bool is_better = next < violation - 0.01 * promised;
        if (is_better) {
            r.x = (r.x + d).cwiseMax(p.lower).cwiseMin(p.upper);
            r.sample = trial;
            radius = std::min(2 * radius, 4.0);
        } else if (is_fresh) {
            radius = 0.25 * std::min(radius, d.lpNorm<Eigen::Infinity>());
            continue;
        }
        is_fresh = !(is_better && next < 0.5 * violation);
        if (!is_fresh) continue;
        if (!guard.try_at(r.x, true, r.sample)) return r;
        jacobian = r.sample.jacobian;
    }
    return r;
}

}  // namespace strake
