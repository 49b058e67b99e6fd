#include "optimize/sqp_search.hpp"

#include "core/error.hpp"

#include <algorithm>

namespace strake {

using Eigen::VectorXd;

namespace {

constexpr int most_rejections = 12;     ///< in a row: the gradient does not say what the values do
constexpr int doubtful_rejections = 2;  ///< in a row: the guessed part of the gradient may be why
constexpr int failures_at_border = 100, failures_in_row_at_border = 32;  ///< more than elsewhere
constexpr double border_share = 1e-5;  ///< of the decrease: what less a step along a border may gain is not worth it

}  // namespace

bool SqpSearch::is_little(double promise) const {
    const double size =
        std::max({std::abs(at_.objective), guard_.options.objective_scale, std::numeric_limits<double>::min()});
    return promise <= 0.1 * guard_.options.objective_tolerance * size;
}

bool SqpSearch::is_at_rest(const VectorXd& d, double predicted) {
    const bool feasible = largest_violation(p_, at_.constraints) <= tolerance();
    if (is_limited_ && radius_ > guard_.options.step_tolerance) {
        if (!feasible || rejections_ == 0) return false;
        // A step that is short since longer ones were rejected promises little in any case.
        const VectorXd free = solve_model(model(at_.constraints, 0));
        if (free.size() == 0 || !is_little(promised(free))) return false;
        return end(MinimizeStop::converged, "the gradient promises less than the tolerance");
    }
    if (d.lpNorm<Eigen::Infinity>() <= guard_.options.step_tolerance)
        return end(is_limited_ ? MinimizeStop::roundoff
                   : feasible  ? MinimizeStop::converged
                               : MinimizeStop::roundoff,
                   is_limited_ ? "no step, however short, gains what the gradient promises"
                   : feasible  ? "the variables change by less than the tolerance"
                               : "the constraints cannot be met within the bounds");
    if (is_little(predicted) && feasible)
        return end(MinimizeStop::converged, "the gradient promises less than the tolerance");
    return false;
}

bool SqpSearch::failed_at(const VectorXd& d) {
    if (guard_.cause != Cause::failure) return ended_by_guard();
    guard_.cause = Cause::none;
    if (!guard_.failed_on_the_way) look_at_border();
    const bool knows_border = !guard_.failed_on_the_way && cut_.has_value();
    if (knows_border && expected_ <= border_share * so_far()) return end_at_border();
    ++failures_;
    // To learn where the border lies takes failures, the more the more variables there are.
    const int row = guard_.options.max_shrinks +
                    (knows_border ? std::min(4 * static_cast<int>(x_.size()), failures_in_row_at_border) : 0);
    const int all = guard_.options.max_failures + (knows_border ? accepted_ + failures_at_border : 0);
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

bool SqpSearch::rejected(double length) {
    if (++rejections_ == doubtful_rejections && pay_doubt()) return false;
    if (rejections_ < most_rejections && length > 1e-12) return false;
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

}  // namespace strake
