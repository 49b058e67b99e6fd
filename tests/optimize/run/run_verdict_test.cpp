#include "optimize/run/run_verdict.hpp"

#include "core/error.hpp"
#include "optimize/run/coarse_to_fine.hpp"
#include "problems.hpp"

#include <gtest/gtest.h>

using namespace strake;

namespace {

Problem volume_problem() {
    Problem problem = ellipsoid_problem(2, 1);
    problem.parameters.kinds = {VariableKind::normal_load};
    problem.objective = "volume";
    problem.maximize = true;
    problem.optimize.max_evaluations = 40;
    return problem;
}

/// A quantity whose values or sensitivities are changed on the way out.
void tamper(Problem& problem, int quantity, const std::function<void(QuantityResult&)>& how) {
    const auto honest = problem.quantities[quantity].evaluate;
    problem.quantities[quantity].evaluate = [=](const QuantityRequest& request) {
        QuantityResult result = honest(request);
        how(result);
        return result;
    };
}

bool says(const std::string& words, const std::string& part) { return words.find(part) != std::string::npos; }

}  // namespace

TEST(RunVerdict, TwoConstraintsThatExcludeEachOtherAreNamed) {
    Problem problem = volume_problem();
    problem.constraints = {{"volume", 1.02, {}, {}, true}, {"area", {}, 0.98, {}, true}};
    problem.optimize.max_evaluations = 60;  // 46 are needed
    const RunResult r = optimize(problem);
    EXPECT_EQ(r.status, "conflict") << r.reason;
    EXPECT_EQ(r.conflict, (std::vector<std::string>{"volume", "area"}));
    EXPECT_TRUE(says(r.reason, "volume >= ") && says(r.reason, "area <= ")) << r.reason;
    EXPECT_FALSE(r.is_done());
}

TEST(RunVerdict, AConstraintOutOfReachIsNamedOnceAndByItsName) {
    Problem problem = volume_problem();
    problem.constraints = {{"volume", 3, {}, {}, true}};
    problem.optimize.max_evaluations = 60;
    const RunResult r = optimize(problem);
    EXPECT_EQ(r.status, "infeasible") << r.reason;
    EXPECT_TRUE(says(r.reason, "no design within the bounds meets volume >= ")) << r.reason;
    EXPECT_FALSE(says(r.reason, "constraint 0")) << r.reason;
    EXPECT_EQ(r.reason.find("the least violation is"), r.reason.rfind("the least violation is")) << r.reason;
}

TEST(RunVerdict, AGradientThatContradictsTheValuesIsNamed) {
    Problem problem = volume_problem();
    tamper(problem, 0, [](QuantityResult& result) {
        for (Points& dJ : result.dJ_dv) dJ = -dJ;
    });
    const RunResult r = optimize(problem);
    EXPECT_EQ(r.status, "gradient_inconsistent") << r.reason;
    EXPECT_TRUE(says(r.reason, "the gradient of volume, the objective: at the best design of level 1 (evaluation "))
        << r.reason;
    EXPECT_TRUE(says(r.reason, " where its gradient says ")) << r.reason;
    EXPECT_TRUE(says(r.reason, "`strake gradient-check CASE`")) << r.reason;
    EXPECT_FALSE(r.is_done());
}

TEST(RunVerdict, AGradientThatTheValuesFollowedIsNotSuspected) {
    const RunResult run = optimize(volume_problem());
    MinimizeResult level;
    level.stop = MinimizeStop::roundoff;
    level.reason = "no step, however short, gains what the gradient predicts";
    const ConstraintRows rows;
    for (const bool is_confirmed : {false, true}) {
        level.gradient_confirmed = is_confirmed;
        RunResult r = run;
        const RunEnd end{.level = level, .rows = rows, .is_feasible = true, .objective = "volume"};
        conclude_run(r, end);
        EXPECT_EQ(r.status, "roundoff") << r.reason;
        EXPECT_EQ(says(r.reason, "wrong gradient"), !is_confirmed) << r.reason;
        EXPECT_TRUE(says(r.reason, "noise")) << r.reason;
    }
}

TEST(RunVerdict, AFlatObjectiveIsNotJustConverged) {
    Problem problem = volume_problem();
    tamper(problem, 0, [](QuantityResult& result) {
        result.values[0] = 1;
        for (Points& dJ : result.dJ_dv) dJ.setZero();
    });
    const RunResult r = optimize(problem);
    EXPECT_TRUE(says(r.reason, "did not change with any variable")) << r.reason;
}

TEST(RunVerdict, BoundsThatHoldTheRunAreCounted) {
    Problem problem = volume_problem();
    problem.parameters.max_displacement = 0.002;
    RunResult r = optimize(problem);
    EXPECT_EQ(r.status, "converged") << r.reason;
    EXPECT_TRUE(says(r.reason, "the motion limit (0.2 % of the diagonal) is active on ")) << r.reason;
    EXPECT_FALSE(says(r.reason, "bounds active")) << r.reason;
    problem.parameters.limits_variables = true;  // as before there was a limit on shapes
    r = optimize(problem);
    EXPECT_EQ(r.status, "converged") << r.reason;
    EXPECT_TRUE(says(r.reason, "bounds active on 2 of 2 variables of level 1")) << r.reason;
}

/// A quantity that fails from some volume on: no advice to mend a surface that is sound.
TEST(RunVerdict, WhereAQuantityFailsTheSurfaceIsNotBlamed) {
    Problem problem = volume_problem();
    double first = 0;
    const auto honest = problem.quantities[0].evaluate;
    problem.quantities[0].evaluate = [&, honest](const QuantityRequest& request) {
        QuantityResult result = honest(request);
        if (first == 0) first = result.values[0];
        if (result.values[0] < 1.01 * first) return result;
        return QuantityResult{{}, {}, Failure{"exit", "the flow separates"}};
    };
    problem.quantities[0].failing_shortens_step = true;
    problem.optimize.max_evaluations = 200;
    const RunResult r = optimize(problem);
    EXPECT_EQ(r.status, "no_valid_step") << r.reason;
    EXPECT_TRUE(says(r.reason, "the flow separates")) << r.reason;
    EXPECT_TRUE(says(r.reason, "a quantity has no value")) << r.reason;
    EXPECT_FALSE(says(r.reason, "buckles")) << r.reason;
}

TEST(RunVerdict, AThrowingQuantityEndsTheRunWithItsWords) {
    Problem problem = volume_problem();
    int calls = 0;
    const auto honest = problem.quantities[1].evaluate;
    problem.quantities[1].evaluate = [&](const QuantityRequest& request) {
        if (++calls == 3) throw std::runtime_error("the licence server is gone");
        return honest(request);
    };
    const RunResult r = optimize(problem);
    EXPECT_EQ(r.status, "evaluation_failed");
    EXPECT_TRUE(says(r.reason, "the licence server is gone")) << r.reason;
    EXPECT_EQ(r.evaluations, 3);
    EXPECT_GT(r.best_evaluation, 0);
}

TEST(RunVerdict, AFailureThatShortensTheStepDoesNotEndTheRun) {
    Problem problem = volume_problem();
    const RunResult undisturbed = optimize(problem);
    problem.quantities[1].failing_shortens_step = true;
    int calls = 0;
    const auto honest = problem.quantities[1].evaluate;
    problem.quantities[1].evaluate = [&](const QuantityRequest& request) -> QuantityResult {
        if (++calls % 3 == 0) return {{}, {}, Failure{"undefined", "no crossing"}};
        return honest(request);
    };
    const RunResult r = optimize(problem);
    EXPECT_TRUE(r.is_done()) << r.reason;
    EXPECT_GT(r.objective - r.objective_start, 0.9 * (undisturbed.objective - undisturbed.objective_start));
}

TEST(RunVerdict, DifferencesReplaceMissingGradients) {
    Problem problem = volume_problem();
    const RunResult exact = optimize(problem);
    problem.quantities[0].has_sensitivities = false;
    tamper(problem, 0, [](QuantityResult& result) { result.dJ_dv.clear(); });
    EXPECT_THROW(optimize(problem), InvalidInput);
    problem.optimize.finite_differences = true;
    problem.optimize.max_evaluations = 200;
    const RunResult r = optimize(problem);
    EXPECT_TRUE(r.is_done()) << r.reason;
    EXPECT_NEAR(r.objective, exact.objective, 1e-3 * (exact.objective - exact.objective_start));
}

TEST(RunVerdict, AnInfeasibleStartReachesAFeasibleDesign) {
    Problem problem = volume_problem();
    problem.constraints = {{"area", {}, 0.98, {}, true}};
    const RunResult r = optimize(problem);
    EXPECT_TRUE(r.is_done()) << r.reason;
    EXPECT_LE(r.values[1], (0.98 + 1e-6) * r.values_start[1]);
    EXPECT_TRUE(r.conflict.empty());
}

TEST(RunVerdict, ABudgetThatIsTooSmallIsNamed) {
    Problem problem = volume_problem();
    problem.optimize.max_evaluations = 3;
    const RunResult r = optimize(problem);
    EXPECT_EQ(r.status, "budget");
    EXPECT_TRUE(says(r.reason, "limit of evaluations is reached (3)")) << r.reason;
    EXPECT_TRUE(says(r.reason, "raise optimize.budget")) << r.reason;
}

/// What a level or a run says of its evaluations is what was evaluated.
TEST(RunVerdict, CountsAgreeWithWhatWasEvaluated) {
    int ended_at_limit = 0, ended_before = 0;
    for (const int budget : {6, 9, 12, 13, 24}) {
        SCOPED_TRACE(budget);
        Problem problem = ellipsoid_problem(2, 2);
        problem.parameters.kinds = {VariableKind::normal_load};
        problem.objective = "volume";
        problem.maximize = true;
        problem.constraints = {{"area", {}, 1.01, {}, true}};
        problem.optimize.max_evaluations = budget;
        const RunResult r = optimize(problem);
        int sum = 0;
        for (const LevelSummary& level : r.levels) {
            sum += level.evaluations;
            const std::string start =
                "the limit of evaluations of level " + std::to_string(level.level) + " is reached (";
            if (!says(level.stop, "limit of evaluations")) continue;
            ++ended_at_limit;
            ASSERT_EQ(level.stop.rfind(start, 0), 0u) << level.stop;
            EXPECT_EQ(std::stoi(level.stop.substr(start.size())), level.evaluations) << level.stop;
        }
        EXPECT_EQ(sum, r.evaluations);
        EXPECT_LE(r.evaluations, budget);
        if (r.status != "budget" || !says(r.reason, "limit of evaluations")) continue;
        ended_before += r.evaluations < budget;
        EXPECT_TRUE(says(r.reason, r.evaluations < budget
                                       ? "(" + std::to_string(r.evaluations) + " of " + std::to_string(budget) +
                                             "; the rest is kept for the way back onto the constraints)"
                                       : "(" + std::to_string(budget) + ")"))
            << r.reason;
    }
    EXPECT_GT(ended_at_limit, 0) << "else nothing is shown";
    EXPECT_GT(ended_before, 0) << "else nothing is shown";
}

/// Failures are counted of the level that says so.
TEST(RunVerdict, FailuresAreThoseOfTheLevel) {
    Problem problem = volume_problem();
    problem.tree = octants(problem.surface, 2);
    int calls = 0;
    problem.quantities[0].failing_shortens_step = true;
    problem.quantities[0].evaluate = [&, honest = problem.quantities[0].evaluate](const QuantityRequest& request) {
        if (++calls % 4 == 0) return QuantityResult{{}, {}, Failure{"exit", "3"}};
        return honest(request);
    };
    const RunResult r = optimize(problem);
    int told = 0;
    for (const LevelSummary& level : r.levels) {
        const auto at = level.stop.find(" evaluations of level " + std::to_string(level.level) + " failed");
        if (!says(level.stop, "failed;") && at == std::string::npos) continue;
        if (at == std::string::npos) continue;
        ++told;
        const auto before = level.stop.rfind(' ', at - 1);
        EXPECT_EQ(std::stoi(level.stop.substr(before + 1)), level.evaluations) << level.stop;
    }
    EXPECT_GT(told, 0) << r.reason;
}

/// Budgets of each size from few to enough: what is printed as made was made, level by level and in all.
TEST(RunVerdict, CountsAgreeEverywhere) {
    bool has_rest = false;
    for (int budget = 3; budget <= 14; ++budget) {
        Problem problem = volume_problem();
        problem.constraints = {{"area", {}, 0.98, {}, true}};  // the start violates it: the last steps are kept for it
        problem.optimize.max_evaluations = budget;
        int recorded = 0;
        RunEvents events;
        events.evaluation = [&](const EvaluationRecord& record) { recorded = record.evaluation; };
        const RunResult r = optimize(problem, events);
        EXPECT_EQ(r.evaluations, recorded);
        int sum = 0;
        for (const LevelSummary& level : r.levels) {
            sum += level.evaluations;
            if (says(level.stop, "limit of evaluations")) {
                EXPECT_TRUE(says(level.stop, text("reached (", level.evaluations)))
                    << level.stop << ", " << level.evaluations;
            }
        }
        EXPECT_EQ(sum, r.evaluations);
        if (r.status != "budget" || !says(r.reason, "limit of evaluations")) continue;
        has_rest = has_rest || r.evaluations < budget;
        const std::string count =
            r.evaluations < budget ? text("(", r.evaluations, " of ", budget) : text("(", budget, ")");
        EXPECT_TRUE(says(r.reason, count)) << r.reason;
    }
    EXPECT_TRUE(has_rest) << "no budget of these leaves a rest: the test has lost its case";
}

TEST(RunVerdict, ATrueOptimumIsConvergedWithoutReservations) {
    Problem problem = volume_problem();
    problem.constraints = {{"area", {}, 1.01, {}, true}};
    const RunResult r = optimize(problem);
    EXPECT_EQ(r.status, "converged") << r.reason;
    for (const char* reservation : {"bounds active", "did not change", "conflict", "inconsistent", "failed"})
        EXPECT_FALSE(says(r.reason, reservation)) << r.reason;
    // And it is one: another start and another method end there.
    problem.optimize.method = Method::mma;
    problem.optimize.max_evaluations = 150;
    EXPECT_NEAR(optimize(problem).objective, r.objective, 1e-4 * (r.objective - r.objective_start));
}

/// An inequality and an equality, met by SQP itself, by MMA with an augmented Lagrangian for the equality, and by
/// L-BFGS with one for both.
TEST(RunVerdict, ConstraintsAreMetToAMillionthByEveryWay) {
    for (const Method method : {Method::sqp, Method::mma, Method::lbfgs}) {
        Problem problem = ellipsoid_problem(2, 2);
        problem.quantities.push_back(
            target_shape_same("moved", problem.surface, with_vertices(problem.surface, problem.surface.vertices)));
        problem.parameters.kinds = {VariableKind::normal_load};
        problem.objective = "moved";
        problem.constraints = {{"volume", 1.03, {}, {}, true}, {"area", {}, {}, 1.01, true}};
        problem.optimize.method = method;
        problem.optimize.max_evaluations = 300;
        const RunResult r = optimize(problem);
        SCOPED_TRACE(r.reason);
        EXPECT_TRUE(r.is_done());
        EXPECT_LE(r.max_violation, 1e-6);
        EXPECT_GE(r.values[0], (1.03 - 1.1e-6) * r.values_start[0]);
        EXPECT_NEAR(r.values[1], 1.01 * r.values_start[1], 1.1e-6 * 1.01 * r.values_start[1]);
        if (std::getenv("STRAKE_TELL"))
            std::cout << "TELL " << r.status << " " << r.objective << " violation " << r.max_violation << " after "
                      << r.evaluations << "\n";
    }
}
