#include "optimize/nlp/nlopt/augmented_lagrangian.hpp"

#include "core/error.hpp"
#include "optimize/nlp/program/first_order.hpp"

namespace strake {

using Eigen::VectorXd;

namespace {

constexpr int max_searches = 40, global_searches = 3;
constexpr double max_penalty = 1e9, max_multiplier = 1e9;

class Augmented {
public:
    Augmented(Guard& guard, const MethodFacts& method)
        : guard_(guard), p_(guard.program), method_(method), x_(guard.best_x), at_(guard.best) {
        terms_.inequalities = !method.takes_inequalities;
        terms_.equalities = !method.takes_equalities;
    }

    SearchEnd run() {
        initialize();
        const int limit = guard_.limit;
        const int searches = method_.is_global ? global_searches : max_searches;
        bool is_done = false;
        for (int k = 0; k < searches && !is_done; ++k) {
            if (method_.is_global) guard_.limit = guard_.evaluations + (limit - guard_.evaluations) / (searches - k);
            is_done = search(k) || advance(k);
            guard_.limit = limit;
        }
        if (!is_done) end(MinimizeStop::roundoff, "the multipliers do not settle");
        end_.shrinks = shrinks_;
        end_.x = x_;
        return end_;
    }

private:
    void initialize() {
        terms_.multipliers = VectorXd::Zero(at_.constraints.size());
        if (at_.gradient.size() > 0) terms_.multipliers = multipliers(p_, x_, at_) / guard_.scale;
        double squares = 0;
        for (Eigen::Index i = 0; i < at_.constraints.size(); ++i)
            squares += std::pow(i < p_.num_inequalities ? std::max(0.0, at_.constraints[i]) : at_.constraints[i], 2);
        const double size = std::abs(at_.objective) / guard_.scale;
        terms_.penalty = squares > 0 ? std::clamp(2 * size / squares, 10.0, 1e3) : 10;
    }

    double looseness(int k) const { return method_.is_global ? 0 : 1e-2 * std::pow(0.1, k); }

    /// One inner search from x_. True: that was the last.
    bool search(int k) {
        const MinimizeOptions& o = guard_.options;
        is_strict_ = looseness(k) <= o.objective_tolerance || strictly_;
        const double loose = strictly_ ? 0 : looseness(k);
        RestartOptions how{std::max(o.objective_tolerance, loose), std::max(o.step_tolerance, loose), o.max_shrinks,
                           method_.is_global ? 0 : 1};
        const SearchEnd inner = run_with_restarts(guard_, method_, &terms_, x_, how);
        shrinks_ += inner.shrinks;
        x_ = inner.x;
        if (inner.at.constraints.size() > 0) at_ = inner.at;
        if (inner.stop == MinimizeStop::evaluations && method_.is_global) {
            guard_.cause = StopCause::none;
            if (k + 1 == global_searches) return end_ = inner, true;
        } else if (inner.stop != MinimizeStop::converged && inner.stop != MinimizeStop::roundoff)
            return end_ = inner, true;
        return false;
    }

    /// The largest failure of feasibility and complementarity among the terms.
    double defect() const {
        double worst = 0;
        for (Eigen::Index i = 0; i < at_.constraints.size(); ++i) {
            const double c = at_.constraints[i];
            if (i >= p_.num_inequalities)
                worst = terms_.equalities ? std::max(worst, std::abs(c)) : worst;
            else if (terms_.inequalities)
                worst = std::max(worst, std::abs(std::max(c, -terms_.multipliers[i] / terms_.penalty)));
        }
        return worst;
    }

    /// Moves the multipliers and the penalty. True: converged, or no use.
    bool advance(int) {
        const double now = defect();
        // An objective of unit size moves by about the tolerance when the constraints move by it.
        if (now <= std::max(guard_.options.constraint_tolerance, 1e-10)) {
            if (is_strict_) return end(MinimizeStop::converged, "the multipliers have settled"), true;
            strictly_ = true;
        }
        terms_.multipliers = terms_.updated(p_, at_).cwiseMin(max_multiplier).cwiseMax(-max_multiplier).eval();
        if (now > 0.5 * defect_) terms_.penalty *= 10;
        defect_ = now;
        if (terms_.penalty > max_penalty)
            return end(MinimizeStop::roundoff, largest_violation(p_, at_.constraints) > 1e-2
                                                   ? "the constraints cannot be met within the bounds"
                                                   : "the penalty has reached its limit"),
                   true;
        return false;
    }

    void end(MinimizeStop stop, const std::string& reason) {
        end_.stop = stop;
        end_.reason = reason;
    }

    Guard& guard_;
    const NonlinearProgram& p_;
    const MethodFacts& method_;
    Lagrangian terms_;
    VectorXd x_;
    Evaluation at_;
    SearchEnd end_;
    double defect_ = std::numeric_limits<double>::infinity();
    int shrinks_ = 0;
    bool is_strict_ = false, strictly_ = false;
};

}  // namespace

bool needs_lagrangian(const MethodFacts& method, const NonlinearProgram& p) {
    return (p.num_inequalities > 0 && !method.takes_inequalities) || (p.num_equalities > 0 && !method.takes_equalities);
}

SearchEnd minimize_augmented(Guard& guard, const MethodFacts& method) { return Augmented(guard, method).run(); }

}  // namespace strake
