#include "optimize/run/cheap_program.hpp"

#include "optimize/run/coarse_to_fine.hpp"
#include "optimize/run/level_program.hpp"
#include "problems.hpp"

#include <gtest/gtest.h>

/// Shape problems with a cheap model beside a program.
namespace strake {
namespace {

using Eigen::VectorXd;

/// A program without gradients: three times the area, and what the area does not see.
Quantity solver(int& calls) {
    Quantity quantity;
    quantity.names = {"flow.drag", "flow.lift"};
    quantity.program = "solver";
    quantity.has_sensitivities = false;
    quantity.evaluate = [&calls](const QuantityRequest& request) {
        ++calls;
        QuantityResult result;
        const Points& v = request.surface.vertices;
        const double area = triangle_areas(request.surface).sum();
        result.values = {3 * area + 0.05 * v.col(2).cwiseAbs2().sum() / double(v.rows()), 1 + area};
        return result;
    };
    return quantity;
}

struct WithSolver : testing::Test {
    int calls = 0;
    Problem problem = ellipsoid_problem(2, 1);
    RunEvents events;
    std::vector<std::string> notes;

    WithSolver() {
        problem.parameters.kinds = {VariableKind::load};
        problem.parameters.max_displacement = 0.03;
        problem.quantities.push_back(solver(calls));
        problem.objective = "flow.drag";
        Constraint volume;
        volume.quantity = "volume";
        volume.min = 1;
        volume.relative = true;
        problem.constraints = {volume};
        problem.optimize.finite_differences = true;
        problem.optimize.max_evaluations = 8;
        problem.cheap_models = {{"flow.drag", "area"}};
        events.note = [this](const std::string& words) { notes.push_back(words); };
    }
    /// A value of the two, with a formula of both.
    void add_formula() {
        Quantity formula;
        formula.names = {"ratio"};
        formula.combination = Combination{{"flow.drag", "volume"}, [](const VectorXd& at, VectorXd* gradient) {
                                              if (gradient) {
                                                  gradient->resize(2);
                                                  *gradient << 1 / at[1], -at[0] / (at[1] * at[1]);
                                              }
                                              return at[0] / at[1];
                                          }};
        formula.evaluate = [](const QuantityRequest&) { return QuantityResult{}; };
        formula.has_sensitivities = false;
        problem.quantities.push_back(formula);
        problem.objective = "ratio";
    }
};

TEST_F(WithSolver, TheCheapProgramHasTheGradientsOfItsValues) {
    for (const bool by_formula : {false, true}) {
        if (by_formula) add_formula();
        RunState state(problem, events, LevelProgram::differentiated_names(problem), nullptr);
        state.evaluator.limit_motion();
        LevelProgram level(state);
        const VectorXd x = state.next_level({}, nullptr);
        const NonlinearProgram& program = level.enter(x);
        ASSERT_TRUE(program.low_fidelity);
        EXPECT_EQ(program.low_fidelity->values[0], LowFidelityValue::approximate);
        EXPECT_EQ(program.low_fidelity->values[1], LowFidelityValue::same);
        const Evaluation start = program.evaluate(program.start);
        const VectorXd scale = program.low_fidelity->first_scale();
        EXPECT_GT(scale[0], by_formula ? 0.99 : 3) << "the solver has three times the area and more";
        EXPECT_LT(scale[0], by_formula ? 1.01 : 3.1);
        const NonlinearProgram& cheap = *program.low_fidelity->program;
        const VectorXd y = program.start + 0.1 * random_vector(program.start.size(), 3);
        const int before = calls;
        Evaluation at = cheap.evaluate(y);
        ASSERT_EQ(at.failure, "");
        cheap.differentiate(y, at);
        const VectorXd way = 0.1 * random_vector(program.start.size(), 4);
        for (int row = -1; row < 1; ++row) {
            const auto value = [&](const VectorXd& there) {
                const Evaluation s = cheap.evaluate(there);
                return row < 0 ? s.objective : s.constraints[row];
            };
            const VectorXd g = row < 0 ? at.gradient : VectorXd(at.jacobian.row(row).transpose());
            EXPECT_NEAR(taylor_order(value, y, g, way, 1e-1), 2, 0.15) << row << " " << by_formula;
            EXPECT_LT(taylor_order(value, y, 1.1 * g, way, 1e-1), 1.5) << row << " " << by_formula;
        }
        EXPECT_EQ(calls, before) << "the solver is not asked";
        EXPECT_EQ(start.constraints.size(), at.constraints.size());
    }
}

TEST_F(WithSolver, ARunAsksTheSolverSeldomAndSaysWhatTheModelIsWorth) {
    const RunResult with = optimize(problem, events);
    EXPECT_LE(calls, with.evaluations) << "what failed as a shape was not asked for";
    const std::string named = "cheap model (area for flow.drag): rho ";
    ASSERT_EQ(with.cheap_model.find(named), 0u) << with.cheap_model;
    EXPECT_NEAR(std::stod(with.cheap_model.substr(named.size())), 3, 0.1);
    EXPECT_NE(with.reason.find("cheap model (area for flow.drag)"), std::string::npos) << with.reason;
    Problem without = problem;
    without.cheap_models.clear();
    without.optimize.max_evaluations = 40;
    const RunResult plain = optimize(without, {});
    EXPECT_TRUE(plain.cheap_model.empty());
    const double gain = plain.objective_start - plain.objective;
    ASSERT_GT(gain, 0);
    EXPECT_GT(with.objective_start - with.objective, 0.95 * gain) << "in a fifth of the evaluations";
}

TEST_F(WithSolver, ValuesWithoutACheapModelAreUnknown) {
    Constraint lift;
    lift.quantity = "flow.lift";
    lift.max = 10;
    problem.constraints.push_back(lift);
    RunState state(problem, events, LevelProgram::differentiated_names(problem), nullptr);
    state.evaluator.limit_motion();
    LevelProgram level(state);
    const NonlinearProgram& program = level.enter(state.next_level({}, nullptr));
    ASSERT_EQ(program.low_fidelity->values.size(), 3u);
    EXPECT_EQ(program.low_fidelity->values[2], LowFidelityValue::none);
    const RunResult result = optimize(problem, events);
    EXPECT_LT(result.objective, result.objective_start);
    EXPECT_TRUE(std::any_of(notes.begin(), notes.end(), [](const std::string& words) {
        return words.find("nothing is known of constraint 1 beside its value") != std::string::npos;
    }));
}

}  // namespace
}  // namespace strake
