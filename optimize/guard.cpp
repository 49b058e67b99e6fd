#include "optimize/guard.hpp"

#include "core/error.hpp"
#include "optimize/first_order.hpp"

#include <nlopt.hpp>

namespace strake {
Guard::Guard(const NonlinearProgram& p, const MinimizeOptions& o) : program(p), options(o), best_x(p.start) {
    for (Eigen::Index j = 0; j < p.start.size(); ++j)
        if (p.lower[j] < p.upper[j]) free.push_back(static_cast<int>(j));
    wants_gradient = o.method != Method::cobyla;
}

const Sample& Guard::at(const double* z, bool gradient) {
    Eigen::VectorXd x = program.start;
    for (std::size_t i = 0; i < free.size(); ++i) x[free[i]] = z[i];
    return at_all(x, gradient);
}

const Sample& Guard::at_all(const Eigen::VectorXd& x, bool gradient) {
    if (cause != Cause::none) throw nlopt::forced_stop();
    if (!x.allFinite()) stop(Cause::asked_nonfinite);
    try {
        return sample_at(x.cwiseMax(program.lower).cwiseMin(program.upper), gradient);
    } catch (const nlopt::forced_stop&) {
        throw;
    } catch (...) {
        exception = std::current_exception();
        stop(Cause::exception);
    }
}

const Sample& Guard::sample_at(const Eigen::VectorXd& x, bool gradient) {
    if (has_best && x == best_x && (!gradient || best.gradient.size() > 0)) return best;
    if (!(last_x_.size() > 0 && x == last_x_)) evaluate(x);
    if (gradient && last_.gradient.size() == 0) differentiate(x);
    return last_;
}

void Guard::stop(Cause why) {
    cause = why;
    throw nlopt::forced_stop();
}

void Guard::evaluate(const Eigen::VectorXd& x) {
    if (evaluations >= options.max_evaluations) stop(Cause::evaluations);
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin_;
    if (options.max_seconds > 0 && evaluations > 0 && elapsed.count() > options.max_seconds) stop(Cause::time);
    ++evaluations;
    last_x_.resize(0);
    last_ = program.evaluate(x);
    if (last_.failure.empty() && (!std::isfinite(last_.objective) || !last_.constraints.allFinite()))
        last_.failure = text("objective or constraint not finite at evaluation ", evaluations);
    if (!last_.failure.empty()) {
        failure = last_.failure;
        failed_x = x;
        const bool go_on = tell({x, last_, 0, false, false, best_merit});
        stop(last_.is_fatal ? Cause::fatal : go_on ? Cause::failure : Cause::stopped);
    }
    last_x_ = x;
    rank(x);
}

void Guard::rank(const Eigen::VectorXd& x) {
    const double violation = largest_violation(program, last_.constraints);
    const bool feasible = violation <= options.constraint_tolerance;
    const bool better =
        !has_best || (feasible && !best_feasible) ||
        (feasible == best_feasible && (feasible ? last_.objective < best.objective : violation < best_violation));
    if (better) {
        has_best = true;
        best = last_;
        best_x = x;
        best_feasible = feasible;
        best_violation = violation;
    }
    if (penalty == 0) penalty = 3 * std::abs(last_.objective);  // until multipliers are known
    best_merit = std::min(best_merit, last_.objective + penalty * total_violation(program, last_.constraints));
    if (!tell({x, last_, violation, better, feasible, best_merit})) stop(Cause::stopped);
}

void Guard::differentiate(const Eigen::VectorXd& x) {
    program.differentiate(x, last_);
    if (last_.gradient.size() != x.size() || !last_.gradient.allFinite() || !last_.jacobian.allFinite()) {
        failure = text("gradient not finite at evaluation ", evaluations);
        failed_x = x;
        stop(Cause::failure);
    }
    if (has_best && best_x == x) best = last_;
}

}  // namespace strake
