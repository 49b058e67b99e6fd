#include "optimize/sqp_search.hpp"

#include "core/error.hpp"
#include "optimize/border_probes.hpp"

#include <algorithm>

namespace strake {

using Eigen::VectorXd;

namespace {

constexpr int most_rejections = 12;  ///< in a row: the gradient does not say what the values do
constexpr int failures_at_border = 100, failures_in_row_at_border = 32;  ///< more than elsewhere
constexpr double border_share = 3e-5;  ///< of the decrease: what more a border would let gain is not worth failures
constexpr double probe_share = 5e-4;   ///< of the decrease: a border's last steps look for so much
constexpr int probe_pairs = 8;
constexpr double creeping_share = 2e-4;  ///< of the decrease: so little, so many steps in a row, and the border's
constexpr int creeping_steps = 3;        ///< direction is wrong: probes turn it, more steps do not

}  // namespace

bool SqpSearch::is_at_rest(const VectorXd& d, double predicted) {
    const bool feasible = largest_violation(p_, at_.constraints) <= tolerance();
    const double size =
        std::max({std::abs(at_.objective), guard_.options.objective_scale, std::numeric_limits<double>::min()});
    if (is_limited_ && radius_ > guard_.options.step_tolerance) return false;
    if (d.lpNorm<Eigen::Infinity>() <= guard_.options.step_tolerance)
        return end(is_limited_ ? MinimizeStop::roundoff
                   : feasible  ? MinimizeStop::converged
                               : MinimizeStop::roundoff,
                   is_limited_ ? "no step, however short, gains what the gradient promises"
                   : feasible  ? "the variables change by less than the tolerance"
                               : "the constraints cannot be met within the bounds");
    if (predicted <= 0.1 * guard_.options.objective_tolerance * size && feasible)
        return end(MinimizeStop::converged, "the gradient promises less than the tolerance");
    return false;
}

bool SqpSearch::failed_at(const VectorXd& d) {
    if (guard_.cause != Cause::failure) return ended_by_guard();
    guard_.cause = Cause::none;
    if (!guard_.failed_on_the_way) border_.has_failed(x_, p_.metric);
    const bool knows_border = !guard_.failed_on_the_way && border_.cut().has_value();
    if (knows_border && border_gain() <= border_share * so_far()) return end_at_border();
    ++failures_;
    // To learn where the border lies takes failures, the more the more variables there are.
    const int row = guard_.options.max_shrinks +
                    (knows_border ? std::min(4 * static_cast<int>(x_.size()), failures_in_row_at_border) : 0);
    const int all = guard_.options.max_failures + (knows_border ? accepted_ + failures_at_border : 0);
    if (knows_border && failures_ == row && end_.shrinks < all) {
        if (end_at_border()) return true;
        // Where steps have been made the probes have turned the plane, and others along it may do.
        if (!has_probed_ && accepted_ > 0) failures_ /= 2;
        has_probed_ = true;
        return false;
    }
    if (failures_ > row || end_.shrinks >= all) {
        end_.is_at_border = knows_border;
        return end(MinimizeStop::blocked,
                   text("evaluations keep failing next to the best point (", end_.shrinks + 1, " of ",
                        guard_.evaluations, ", ", failures_, " in a row); the last failure: ", guard_.failure));
    }
    ++end_.shrinks;
    if (!knows_border) radius_ = (failures_ > 1 ? 0.25 : 0.5) * std::min(radius_, metric_norm(p_, d));
    tell(text("after the failure of its evaluation ", guard_.evaluations, ": ",
              knows_border ? std::string("steps keep to this side of the plane between what failed and what did not")
                           : text("the largest step is cut to ", radius_)));
    return false;
}

double SqpSearch::promised(const std::optional<FailureCut>& cut) const {
    const VectorXd d = solve_model(model(at_.constraints, 0, cut));
    return d.size() == 0 ? 0 : -(at_.gradient.dot(d) + 0.5 * d.dot(B_ * d));
}

bool SqpSearch::creeps(double decrease) {
    creeping_ = border_.cut() && decrease < creeping_share * so_far() ? creeping_ + 1 : 0;
    if (creeping_ < creeping_steps) return false;
    creeping_ = 0;
    return true;
}

bool SqpSearch::end_at_border() {
    const double worth = probe_share * so_far();
    std::vector<VectorXd> steps = border_probes(p_, x_, at_, B_, worth, probe_pairs);
    // What failed there may have been bad luck.
    if (const VectorXd free = solve_model(model(at_.constraints, 0, std::nullopt)); free.size() > 0)
        for (const double share : {0.2, 0.6})
            steps.insert(steps.begin(), share * std::min(1.0, radius_ / metric_norm(p_, free)) * free);
    for (const VectorXd& d : steps) {
        Sample trial;
        if (evaluate(x_ + d, false, trial)) {
            const double decrease = merit(at_) - merit(trial);
            if (decrease > 0) return accept(x_ + d, trial, decrease);
            continue;
        }
        if (guard_.cause != Cause::failure) return ended_by_guard();
        guard_.cause = Cause::none;
        border_.has_failed(x_, p_.metric);
        if (border_.cut() && border_gain() > worth) return false;
    }
    end_.is_at_border = true;
    return end(MinimizeStop::blocked,
               text("evaluations fail beyond a border next to the best point, up to which nothing is left to gain (",
                    guard_.failures, " of ", guard_.evaluations, " failed); the last failure: ", guard_.failure));
}

bool SqpSearch::rejected(double length) {
    if (++rejections_ < most_rejections && length > 1e-12) return false;
    return end(MinimizeStop::roundoff, "no step, however short, gains what the gradient promises");
}

bool SqpSearch::model_failed() {
    if (++model_failures_ > 2) return end(MinimizeStop::roundoff, "the quadratic model can no longer be solved");
    start_hessian();
    return false;
}

bool SqpSearch::ended_by_guard() {
    switch (guard_.cause) {
        case Cause::evaluations:
            return end(MinimizeStop::evaluations,
                       text("the limit of evaluations is reached (", guard_.evaluations, ")"));
        case Cause::time:
            return end(MinimizeStop::time, "the time limit is reached");
        case Cause::stopped:
            return end(MinimizeStop::stopped, "stopped on request");
        default:
            return end(MinimizeStop::failed, guard_.failure);
    }
}

void SqpSearch::restore() {
    if (end_.stop == MinimizeStop::failed || !needs_restoration()) return;
    if (guard_.best_feasible && !(at_.objective < guard_.best.objective)) return;
    if (guard_.cause == Cause::stopped) guard_.cause = Cause::none;
    VectorXd x = x_;
    Sample s = at_;
    for (int i = 0; i < restorations && guard_.cause == Cause::none; ++i) {
        QuadraticModel m = model(s.constraints, 0);
        m.gradient.setZero();
        m.hessian = p_.metric;
        m.lower = p_.lower - x;
        m.upper = p_.upper - x;
        const VectorXd d = solve_model(m);
        if (d.size() == 0 || metric_norm(p_, d) > 0.5) return;
        x += d;
        if (!evaluate(x, false, s) || largest_violation(p_, s.constraints) <= tolerance()) return;
    }
}

bool SqpSearch::is_cut_off(const VectorXd& d) const {
    if (!border_.cut()) return false;
    const VectorXd free = solve_model(model(at_.constraints, 0, std::nullopt));
    return free.size() == 0 || (free - d).lpNorm<Eigen::Infinity>() > guard_.options.step_tolerance;
}

}  // namespace strake
