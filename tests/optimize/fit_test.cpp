#include "optimize/fit.hpp"

#include "core/error.hpp"
#include "optimize/design_space.hpp"
#include "problems.hpp"

#include <gtest/gtest.h>

using namespace strake;

namespace {

/// A problem whose target was made with the variables of `level`.
Problem recoverable(int level, std::vector<VariableKind> kinds = {VariableKind::load}, bool closest = false) {
    Problem problem = ellipsoid_problem(3, 3);
    problem.parameters.kinds = std::move(kinds);
    const auto rest = rest_facts(problem);
    DesignSpace space = design_space(rest, 1);
    for (int k = 1; k < level; ++k) space = refine(space, Eigen::VectorXd::Zero(space.size())).space;
    const Eigen::VectorXd x = 0.3 * random_vector(space.size(), 11);
    ShellOptions options = rest->setup.options;
    options.pin = space.pin;
    PrimoShell shell(problem.surface, options);
    const ShellDemand wanted = demand(space, x);
    EXPECT_EQ(shell.solve(wanted.loads, wanted.motions).status, SolveStatus::converged);
    const TriMesh target = with_vertices(problem.surface, shell.vertices());
    problem.quantities.push_back(closest ? target_shape_closest("match", problem.surface, target)
                                         : target_shape_same("match", problem.surface, target));
    problem.fit = {"match"};
    return problem;
}

double largest_distance(const Problem& problem, const RunResult& r) {
    return std::sqrt(r.objective) / box_diagonal(problem.surface);
}

}  // namespace

TEST(Fit, RecoversItsOwnTarget) {
    for (const auto& kinds : std::vector<std::vector<VariableKind>>{{VariableKind::load}, {VariableKind::strain}}) {
        const Problem problem = recoverable(3, kinds);
        const RunResult r = fit(problem);
        EXPECT_EQ(r.status, "converged") << r.reason;
        EXPECT_LT(largest_distance(problem, r), 1e-9);
        ASSERT_EQ(r.levels.size(), 3u);
        for (const LevelSummary& level : r.levels) {
            EXPECT_LT(level.objective_end, level.objective_start) << level.level;
            EXPECT_LT(level.inherited_shape_change, 1e-10);
        }
    }
}

TEST(Fit, RecoversATargetByClosestPoints) {
    const Problem problem = recoverable(2, {VariableKind::load}, true);
    const RunResult r = fit(problem);
    EXPECT_LT(largest_distance(problem, r), 1e-6) << r.reason;
}

TEST(Fit, NothingToDoIsRecoveredAtOnce) {
    Problem problem = ellipsoid_problem(2, 2);
    problem.quantities.push_back(target_shape_same("match", problem.surface, problem.surface));
    problem.fit = {"match"};
    const RunResult r = fit(problem);
    EXPECT_EQ(r.status, "converged") << r.reason;
    EXPECT_EQ(r.objective, 0);
}

TEST(Fit, LimitIsABudget) {
    Problem problem = recoverable(3);
    problem.optimize.max_evaluations = 4;
    const RunResult r = fit(problem);
    EXPECT_EQ(r.status, "budget");
    EXPECT_LE(r.evaluations, 4);
    EXPECT_LT(r.objective, r.objective_start);
}

TEST(Fit, BoundsHold) {
    Problem problem = recoverable(1);
    problem.parameters.max_displacement = 0.002;  // the target lies outside
    const RunResult r = fit(problem);
    EXPECT_TRUE((r.x.array() >= r.space.lower.array()).all());
    EXPECT_TRUE((r.x.array() <= r.space.upper.array()).all());
    EXPECT_LT(r.objective, r.objective_start);
}

TEST(Fit, WrongProblemsAreRefused) {
    Problem problem = recoverable(1);
    problem.fit = {"volume"};
    EXPECT_THROW(fit(problem), InvalidInput);
    problem.fit = {"mach"};
    EXPECT_THROW(fit(problem), InvalidInput);
    problem.fit = {};
    EXPECT_THROW(fit(problem), InvalidInput);
    problem.fit = {"match"};
    problem.parameters.kinds = {VariableKind::stiffness};
    EXPECT_THROW(fit(problem), InvalidInput);
}
