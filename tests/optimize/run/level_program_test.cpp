#include "optimize/run/level_program.hpp"

#include "optimize/nlp/program/first_order.hpp"
#include "problems.hpp"

#include <gtest/gtest.h>

using namespace strake;
using Eigen::VectorXd;

namespace {

/// Half of the variables at a bound, the others near one.
VectorXd design_at_bounds(const DesignSpace& space) {
    VectorXd x = 0.9 * space.upper;
    for (int j = 0; j < space.size(); j += 2) x[j] = j % 4 == 0 ? space.upper[j] : space.lower[j];
    return x;
}

}  // namespace

/// Bounds are in scaled variables: multipliers at the unscaled point take the wrong variables for those at bounds.
TEST(LevelProgram, MultipliersKnowWhichVariablesAreAtTheirBounds) {
    Problem problem = ellipsoid_problem(2, 2);
    problem.parameters.kinds = {VariableKind::load};
    problem.parameters.max_displacement = 0.02;
    problem.parameters.limits_variables = true;
    maximize_volume(problem, 1.0);
    RunEvents events;
    RunState state(problem, events, LevelProgram::differentiated_names(problem), nullptr);
    state.evaluator.take_over_values();
    LevelProgram level(state);
    VectorXd x = state.next_level({}, nullptr);
    x = design_at_bounds(state.space);
    const NonlinearProgram& program = level.enter(x);
    ASSERT_GT((level.weight().array() - 1).abs().maxCoeff(), 0.1) << "else both points are the same";
    const VectorXd y = x.cwiseProduct(level.weight());
    Evaluation evaluation = program.evaluate(y);
    ASSERT_EQ(evaluation.failure, "");
    program.differentiate(y, evaluation);
    const VectorXd right = multipliers(program, y, evaluation), wrong = multipliers(program, x, evaluation);
    ASSERT_GT(std::abs(right[0] - wrong[0]), 1e-6 * std::abs(right[0])) << "else nothing is shown";
    const VectorXd weights = level.lagrangian_weights();
    ASSERT_EQ(weights.size(), 2);
    EXPECT_EQ(weights[0], -1) << "maximized";
    const ConstraintRow& row = level.rows().rows[0];
    EXPECT_DOUBLE_EQ(weights[1], right[0] * row.sign / row.scale);
}
