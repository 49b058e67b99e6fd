#include "optimize/nlp/low_fidelity/corrected_program.hpp"

#include "optimize/nlp/program/first_order.hpp"
#include "optimize/nlp/sqp/sqp.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

namespace strake {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int max_evaluations = 80;  ///< of the cheap program, and this many more for each variable by differences
constexpr int gradients_by_differences = 12;
constexpr double tolerance = 1e-4;     ///< of the decrease that the model gives
constexpr double at_the_border = 0.9;  ///< of the radius

/// The polynomial part and the scale of the correction about a point.
struct Correction {
    VectorXd x, values, low, rho;
    MatrixXd slopes;
    std::vector<MatrixXd> hessians;

    Correction(const ResidualModel& model, const LowFidelityPoint& from)
        : x(from.x), values(from.values), low(from.low), rho(model.rho()), slopes(model.slopes()) {
        for (Index i = 0; i < values.size(); ++i) hessians.push_back(model.hessian(i));
    }
    VectorXd at(const VectorXd& there, const VectorXd& low_there) const {
        const VectorXd d = there - x;
        VectorXd all = values + rho.cwiseProduct(low_there - low) + slopes.transpose() * d;
        for (Index i = 0; i < all.size(); ++i) all[i] += 0.5 * d.dot(hessians[static_cast<std::size_t>(i)] * d);
        return all;
    }
    VectorXd gradient(Index i, const VectorXd& there, const VectorXd& low_gradient) const {
        return rho[i] * low_gradient + slopes.col(i) + hessians[static_cast<std::size_t>(i)] * (there - x);
    }
};

VectorXd with_rows(const VectorXd& v, Index at, const VectorXd& rows) {
    VectorXd all(v.size() + rows.size());
    all << v.head(at), rows, v.tail(v.size() - at);
    return all;
}

/// The Hessian of the Lagrangian without what the multiplier of the trust region adds, where the rest is positive
/// definite.
MatrixXd without_trust_region(const Guard& guard, const MatrixXd& hessian, Index row, double radius) {
    const NonlinearProgram& p = guard.program;
    if (guard.best.gradient.size() == 0 || hessian.size() == 0) return hessian;
    const double multiplier = multipliers(p, guard.best_x, guard.best)[row];
    double part = std::max(multiplier, 0.0) * 2 / (radius * radius);
    for (int k = 0; k < 5 && part > 0; ++k, part /= 2) {
        const MatrixXd rest = hessian - part * p.metric;
        const Eigen::LLT<MatrixXd> llt(rest);
        if (llt.info() == Eigen::Success && llt.rcond() > 1e-8) return rest;
    }
    return hessian;
}

}  // namespace

VectorXd corrected_values(const ResidualModel& model, const LowFidelityPoint& from, const VectorXd& x,
                          const VectorXd& low) {
    return Correction(model, from).at(x, low);
}

NonlinearProgram corrected_program(const LowFidelity& low, const ResidualModel& model, const LowFidelityPoint& from,
                                   const MatrixXd& metric, double radius, const std::optional<FailureCut>& cut) {
    const NonlinearProgram& cheap = *low.program;
    NonlinearProgram p = cheap;
    const Index row = cheap.num_inequalities;
    p.start = from.x;
    p.metric = metric;
    const Index more = cut ? 2 : 1;
    p.num_inequalities = cheap.num_inequalities + static_cast<int>(more);
    const auto correction = std::make_shared<const Correction>(model, from);
    p.evaluate = [=, evaluate = cheap.evaluate](const VectorXd& x) {
        Evaluation s = evaluate(x);
        if (!s.failure.empty()) return s;
        const VectorXd all = correction->at(x, values_of(s)), d = x - correction->x;
        s.objective = all[0];
        VectorXd limits(more);
        limits[0] = d.dot(metric * d) / (radius * radius) - 1;
        if (cut) limits[1] = (cut->normal.dot(x) - cut->limit) / radius;
        s.constraints = with_rows(all.tail(all.size() - 1), row, limits);
        return s;
    };
    if (cheap.differentiate)
        p.differentiate = [=, differentiate = cheap.differentiate](const VectorXd& x, Evaluation& s) {
            const VectorXd constraints = s.constraints;
            differentiate(x, s);
            s.constraints = constraints;
            if (!s.failure.empty()) return;
            if (s.gradient.size() == x.size()) s.gradient = correction->gradient(0, x, s.gradient);
            MatrixXd all(constraints.size(), x.size());
            for (Index i = 0, from_row = 0; i < all.rows(); ++i) {
                if (i == row)
                    all.row(i) = 2 * (metric * (x - correction->x)).transpose() / (radius * radius);
                else if (i > row && i < row + more)
                    all.row(i) = cut->normal.transpose() / radius;
                else
                    all.row(i) =
                        correction->gradient(1 + from_row, x, s.jacobian.row(from_row).transpose()).transpose(),
                    ++from_row;
            }
            s.jacobian = all;
        };
    if (p.differences && !p.differences->rows.empty())
        p.differences->rows.insert(p.differences->rows.begin() + row, static_cast<std::size_t>(more), 0);
    return p;
}

CorrectedOptimum minimize_corrected(NonlinearProgram program, int num_inequalities, const MinimizeOptions& outer,
                                    const MatrixXd& hessian, double radius) {
    program.hessian = hessian;
    MinimizeOptions options;
    options.objective_tolerance = tolerance;
    options.step_tolerance = outer.step_tolerance;
    options.constraint_tolerance = outer.constraint_tolerance;
    options.exceptions_are_failures = outer.exceptions_are_failures;
    options.first_step = std::min(outer.first_step, radius);
    options.confirm = false;
    options.max_evaluations =
        max_evaluations + (program.differences ? gradients_by_differences * static_cast<int>(program.start.size()) : 0);
    Guard guard(program, options);
    CorrectedOptimum found;
    const Index row = num_inequalities, more = program.num_inequalities - row;
    Evaluation start;
    if (guard.try_at(program.start, true, start)) {
        const SqpEnd end = minimize_by_sqp(guard);
        found.hessian = without_trust_region(guard, end.hessian, row, radius);
        found.is_found = true;
    }
    if (guard.exception) std::rethrow_exception(guard.exception);
    if (!found.is_found) return found;
    found.x = guard.best_x;
    const VectorXd& c = guard.best.constraints;
    found.values.resize(1 + c.size() - more);
    found.values << guard.best.objective, c.head(row), c.tail(c.size() - row - more);
    found.is_limited = metric_norm(program, found.x - program.start) > at_the_border * radius;
    return found;
}

}  // namespace strake
