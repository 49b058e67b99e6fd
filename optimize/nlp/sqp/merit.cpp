#include "optimize/nlp/sqp/merit.hpp"

#include "optimize/nlp/sqp/trust_region.hpp"

namespace strake {

using Eigen::MatrixXd;
using Eigen::VectorXd;

double Merit::of(const Evaluation& evaluation) const {
    return evaluation.objective + now_.guard.penalty * total_violation(now_.program, tightened(evaluation.constraints));
}

VectorXd Merit::tightened(VectorXd constraints) const {
    constraints.head(now_.program.num_inequalities).array() += trust_region.tightening * now_.tolerance();
    return constraints;
}

double Merit::violation_decrease(const VectorXd& d) const {
    return total_violation(now_.program, tightened(now_.at.constraints)) -
           total_violation(now_.program, tightened(now_.at.constraints + now_.at.jacobian * d));
}

double Merit::expected_decrease(double objective, double violation) const {
    return objective + now_.guard.penalty * std::max(violation, 0.0);
}

double Merit::expected_decrease(const MatrixXd& hessian, const VectorXd& d) const {
    return expected_decrease(model_decrease(now_, hessian, d), violation_decrease(d));
}

void Merit::raise_penalty(double minimum) { now_.guard.penalty = std::max(now_.guard.penalty, minimum); }

void Merit::adapt_penalty(double needed, bool is_feasible) {
    raise_penalty(needed);
    if (needed > 0 && is_feasible) now_.guard.penalty = 0.5 * (now_.guard.penalty + needed);
}

double model_decrease(const SqpIterate& now, const MatrixXd& hessian, const VectorXd& d) {
    return -(now.at.gradient.dot(d) + 0.5 * d.dot(hessian * d));
}

}  // namespace strake
