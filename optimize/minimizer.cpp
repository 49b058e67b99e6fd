#include "optimize/minimizer.hpp"

#include "core/error.hpp"
#include "optimize/first_order.hpp"
#include "optimize/guard.hpp"
#include "optimize/sqp.hpp"

#include <nlopt.hpp>

namespace strake {
namespace {

using Eigen::VectorXd;

nlopt::algorithm algorithm_of(Method method) {
    switch (method) {
        case Method::slsqp:
            return nlopt::LD_SLSQP;
        case Method::mma:
            return nlopt::LD_MMA;
        case Method::lbfgs:
            return nlopt::LD_LBFGS;
        case Method::cobyla:
            return nlopt::LN_COBYLA;
    }
    throw InvalidInput("unknown optimization method");
}

void validate(const NonlinearProgram& p, const MinimizeOptions& o) {
    const Eigen::Index n = p.start.size();
    if (p.lower.size() != n || p.upper.size() != n)
        throw InvalidInput(text("bounds: ", p.lower.size(), " and ", p.upper.size(), " for ", n, " variables"));
    for (Eigen::Index j = 0; j < n; ++j)
        if (!(p.lower[j] <= p.start[j] && p.start[j] <= p.upper[j]))
            throw InvalidInput(
                text("start of variable ", j, " = ", p.start[j], " must be in [", p.lower[j], ", ", p.upper[j], "]"));
    if (o.max_evaluations < 1) throw InvalidInput(text("max_evaluations = ", o.max_evaluations, " must be >= 1"));
    if (o.method == Method::lbfgs && p.num_inequalities + p.num_equalities > 0)
        throw InvalidInput("method lbfgs takes no constraints; use slsqp or cobyla");
    if (o.method == Method::mma && p.num_equalities > 0)
        throw InvalidInput("method mma takes no equality constraints; use slsqp or cobyla");
}

double objective_of(unsigned, const double* z, double* gradient, void* self) {
    auto& guard = *static_cast<Guard*>(self);
    const Sample& sample = guard.at(z, gradient != nullptr);
    if (gradient)
        for (std::size_t i = 0; i < guard.free.size(); ++i) gradient[i] = sample.gradient[guard.free[i]] / guard.scale;
    return sample.objective / guard.scale;
}

void fill_constraints(int first, unsigned count, double* value, const double* z, double* gradient, Guard& guard) {
    const Sample& sample = guard.at(z, gradient != nullptr);
    for (unsigned i = 0; i < count; ++i) {
        value[i] = sample.constraints[first + i];
        for (std::size_t j = 0; gradient && j < guard.free.size(); ++j)
            gradient[i * guard.free.size() + j] = sample.jacobian(first + i, guard.free[j]);
    }
}

void inequalities_of(unsigned count, double* value, unsigned, const double* z, double* gradient, void* self) {
    fill_constraints(0, count, value, z, gradient, *static_cast<Guard*>(self));
}

void equalities_of(unsigned count, double* value, unsigned, const double* z, double* gradient, void* self) {
    auto& guard = *static_cast<Guard*>(self);
    fill_constraints(guard.program.num_inequalities, count, value, z, gradient, guard);
}

/// The box of allowed x around the best point; `radius` in every variable, infinite: the whole bounds.
struct Box {
    VectorXd lower, upper;
    bool touched = false;  ///< set by the caller: the best point lies on a side that is not a bound
};
Box box_around(const NonlinearProgram& p, const VectorXd& centre, double radius) {
    return {p.lower.cwiseMax((centre.array() - radius).matrix()), p.upper.cwiseMin((centre.array() + radius).matrix()),
            false};
}
bool lies_on_artificial_side(const NonlinearProgram& p, const Box& box, const VectorXd& x) {
    for (Eigen::Index j = 0; j < x.size(); ++j)
        if ((x[j] <= box.lower[j] && box.lower[j] > p.lower[j]) || (x[j] >= box.upper[j] && box.upper[j] < p.upper[j]))
            return true;
    return false;
}

/// One run of NLopt in a box. Returns its code; guard.cause tells if we ended it.
nlopt::result run_nlopt(Guard& guard, const Box& box) {
    const NonlinearProgram& p = guard.program;
    const MinimizeOptions& o = guard.options;
    nlopt::opt opt(algorithm_of(o.method), static_cast<unsigned>(guard.free.size()));
    std::vector<double> z, lower, upper;
    for (const int j : guard.free) {
        z.push_back(guard.best_x[j]);
        lower.push_back(box.lower[j]);
        upper.push_back(box.upper[j]);
    }
    opt.set_lower_bounds(lower);
    opt.set_upper_bounds(upper);
    opt.set_min_objective(objective_of, &guard);
    if (p.num_inequalities > 0)
        opt.add_inequality_mconstraint(inequalities_of, &guard,
                                       std::vector<double>(p.num_inequalities, o.constraint_tolerance));
    if (p.num_equalities > 0)
        opt.add_equality_mconstraint(equalities_of, &guard,
                                     std::vector<double>(p.num_equalities, o.constraint_tolerance));
    opt.set_ftol_rel(o.objective_tolerance);
    opt.set_ftol_abs(1e-3 * o.objective_tolerance * std::abs(guard.best.objective) / guard.scale);
    opt.set_xtol_abs(o.step_tolerance);
    // Our own limit counts distinct points; this one only keeps NLopt from circling among known ones.
    opt.set_maxeval(20 * o.max_evaluations + 100);
    if (o.method == Method::cobyla) opt.set_initial_step(0.25);
    double value = 0;
    try {
        return opt.optimize(z, value);
    } catch (const nlopt::roundoff_limited&) {
        return nlopt::ROUNDOFF_LIMITED;
    } catch (const nlopt::forced_stop&) {
        return nlopt::FORCED_STOP;
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception&) {
        return nlopt::FAILURE;
    }
}

/// So that the first step of a method that starts with a unit Hessian has the wanted length.
double objective_scale(const Guard& guard) {
    if (!guard.wants_gradient) return std::abs(guard.best.objective) > 0 ? std::abs(guard.best.objective) : 1;
    constexpr double floor = 1e-3;  // of the unconstrained gradient's step
    const NonlinearProgram& p = guard.program;
    const VectorXd direction = descent_direction(p, guard.best_x, guard.best);
    const double step = std::max(metric_norm(p, direction), floor * metric_norm(p, guard.best.gradient));
    return step > 0 && std::isfinite(step) ? step / guard.options.first_step : 1;
}

/// The state of `minimize`: how often the algorithm was started anew, and in which box.
class Minimization {
public:
    Minimization(const NonlinearProgram& program, const MinimizeOptions& options) : guard_(program, options) {}

    MinimizeResult run() {
        if (start()) {
            if (guard_.options.method == Method::slsqp)
                run_sqp();
            else
                while (!once_more()) {
                }
        }
        if (guard_.exception) std::rethrow_exception(guard_.exception);
        result_.x = guard_.best_x;
        result_.best = guard_.best;
        result_.violation = guard_.best_violation;
        result_.is_feasible = guard_.has_best && guard_.best_feasible;
        result_.evaluations = guard_.evaluations;
        return result_;
    }

private:
    /// Evaluates the start. False: that is all.
    bool start() {
        try {
            guard_.at_all(guard_.program.start, guard_.wants_gradient);
        } catch (const nlopt::forced_stop&) {
            end_by_cause();
            if (guard_.cause == Cause::failure || guard_.cause == Cause::fatal)
                end(MinimizeStop::failed, text("the start cannot be evaluated: ", guard_.failure));
            return false;
        }
        if (guard_.free.empty()) return end(MinimizeStop::converged, "there is no free variable"), false;
        guard_.scale = objective_scale(guard_);
        if (guard_.wants_gradient && guard_.best.gradient.isZero(0) && guard_.best_feasible)
            return end(MinimizeStop::converged, "the objective does not change with any variable"), false;
        return true;
    }

    void run_sqp() {
        for (bool go_on = true; go_on;) {
            const double before = guard_.best.objective;
            const bool feasible_before = guard_.best_feasible;
            const SqpEnd sqp = minimize_by_sqp(guard_);
            result_.shrinks += sqp.shrinks;
            result_.radius = sqp.radius;
            end(sqp.stop, sqp.reason);
            go_on = sqp.stop == MinimizeStop::converged && wants_confirmation(before, feasible_before);
        }
    }

    /// A quasi-Newton method may stop short; what a fresh start gains tells.
    bool wants_confirmation(double before, bool feasible_before) {
        const double floor = 10 * guard_.options.objective_tolerance * std::abs(guard_.best.objective);
        const bool gained = before - guard_.best.objective > floor || feasible_before != guard_.best_feasible;
        if (!guard_.options.confirm || !gained || ++confirmations_ > 5) return false;
        tell("converged; a fresh start from here confirms or continues");
        return true;
    }

    /// Runs the algorithm once in the present box. True: finished.
    bool once_more() {
        const double before = guard_.best.objective;
        const bool feasible_before = guard_.best_feasible;
        const Box box = box_around(guard_.program, guard_.best_x, radius_);
        const nlopt::result code = run_nlopt(guard_, box);
        if (guard_.cause == Cause::failure) return shrink();
        if (guard_.cause == Cause::asked_nonfinite) return broke_down();
        if (guard_.cause != Cause::none) return end_by_cause(), true;
        if (code == nlopt::FAILURE || code == nlopt::INVALID_ARGS) return broke_down();
        if (lies_on_artificial_side(guard_.program, box, guard_.best_x)) return grow();
        if (wants_confirmation(before, feasible_before)) return false;
        if (code == nlopt::ROUNDOFF_LIMITED)
            return end(MinimizeStop::roundoff, "no further progress in double precision"), true;
        if (code == nlopt::MAXEVAL_REACHED)
            return end(MinimizeStop::roundoff, "the algorithm circles among points that it knows"), true;
        return end(MinimizeStop::converged, code == nlopt::XTOL_REACHED
                                                ? "the variables change by less than the tolerance"
                                                : "the objective changes by less than the tolerance"),
               true;
    }

    bool shrink() {
        if (result_.shrinks >= guard_.options.max_shrinks)
            return end(MinimizeStop::blocked,
                       text("evaluations fail next to the best point even after ", result_.shrinks,
                            " halvings of the step; the last failure: ", guard_.failure)),
                   true;
        ++result_.shrinks;
        const double step = (guard_.failed_x - guard_.best_x).lpNorm<Eigen::Infinity>();
        const double widest = (guard_.program.upper - guard_.program.lower).maxCoeff();
        // Half of the box, and less if the failing step was shorter than that.
        radius_ = std::min(0.5 * std::min(radius_, widest), 0.5 * step);
        tell(text("evaluation ", guard_.evaluations, " failed (", guard_.failure,
                  "); starting again at the best point "
                  "with steps up to ",
                  radius_, " (halving ", result_.shrinks, " of ", guard_.options.max_shrinks, ")"));
        guard_.cause = Cause::none;
        return !(radius_ > 0) ? (end(MinimizeStop::blocked, text("evaluations fail: ", guard_.failure)), true) : false;
    }

    bool grow() {
        radius_ *= 2;
        tell(text("the best point lies on the border of the halved box; steps up to ", radius_, " again"));
        return false;
    }

    /// SLSQP can ask for x = NaN or give up without a word: the best point stands, a fresh start may go on.
    bool broke_down() {
        guard_.cause = Cause::none;
        if (++breakdowns_ <= 2) return tell("the algorithm broke down; starting again at the best point"), false;
        return end(MinimizeStop::roundoff, "the algorithm broke down; the best point seen stands"), true;
    }

    void end_by_cause() {
        switch (guard_.cause) {
            case Cause::evaluations:
                return end(MinimizeStop::evaluations,
                           text("the limit of evaluations is reached (", guard_.evaluations, ")"));
            case Cause::time:
                return end(MinimizeStop::time, "the time limit is reached");
            case Cause::stopped:
                return end(MinimizeStop::stopped, "stopped on request");
            case Cause::fatal:
                return end(MinimizeStop::failed, guard_.failure);
            default:
                return end(MinimizeStop::failed, "the algorithm failed");
        }
    }

    void end(MinimizeStop stop, const std::string& reason) {
        result_.stop = stop;
        result_.reason = reason;
    }
    void tell(const std::string& event) {
        if (guard_.options.on_event) guard_.options.on_event(event);
    }

    Guard guard_;
    MinimizeResult result_;
    double radius_ = std::numeric_limits<double>::infinity();
    int confirmations_ = 0, breakdowns_ = 0;
};

}  // namespace

MinimizeResult minimize(const NonlinearProgram& program, const MinimizeOptions& options) {
    validate(program, options);
    return Minimization(program, options).run();
}

}  // namespace strake
