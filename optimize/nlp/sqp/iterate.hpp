#pragma once
#include "optimize/nlp/program/first_order.hpp"
#include "optimize/nlp/program/guard.hpp"

/// What the parts of sqp share: the program and the point that the search has reached. Internal.
namespace strake {

struct SqpIterate {
    explicit SqpIterate(Guard& g) : guard(g), program(g.program), x(g.best_x), at(g.best) {
        program.metric = metric_of(program);
    }

    double tolerance() const { return guard.options.constraint_tolerance; }
    bool is_met(const Evaluation& evaluation) const {
        return largest_violation(program, evaluation.constraints) <= tolerance();
    }
    /// A gradient costs an evaluation for each of many variables.
    bool has_expensive_gradient() const;
    Eigen::VectorXd clamped(const Eigen::VectorXd& point) const {
        return point.cwiseMax(program.lower).cwiseMin(program.upper);
    }

    Guard& guard;
    NonlinearProgram program;  ///< a copy whose metric is corrected where steps turn out longer than it says
    Eigen::VectorXd x;
    Evaluation at;  ///< at x, with gradients
};

}  // namespace strake
