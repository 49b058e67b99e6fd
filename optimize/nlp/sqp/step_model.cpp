#include "optimize/nlp/sqp/step_model.hpp"

#include "optimize/nlp/sqp/trust_region.hpp"

#include <algorithm>
#include <cmath>

namespace strake {

using Eigen::VectorXd;

QuadraticModel StepModel::model_without_cut(const VectorXd& constraints, double damping) const {
    const NonlinearProgram& p = now_.program;
    QuadraticModel m;
    m.gradient = now_.at.gradient;
    m.hessian = hessian_.matrix() + damping * p.metric;
    m.lower = p.lower - now_.x;
    m.upper = p.upper - now_.x;
    m.constraints = merit_.tightened(constraints);
    m.jacobian = now_.at.jacobian;
    m.num_inequalities = p.num_inequalities;
    // Of the metric's reasonable step, as long as the damping does not shorten it.
    m.min_step = trust_region.min_model_step * hessian_.matrix().trace() / m.hessian.trace() /
                 std::sqrt(p.metric.trace() / static_cast<double>(p.metric.rows()));
    m.add_inequalities(now_.at.limits);
    m.add_inequalities(limits_);
    return m;
}

QuadraticModel StepModel::model(const VectorXd& constraints, double damping) const {
    QuadraticModel m = model_without_cut(constraints, damping);
    if (cut) m.add_inequality(cut->normal, cut->normal.dot(now_.x) - cut->limit);
    return m;
}

VectorXd StepModel::step(const VectorXd& constraints) {
    damping_ = 0;
    VectorXd d = solve_model(model(constraints, 0));
    is_limited_ = d.size() > 0 && length(d) > trust_region.radius_slack * radius;
    if (!is_limited_) return d;
    const double size = hessian_.matrix().trace() / now_.program.metric.trace();
    if (now_.guard.options.damps_by_secants) return damped_by_secants(constraints, length(d), size);
    double low = std::log(trust_region.min_damping * size), high = std::log(trust_region.max_damping * size);
    for (int i = 0; i < trust_region.max_damping_solves; ++i) {
        const double middle = 0.5 * (low + high);
        damping_ = std::exp(middle);
        d = solve_model(model(constraints, damping_));
        if (d.size() == 0) return d;
        const double size_of_step = length(d);
        if (size_of_step > radius)
            low = middle;
        else if (size_of_step < trust_region.min_length * radius)
            high = middle;
        else
            break;
    }
    return d;
}

/// The reciprocal of the length is nearly linear in the damping (Reinsch 1971; Hebden 1973).
VectorXd StepModel::damped_by_secants(const VectorXd& constraints, double undamped, double size) {
    const double wanted = 0.5 * (1 + trust_region.min_length) * radius;
    double low = 0, high = trust_region.max_damping * size;  // too long, and too short
    double before = 0, reciprocal_before = 1 / undamped;
    damping_ = std::min(size * (undamped / wanted - 1), high);
    VectorXd d;
    for (int i = 0; i < trust_region.max_damping_solves; ++i) {
        d = solve_model(model(constraints, damping_));
        if (d.size() == 0) return d;
        const double size_of_step = length(d);
        const bool is_long_enough = size_of_step >= trust_region.min_length * radius;
        if ((size_of_step <= radius && is_long_enough) || i + 1 == trust_region.max_damping_solves) break;
        (size_of_step > radius ? low : high) = damping_;
        const double reciprocal = 1 / size_of_step, slope = (reciprocal - reciprocal_before) / (damping_ - before);
        const double next = damping_ + (1 / wanted - reciprocal) / slope;
        before = damping_, reciprocal_before = reciprocal;
        const double least = trust_region.min_damping * size;
        const double middle = high > least ? std::sqrt(std::max(low, least) * high) : 0.5 * (low + high);
        damping_ = next > low && next < high ? next : middle;
    }
    return d;
}

VectorXd StepModel::step_in_present_metric() {
    NonlinearProgram& p = now_.program;
    VectorXd d = step(now_.at.constraints);
    for (int round = 0; round < trust_region.max_metric_updates && p.present_metric && d.size() > 0; ++round) {
        const VectorXd present = p.present_metric(now_.x, d);
        if (present.size() != d.size() || !present.allFinite()) break;
        const VectorXd known = p.metric * d;
        const double length2 = d.dot(present), known2 = d.dot(known);
        constexpr double factor = trust_region.min_metric_change;
        const double expected2 = std::max(known2, trust_region.min_length_share * radius * radius);
        if (!(length2 > factor * factor * expected2) || !(known2 > 0)) break;
        p.metric += present * present.transpose() / length2 - known * known.transpose() / known2;
        p.metric = 0.5 * (p.metric + p.metric.transpose()).eval();
        d = step(now_.at.constraints);
    }
    return d;
}

ActiveSet StepModel::active(const QuadraticModel& model, const VectorXd& d) const {
    ActiveSet set = active_set(model, d);
    // Limits and the cut come after the inequalities.
    const Eigen::Index first = now_.program.num_inequalities;
    const Eigen::Index more = model.constraints.size() - now_.at.constraints.size();
    std::erase_if(set.rows, [&](Eigen::Index row) { return row >= first && row < first + more; });
    for (Eigen::Index& row : set.rows)
        if (row >= first) row -= more;
    return set;
}

bool StepModel::is_cut_off(const VectorXd& d) const {
    if (!cut) return false;
    const VectorXd free = solve_model(model_without_cut(now_.at.constraints, 0));
    return free.size() == 0 || (free - d).lpNorm<Eigen::Infinity>() > now_.guard.options.step_tolerance;
}

VectorXd multipliers_of(const SqpIterate& now, const Evaluation& evaluation, const ActiveSet& set) {
    return all_multipliers(now.program.metric, evaluation, now.program.num_inequalities, set).constraints;
}

}  // namespace strake
