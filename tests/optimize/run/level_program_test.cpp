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

/// Methods that know no limit search where one variable alone stays within: up to the limit, whatever the unit.
TEST(LevelProgram, NarrowBoundsReachTheMotionLimit) {
    Problem problem = ellipsoid_problem(2, 1);
    problem.parameters.kinds = {VariableKind::normal_load};
    problem.parameters.max_displacement = 0.02;
    problem.parameters.variable_scale = 0.002;
    maximize_volume(problem, 1.05);
    problem.optimize.method = Method::lbfgs;
    RunEvents events;
    RunState state(problem, events, LevelProgram::differentiated_names(problem), nullptr);
    state.evaluator.limit_motion();
    LevelProgram level(state);
    const VectorXd x = state.next_level({}, nullptr);
    const NonlinearProgram& program = level.enter(x);
    for (int j = 0; j < state.space.num_shape(); ++j) {
        EXPECT_NEAR(program.upper[j], 10 * level.weight()[j], 1e-9 * level.weight()[j]);
        EXPECT_NEAR(program.lower[j], -10 * level.weight()[j], 1e-9 * level.weight()[j]);
    }
}

/// Differences keep some way to the limit, on finer levels maybe more than the level above: its shape stays the start.
TEST(LevelProgram, TheInheritedStartStaysNextToTheLimit) {
    Problem problem = ellipsoid_problem(2, 1);
    problem.parameters.kinds = {VariableKind::normal_load};
    problem.parameters.max_displacement = 0.01;
    problem.parameters.variable_scale = 0.002;
    maximize_volume(problem, 1.05);
    problem.optimize.finite_differences = true;
    problem.optimize.difference_step = 1e-3;
    for (Quantity& quantity : problem.quantities) quantity.has_sensitivities = false;
    RunEvents events;
    RunState state(problem, events, LevelProgram::differentiated_names(problem), nullptr);
    state.evaluator.limit_motion();
    LevelProgram level(state);
    const VectorXd origin = state.next_level({}, nullptr);
    const VectorXd way = VectorXd::Ones(origin.size());
    double low = 0, high = 5;
    for (int k = 0; k < 40; ++k)
        (state.evaluator.is_beyond(0.5 * (low + high) * way, 1e-5) ? high : low) = 0.5 * (low + high);
    const NonlinearProgram& program = level.enter(low * way);
    const VectorXd beside = (1 - 1e-9) * program.start;
    EXPECT_EQ(program.within(program.start), program.start);
    EXPECT_NE(program.within(beside), beside) << "else nothing is shown";
}
