#include "optimize/nlp/model/conflict.hpp"

#include "optimize/nlp/model/quadratic_model.hpp"
#include "optimize/nlp/program/first_order.hpp"

#include <algorithm>

namespace strake {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

class Linearized {
public:
    Linearized(const NonlinearProgram& p, const VectorXd& x, const Evaluation& s, double tolerance)
        : p_(p), x_(x), s_(s), tolerance_(tolerance) {}

    /// Values of the rows after the step of minimum common violation; empty: no step was found.
    VectorXd after_best_step(const std::vector<int>& rows) const {
        QuadraticModel m;
        const Eigen::Index n = x_.size();
        m.gradient = VectorXd::Zero(n);
        m.hessian = metric_of(p_);
        m.lower = p_.lower - x_;
        m.upper = p_.upper - x_;
        m.constraints = s_.constraints(rows);
        m.jacobian = s_.jacobian(rows, Eigen::all);
        m.num_inequalities =
            static_cast<int>(std::count_if(rows.begin(), rows.end(), [&](int i) { return i < p_.num_inequalities; }));
        const VectorXd values = m.constraints;
        const MatrixXd slopes = m.jacobian;
        m.add_inequalities(s_.limits);
        const VectorXd d = solve_model(m);
        return d.size() == 0 ? VectorXd() : VectorXd(values + slopes * d);
    }

    double violation(int row, double value) const {
        return row < p_.num_inequalities ? std::max(0.0, value) : std::abs(value);
    }

    bool can_be_met(const std::vector<int>& rows) const {
        if (rows.empty()) return true;
        const VectorXd after = after_best_step(rows);
        if (after.size() == 0) return true;  // nothing is known: no conflict is claimed
        double before_worst = 0, worst = 0;
        for (std::size_t k = 0; k < rows.size(); ++k) {
            before_worst = std::max(before_worst, violation(rows[k], s_.constraints[rows[k]]));
            worst = std::max(worst, violation(rows[k], after[static_cast<Eigen::Index>(k)]));
        }
        return worst <= std::max(tolerance_, 0.02 * before_worst);
    }

private:
    const NonlinearProgram& p_;
    const VectorXd& x_;
    const Evaluation& s_;
    double tolerance_;
};

}  // namespace

std::vector<int> conflicting_constraints(const NonlinearProgram& p, const VectorXd& x, const Evaluation& s,
                                         double tolerance) {
    std::vector<int> rows(static_cast<std::size_t>(s.constraints.size()));
    for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = static_cast<int>(i);
    const Linearized model(p, x, s, tolerance);
    if (model.can_be_met(rows)) return {};
    // Constraints with slack at the minimum violation are not its cause.
    const VectorXd after = model.after_best_step(rows);
    std::vector<int> active;
    for (const int i : rows)
        if (i >= p.num_inequalities || after[i] > -std::max(tolerance, 1e-6)) active.push_back(i);
    if (!model.can_be_met(active)) rows = active;
    // The least violated first: where there is a choice, the worst stay.
    std::vector<int> order = rows;
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
        return model.violation(a, s.constraints[a]) < model.violation(b, s.constraints[b]);
    });
    for (const int candidate : order) {
        std::vector<int> others;
        for (const int i : rows)
            if (i != candidate) others.push_back(i);
        if (!model.can_be_met(others)) rows = others;
    }
    return rows;
}

}  // namespace strake
