#include "optimize/nlp/surrogate/known_constraints.hpp"

#include "optimize/nlp/model/quadratic_model.hpp"

#include <algorithm>
#include <cmath>

namespace strake {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr int corrections = 3;

}  // namespace

KnownConstraints::KnownConstraints(const Guard& guard) : guard_(guard) {
    const auto& low = guard.program.low_fidelity;
    if (!low) return;
    for (std::size_t i = 1; i < low->values.size(); ++i)
        if (low->values[i] == LowFidelityValue::same) rows_.push_back(static_cast<Eigen::Index>(i) - 1);
}

bool KnownConstraints::has(Eigen::Index row) const { return std::ranges::find(rows_, row) != rows_.end(); }

bool KnownConstraints::tells_slopes() const {
    const NonlinearProgram& cheap = *guard_.program.low_fidelity->program;
    const auto lacks_slope = [&](Eigen::Index i) {
        if (!cheap.differences) return false;
        const std::vector<char>& rows = cheap.differences->rows;
        return rows.empty() || rows[static_cast<std::size_t>(i)] != 0;
    };
    return cheap.differentiate && std::ranges::none_of(rows_, lacks_slope);
}

std::optional<KnownConstraints::Found> KnownConstraints::at(const VectorXd& x, bool with_slopes) const {
    if (rows_.empty()) return {};
    const NonlinearProgram& cheap = *guard_.program.low_fidelity->program;
    Evaluation found = cheap.evaluate(x);
    if (!found.failure.empty() || !found.constraints.allFinite()) return {};
    if (with_slopes && tells_slopes()) cheap.differentiate(x, found);
    if (!found.failure.empty() || !found.jacobian.allFinite()) found.jacobian.resize(0, 0);
    return Found{x, found.constraints, found.jacobian};
}

bool KnownConstraints::are_met(const Found& found) const {
    return std::ranges::all_of(rows_, [&](Eigen::Index i) {
        const double c = found.constraints[i];
        return (i < guard_.program.num_inequalities ? c : std::abs(c)) <= 0.5 * guard_.options.constraint_tolerance;
    });
}

VectorXd KnownConstraints::nearest(const VectorXd& x, const Found& near) const {
    if (!near.has_slopes()) return x;
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
    VectorXd kept = x;
    for (int k = 0; k < corrections; ++k) {
        const VectorXd d = solve_model(model);
        if (d.size() == 0 || !d.allFinite()) break;
        kept(free) = x(free) + d;
        const std::optional<Found> there = at(kept, false);
        if (!there) break;
        const VectorXd missed = there->constraints(rows_) - (model.constraints + model.jacobian * d);
        if (missed.lpNorm<Eigen::Infinity>() <= 0.5 * guard_.options.constraint_tolerance) break;
        model.constraints += missed;
    }
    return kept;
}

}  // namespace strake
