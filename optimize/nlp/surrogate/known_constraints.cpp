#include "optimize/nlp/surrogate/known_constraints.hpp"

#include "core/error.hpp"
#include "optimize/nlp/model/quadratic_model.hpp"

#include <algorithm>
#include <cmath>
#include <new>

namespace strake {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr int corrections = 3;
constexpr std::size_t max_recent = 8;  ///< one step asks for a few designs again

}  // namespace

KnownConstraints::KnownConstraints(const Guard& guard) : guard_(guard) {
    const auto& low = guard.program.low_fidelity;
    if (!low) return;
    for (std::size_t i = 1; i < low->values.size(); ++i)
        if (low->values[i] == LowFidelityValue::same) rows_.push_back(static_cast<Eigen::Index>(i) - 1);
}

bool KnownConstraints::has(Eigen::Index row) const { return std::ranges::find(rows_, row) != rows_.end(); }

bool KnownConstraints::tells_slopes() const {
    const LowFidelity& low = *guard_.program.low_fidelity;
    const NonlinearProgram& cheap = *low.program;
    // Slopes of what approximates cost calls of a program, and nobody looks at them.
    if (!cheap.differentiate || std::ranges::find(low.values, LowFidelityValue::approximate) != low.values.end())
        return false;
    return std::ranges::none_of(rows_, [&](Eigen::Index i) {
        if (!cheap.differences) return false;
        const std::vector<char>& rows = cheap.differences->rows;
        return rows.empty() || rows[static_cast<std::size_t>(i)] != 0;
    });
}

bool KnownConstraints::has_done(const std::function<void()>& call, bool may_throw) {
    try {
        call();
        return true;
    } catch (const InvalidInput&) {
        throw;
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception&) {
        if (!may_throw) throw;
        return false;
    }
}

std::optional<KnownConstraints::Found> KnownConstraints::at(const VectorXd& x, bool with_slopes) const {
    if (rows_.empty()) return {};
    const auto recent = std::ranges::find(recent_, x, &Found::x);
    if (!with_slopes && recent != recent_.end()) return *recent;
    const NonlinearProgram& cheap = *guard_.program.low_fidelity->program;
    Evaluation at;
    const bool has_value = has_done([&] { at = cheap.evaluate(x); }, guard_.options.exceptions_are_failures);
    if (!has_value || !at.failure.empty() || !at.constraints(rows_).allFinite()) return {};
    Found found{x, at.constraints, {}};
    if (recent == recent_.end() && !guard_.options.limits_by_models) {
        if (recent_.size() == max_recent) recent_.erase(recent_.begin());
        recent_.push_back(found);
    }
    // The search goes on without slopes, whatever stopped them.
    if (with_slopes && tells_slopes() && has_done([&] { cheap.differentiate(x, at); }, true) && at.failure.empty() &&
        at.jacobian(rows_, Eigen::all).allFinite())
        found.jacobian = at.jacobian;
    return found;
}

double KnownConstraints::violation(const Found& found) const {
    double largest = 0;
    for (const Eigen::Index i : rows_) {
        const double c = found.constraints[i];
        largest = std::max(largest, i < guard_.program.num_inequalities ? c : std::abs(c));
    }
    return largest;
}

QuadraticModel KnownConstraints::way_to_nearest(const VectorXd& x, const Found& near) const {
    const NonlinearProgram& p = guard_.program;
    const std::vector<int>& free = guard_.free;
    QuadraticModel model;
    model.hessian = MatrixXd(metric_of(p)(free, free));
    model.lower = (p.lower - x)(free);
    model.upper = (p.upper - x)(free);
    model.gradient = VectorXd::Zero(model.hessian.rows());
    model.num_inequalities =
        static_cast<int>(std::ranges::count_if(rows_, [&](Eigen::Index i) { return i < p.num_inequalities; }));
    model.jacobian = near.jacobian(rows_, free);
    model.constraints = near.constraints(rows_) + near.jacobian(rows_, Eigen::all) * (x - near.x);
    return model;
}

VectorXd KnownConstraints::after(const VectorXd& x, const VectorXd& step) const {
    VectorXd next = x;
    next(guard_.free) += step;
    return next.cwiseMax(guard_.program.lower).cwiseMin(guard_.program.upper);  // but for rounding it is
}

VectorXd KnownConstraints::nearest(const VectorXd& x, const Found& near) const {
    const std::optional<Found> here = at(x, false);
    if (!near.has_slopes() || (here && are_met(*here))) return x;
    QuadraticModel model = way_to_nearest(x, near);
    VectorXd nearest = x;
    double least = here ? violation(*here) : std::numeric_limits<double>::infinity();
    for (int k = 0; k < corrections; ++k) {
        const VectorXd d = solve_model(model);
        if (d.size() == 0 || !d.allFinite()) break;
        const VectorXd next = after(x, d);
        const std::optional<Found> there = at(next, false);
        // Where curvature outweighs slopes every correction leads farther away.
        if (!there || violation(*there) >= least) break;
        nearest = next;
        least = violation(*there);
        if (are_met(*there)) break;
        model.constraints += there->constraints(rows_) - (model.constraints + model.jacobian * d);
    }
    return nearest;
}

VectorXd KnownConstraints::nearest_by_slopes(const VectorXd& x, const Found& near, const VectorXd& from,
                                             const StepLimits& limits) const {
    QuadraticModel model = way_to_nearest(x, near);
    if (limits.values.size() > 0)
        model.add_inequalities({limits.values + limits.slopes * (x - from), limits.slopes(Eigen::all, guard_.free)});
    const VectorXd d = solve_model(model);
    return d.size() == 0 || !d.allFinite() ? x : after(x, d);
}

}  // namespace strake
