#include "optimize/nlp/model/quadratic_model.hpp"

#include "optimize/nlp/model/least_distance.hpp"

#include <Eigen/Cholesky>
#include <nlopt.hpp>
#include <vector>

namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

double objective(unsigned n, const double* u, double* gradient, void* self) {
    const auto& p = *static_cast<LeastDistance*>(self);
    const Eigen::Map<const VectorXd> at(u, n);
    if (gradient) VectorXd::Map(gradient, n) = at + p.q;
    return 0.5 * at.squaredNorm() + p.q.dot(at);
}

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

void linear(unsigned m, double* value, unsigned n, const double* u, double* gradient, const MatrixXd& rows,
            const VectorXd& limits) {
    VectorXd::Map(value, m) = rows * Eigen::Map<const VectorXd>(u, n) - limits;
    if (gradient) RowMajor::Map(gradient, m, n) = rows;
}
void inequalities(unsigned m, double* value, unsigned n, const double* u, double* gradient, void* self) {
    const auto& p = *static_cast<LeastDistance*>(self);
    linear(m, value, n, u, gradient, p.inequality_rows, p.inequality_limits);
}
void equalities(unsigned m, double* value, unsigned n, const double* u, double* gradient, void* self) {
    const auto& p = *static_cast<LeastDistance*>(self);
    linear(m, value, n, u, gradient, p.equality_rows, p.equality_limits);
}

/// Where rounding stops the exact method: the same problem as a general one.
VectorXd solve_by_slsqp(LeastDistance& p) {
    const auto n = static_cast<unsigned>(p.q.size());
    nlopt::opt opt(nlopt::LD_SLSQP, n);
    opt.set_min_objective(objective, &p);
    if (p.inequality_limits.size() > 0)
        opt.add_inequality_mconstraint(inequalities, &p, std::vector<double>(p.inequality_limits.size(), 1e-12));
    if (p.equality_limits.size() > 0)
        opt.add_equality_mconstraint(equalities, &p, std::vector<double>(p.equality_limits.size(), 1e-12));
    opt.set_ftol_rel(1e-12);
    opt.set_xtol_rel(1e-10);
    opt.set_maxeval(60);
    std::vector<double> u(n, 0.0);
    double value = 0;
    try {
        opt.optimize(u, value);
    } catch (const nlopt::roundoff_limited&) {
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception&) {
        return {};
    }
    return VectorXd::Map(u.data(), n);
}

/// The step of the model without its rows is that with them.
bool keeps_to_rows(const QuadraticModel& m, const VectorXd& d) {
    const Eigen::Index rows = m.constraints.size();
    return rows == m.num_inequalities && (d.array() >= m.lower.array()).all() && (d.array() <= m.upper.array()).all() &&
           (rows == 0 || ((m.constraints + m.jacobian * d).array() <= 0).all());
}

/// The last entry of w is `penalty` times the share of the violation that is left.
/// @param K empty where no variable is bounded. @param AK the rows times K
LeastDistance least_distance(const QuadraticModel& model, const MatrixXd& K, const MatrixXd& AK, const VectorXd& q) {
    constexpr double penalty = 1e5;
    const Eigen::Index n = q.size(), ineq = model.num_inequalities, rows = model.constraints.size();
    std::vector<Eigen::Index> upper, lower;
    for (Eigen::Index j = 0; j < n; ++j) {
        if (std::isfinite(model.upper[j])) upper.push_back(j);
        if (std::isfinite(model.lower[j])) lower.push_back(j);
    }
    const auto above = static_cast<Eigen::Index>(upper.size()), below = static_cast<Eigen::Index>(lower.size());
    LeastDistance p;
    p.q = VectorXd::Zero(n + 1);
    p.q.head(n) = q;
    p.inequality_rows = MatrixXd::Zero(above + below + ineq + 1, n + 1);
    if (above > 0) p.inequality_rows.topLeftCorner(above, n) = K(upper, Eigen::all);
    if (below > 0) p.inequality_rows.block(above, 0, below, n) = -K(lower, Eigen::all);
    p.inequality_limits.resize(above + below + ineq + 1);
    p.inequality_limits << model.upper(upper), -model.lower(lower), VectorXd::Zero(ineq + 1);
    for (Eigen::Index i = 0; i < ineq; ++i) {
        p.inequality_rows.row(above + below + i).head(n) = AK.row(i);
        p.inequality_rows(above + below + i, n) = -std::max(model.constraints[i], 0.0) / penalty;
        p.inequality_limits[above + below + i] = -model.constraints[i];
    }
    p.inequality_rows(above + below + ineq, n) = -1;  // the share is not negative
    p.equality_rows = MatrixXd::Zero(rows - ineq, n + 1);
    p.equality_limits = -model.constraints.tail(rows - ineq);
    p.equality_rows.leftCols(n) = AK.bottomRows(rows - ineq);
    p.equality_rows.col(n) = -model.constraints.tail(rows - ineq) / penalty;
    // Rows of length 1, because all are compared with one tolerance.
    const VectorXd row_length = p.inequality_rows.rowwise().norm();
    for (Eigen::Index i = 0; i < row_length.size(); ++i)
        if (row_length[i] > 0) p.inequality_rows.row(i) /= row_length[i], p.inequality_limits[i] /= row_length[i];
    for (Eigen::Index i = 0; i < p.equality_rows.rows(); ++i)
        if (const double norm = p.equality_rows.row(i).norm(); norm > 0)
            p.equality_rows.row(i) /= norm, p.equality_limits[i] /= norm;
    return p;
}

}  // namespace

void QuadraticModel::add_inequality(const VectorXd& slope, double value) {
    add_inequalities({VectorXd::Constant(1, value), slope.transpose()});
}

void QuadraticModel::add_inequalities(const StepLimits& limits) {
    const Eigen::Index more = limits.values.size(), rows = constraints.size(), first = num_inequalities;
    if (more == 0) return;
    VectorXd all(rows + more);
    all << constraints.head(first), limits.values, constraints.tail(rows - first);
    MatrixXd slopes(rows + more, gradient.size());
    slopes.topRows(first) = jacobian.topRows(first);
    slopes.middleRows(first, more) = limits.slopes;
    slopes.bottomRows(rows - first) = jacobian.bottomRows(rows - first);
    constraints = std::move(all);
    jacobian = std::move(slopes);
    num_inequalities += static_cast<int>(more);
}

void append(StepLimits& all, const StepLimits& more) {
    const Eigen::Index before = all.values.size(), rows = more.values.size();
    all.values.conservativeResize(before + rows);
    all.values.tail(rows) = more.values;
    all.slopes.conservativeResize(before + rows, more.slopes.cols());
    all.slopes.bottomRows(rows) = more.slopes;
}

VectorXd solve_model(const QuadraticModel& model) {
    const Eigen::Index n = model.gradient.size(), rows = model.constraints.size(), ineq = model.num_inequalities;
    // SLSQP's tolerances must not depend on the objective's unit.
    const double unit = model.hessian.trace() / static_cast<double>(n);
    if (!(unit > 0) || !std::isfinite(unit)) return {};
    const Eigen::LLT<MatrixXd> llt(model.hessian / unit);
    if (llt.info() != Eigen::Success) return {};
    // Most models of free shapes end here, at a third of n^3 operations.
    if (const VectorXd d = llt.solve(-model.gradient / unit); keeps_to_rows(model, d)) return d;
    // d = K w, K a multiple of L^-T with |q| = 1 (or less, see `min_step`).
    const bool is_bounded = model.lower.array().isFinite().any() || model.upper.array().isFinite().any();
    MatrixXd K;  // n^3 operations, for the rows of the bounds
    if (is_bounded) K = llt.matrixU().solve(MatrixXd::Identity(n, n));
    VectorXd q = is_bounded ? VectorXd(K.transpose() * model.gradient / unit)
                            : VectorXd(llt.matrixL().solve(model.gradient / unit));
    const bool is_violated =
        (model.constraints.head(ineq).array() > 0).any() || (model.constraints.tail(rows - ineq).array() != 0).any();
    double length = std::max(q.norm(), is_violated ? model.min_step : 0);
    if (length > 0)
        K *= length, q /= length;
    else
        length = 1;
    const MatrixXd AK = is_bounded ? MatrixXd(model.jacobian * K)
                                   : MatrixXd(length * llt.matrixL().solve(model.jacobian.transpose()).transpose());
    LeastDistance p = least_distance(model, K, AK, q);
    VectorXd w = nearest_point(p);
    if (w.size() == 0) w = solve_by_slsqp(p);
    if (w.size() == 0 || !w.allFinite()) return {};
    if (!is_bounded) return length * llt.matrixU().solve(w.head(n));
    return (K * w.head(n)).cwiseMax(model.lower).cwiseMin(model.upper);
}

ActiveSet active_set(const QuadraticModel& model, const VectorXd& d) {
    constexpr double hair = 1e-7;  // relative; SLSQP's tolerances are far below
    ActiveSet set;
    for (Eigen::Index i = 0; i < model.constraints.size(); ++i) {
        const double change = model.jacobian.row(i).dot(d);
        if (i >= model.num_inequalities ||
            model.constraints[i] + change >= -hair * (std::abs(model.constraints[i]) + std::abs(change)))
            set.rows.push_back(i);
    }
    for (Eigen::Index j = 0; j < d.size(); ++j) {
        const double range = model.upper[j] - model.lower[j], slack = std::isfinite(range) ? hair * range : 0;
        if (d[j] > model.lower[j] + slack && d[j] < model.upper[j] - slack) set.variables.push_back(j);
    }
    return set;
}

}  // namespace strake
