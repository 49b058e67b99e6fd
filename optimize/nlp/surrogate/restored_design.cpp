#include "optimize/nlp/surrogate/restored_design.hpp"

#include "optimize/nlp/model/quadratic_model.hpp"

#include <cmath>

namespace strake {

using Eigen::VectorXd;

namespace {

constexpr double beyond_limits = 1.1;  ///< times what an inequality is missed by: the design is then within
constexpr int limit_rounds = 3;        ///< that learn more of the limit of motion

QuadraticModel way_back(const NonlinearProgram& program, const std::vector<int>& free, const VectorXd& x,
                        const Evaluation& at) {
    QuadraticModel model;
    model.hessian = Eigen::MatrixXd(metric_of(program)(free, free));
    model.gradient = VectorXd::Zero(model.hessian.rows());
    model.lower = (program.lower - x)(free);
    model.upper = (program.upper - x)(free);
    model.jacobian = at.jacobian(Eigen::all, free);
    model.num_inequalities = program.num_inequalities;
    model.constraints = at.constraints;
    for (Eigen::Index i = 0; i < program.num_inequalities; ++i)
        if (model.constraints[i] > 0) model.constraints[i] *= beyond_limits;
    return model;
}

}  // namespace

VectorXd restored(const NonlinearProgram& program, const std::vector<int>& free, const VectorXd& x,
                  const Evaluation& at, double radius, AllowedDesigns& allowed) {
    QuadraticModel model = way_back(program, free, x, at);
    VectorXd there = x;
    for (int round = 0; round <= limit_rounds; ++round) {
        VectorXd step = solve_model(model);
        if (step.size() == 0 || !step.allFinite()) return x;
        const double length = std::sqrt(step.dot(model.hessian * step));
        if (length > radius) step *= radius / length;
        there = x;
        there(free) += step;
        there = there.cwiseMax(program.lower).cwiseMin(program.upper);
        StepLimits limits;
        if (allowed.has_turns() || !allowed.limit_step_to(there, limits)) break;
        model.add_inequalities({limits.values, limits.slopes(Eigen::all, free)});
    }
    return allowed.knows_slopes() && !allowed.has_turns() ? allowed.nearest(there) : there;
}

}  // namespace strake
