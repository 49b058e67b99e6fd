#include "optimize/nlp/model/verdict.hpp"

#include "optimize/nlp/program/first_order.hpp"

namespace strake {

using Eigen::VectorXd;

namespace {

bool at_bound(const NonlinearProgram& p, const VectorXd& x, Eigen::Index j, bool upper) {
    const double range = p.upper[j] - p.lower[j];
    const double slack = 1e-7 * (std::isfinite(range) ? range : 1.0);
    return upper ? x[j] >= p.upper[j] - slack : x[j] <= p.lower[j] + slack;
}

/// @pre the best point has gradients.
VectorXd lagrangian_gradient(const Guard& guard) {
    return strake::lagrangian_gradient(guard.program, guard.best_x, guard.best);
}

}  // namespace

int count_active_bounds(const Guard& guard) {
    const NonlinearProgram& p = guard.program;
    const bool has_gradient = guard.best.gradient.size() > 0;
    VectorXd slope;
    if (has_gradient) slope = lagrangian_gradient(guard);
    const double floor = has_gradient ? 1e-9 * guard.best.gradient.lpNorm<Eigen::Infinity>() : 0;
    int count = 0;
    for (const int j : guard.free)
        for (const bool upper : {false, true})
            count += at_bound(p, guard.best_x, j, upper) && (!has_gradient || (upper ? -slope[j] : slope[j]) > floor);
    return count;
}

}  // namespace strake
