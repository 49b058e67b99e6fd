#include "optimize/run/fit.hpp"

#include "core/error.hpp"
#include "objectives/fit/measured_points.hpp"
#include "objectives/geometry/section_area.hpp"
#include "objectives/geometry/thickness.hpp"
#include "optimize/space/design_space.hpp"
#include "problems.hpp"

#include <gtest/gtest.h>

using namespace strake;

namespace {

/// A problem whose target was made with the variables of `level`.
Problem recoverable(int level, std::vector<VariableKind> kinds = {VariableKind::load}, bool closest = false,
                    int subdivisions = 3) {
    Problem problem = ellipsoid_problem(subdivisions, 3);
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

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// What `spoil` makes of the residuals of "match" from the evaluation `from` on.
Problem spoiled(int from, const std::function<void(Residuals&)>& spoil) {
    Problem problem = recoverable(2, {VariableKind::load}, false, 2);
    const ResidualFunction good = problem.quantities.back().residuals;
    problem.quantities.back().residuals = [=, count = std::make_shared<int>(0)](const TriMesh& s, const TriMesh& m) {
        Residuals r = good(s, m);
        if (++*count >= from) spoil(r);
        return r;
    };
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
    EXPECT_EQ(r.evaluations, 1);
    EXPECT_TRUE(has(r.reason, "recovered")) << r.reason;
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
    problem.parameters.limits_variables = true;
    const RunResult r = fit(problem);
    EXPECT_TRUE((r.x.array() >= r.space.lower.array()).all());
    EXPECT_TRUE((r.x.array() <= r.space.upper.array()).all());
    EXPECT_LT(r.objective, r.objective_start);
}

TEST(Fit, EachLevelTellsWhatItExplainsAndReaches) {
    const Problem problem = recoverable(3);
    const RunResult r = fit(problem);
    for (const LevelSummary& level : r.levels) {
        EXPECT_NEAR(level.explained, 1 - std::sqrt(level.objective_end / level.objective_start), 1e-12);
        EXPECT_TRUE(has(level.stop, "explains ")) << level.stop;
        EXPECT_EQ(has(level.stop, text("of the difference that level ", level.level - 1, " left")), level.level > 1);
    }
    EXPECT_GT(r.levels.back().explained, 0.999);
    EXPECT_TRUE(r.levels.back().converged);
    EXPECT_TRUE(has(r.reason, "rms distance by level: 1 reaches ") && has(r.reason, ", 3 reaches ")) << r.reason;
}

TEST(Fit, WhatTheVariablesCannotMakeIsToldAsNoProgressExpected) {
    Problem problem = ellipsoid_problem(2, 3);
    TriMesh target = problem.surface;  // the fixed end has moved: nothing reaches that
    for (const int t : problem.fixed)
        for (int k = 0; k < 3; ++k)
            target.vertices.row(problem.surface.triangles(t, k)) =
                problem.surface.vertices.row(problem.surface.triangles(t, k)) + Eigen::RowVector3d(-0.05, 0, 0);
    problem.quantities.push_back(target_shape_same("match", problem.surface, target));
    problem.fit = {"match"};
    const RunResult r = fit(problem);
    EXPECT_EQ(r.status, "converged") << r.reason;
    EXPECT_TRUE(has(r.reason, "no progress is expected of finer levels")) << r.reason;
}

TEST(Fit, ActiveBoundsAreCounted) {
    Problem problem = recoverable(1);
    problem.parameters.max_displacement = 0.002;
    problem.parameters.limits_variables = true;
    const RunResult r = fit(problem);
    EXPECT_TRUE(has(r.reason, "bounds active on ") && has(r.reason, "max_displacement")) << r.reason;
}

TEST(Fit, FailuresOfQuantitiesEndInAVerdict) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const std::pair<std::function<void(Residuals&)>, const char*> cases[] = {
        {[=](Residuals& r) { r.r[5] = nan; }, "match: residual 5 is not finite"},
        {[=](Residuals& r) { r.dr_dv.coeffRef(4, 4) = nan; }, "the derivative of residual 4 is not finite"},
        {[](Residuals&) { throw std::runtime_error("the probe is lost"); }, "the probe is lost"},
        {[](Residuals& r) { r.r.conservativeResize(3); }, "do not fit together"}};
    for (const auto& [spoil, words] : cases)
        for (const int from : {1, 3}) {
            testing::internal::CaptureStderr();
            const RunResult r = fit(spoiled(from, spoil));
            EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << words;
            EXPECT_EQ(r.status, "evaluation_failed") << words;
            EXPECT_TRUE(has(r.reason, words) && has(r.reason, text("evaluation ", from))) << r.reason;
            EXPECT_EQ(r.best_evaluation > 0, from > 1) << r.reason;
        }
    Problem problem = recoverable(2, {VariableKind::load}, false, 2);
    problem.quantities[0].evaluate = [](const QuantityRequest& request) -> QuantityResult {
        if (request.evaluation == 3) throw std::runtime_error("the probe is lost");
        return {{1}, {}, {}};
    };
    const RunResult r = fit(problem);
    EXPECT_EQ(r.status, "evaluation_failed");
    EXPECT_TRUE(has(r.reason, "evaluation 3: ") && has(r.reason, "the probe is lost")) << r.reason;
    EXPECT_GT(r.best_evaluation, 0);
}

TEST(Fit, AQuantityMayCallItsFailureAStepTooFar) {
    for (const bool shortens : {true, false})
        for (const bool in_residuals : {true, false}) {
            Problem problem = in_residuals ? spoiled(3,
                                                     [count = std::make_shared<int>(0)](Residuals&) {
                                                         if (++*count == 1)
                                                             throw InvalidInput("the line misses the body");
                                                     })
                                           : recoverable(2, {VariableKind::load}, false, 2);
            Quantity& match = problem.quantities.back();
            match.failing_shortens_step = shortens;
            if (!in_residuals)
                match.evaluate = [good = match.evaluate](const QuantityRequest& request) -> QuantityResult {
                    if (request.evaluation == 3) return {{}, {}, Failure{"undefined", "the line misses the body"}};
                    return good(request);
                };
            const RunResult r = fit(problem);
            EXPECT_EQ(r.status, shortens ? "converged" : "evaluation_failed") << r.reason;
            EXPECT_EQ(largest_distance(problem, r) < 1e-8, shortens) << r.reason;
        }
}

TEST(Fit, ARobustLossIgnoresOutliers) {
    for (const Loss loss : {Loss::none, Loss::huber, Loss::cauchy, Loss::soft_l1}) {
        Problem problem = recoverable(2, {VariableKind::load}, false, 2);
        problem.tree.levels.resize(3);
        const RunResult clean = fit(problem);
        // Every 40th vertex of the target is far off.
        const ResidualFunction good = problem.quantities.back().residuals;
        problem.quantities.back().residuals = [good](const TriMesh& s, const TriMesh& m) {
            Residuals r = good(s, m);
            for (int k = 0; k < r.weight.size(); k += 40) r.r[3 * k + 2] -= 0.3 * std::sqrt(r.weight[k]);
            return r;
        };
        problem.fitting.loss = loss;
        problem.fitting.loss_scale = 0.0005;
        const RunResult r = fit(problem);
        const double off = (r.vertices - clean.vertices).rowwise().norm().maxCoeff() / box_diagonal(problem.surface);
        if (loss == Loss::none)
            EXPECT_GT(off, 3e-3);  // the test can fail
        else
            EXPECT_LT(off, loss == Loss::cauchy ? 1e-4 : 1e-3) << r.reason;
        EXPECT_LT(r.objective, r.objective_start);
    }
}

TEST(Fit, KeptMatchesLeadToTheSameShape) {
    Problem problem = recoverable(2, {VariableKind::load}, true, 2);
    problem.fitting.icp_iterations = 5;
    const RunResult r = fit(problem);
    EXPECT_LT(largest_distance(problem, r), 1e-6) << r.reason;
}

TEST(Fit, GivenQuantitiesAreReached) {
    Problem problem = ellipsoid_problem(2, 2);
    const Problem made = recoverable(2, {VariableKind::load}, false, 2);
    const RunResult target = fit(made);
    std::vector<MeasuredPoint> scan;
    for (int v = 0; v < made.surface.num_vertices(); v += 3) scan.push_back({target.vertices.row(v), 1});
    const TriMesh wanted = with_vertices(made.surface, target.vertices);
    const double area = section_area("s", wanted, {{1, 0, 0}, 0.2, {}}).evaluate({wanted, false, 1, 0, {}}).values[0];
    std::vector<ThicknessLine> lines{{{0.3, 0, 0}, {0, 0, 1}, {}}, {{0.1, 0.1, 0}, {0, 0, 1}, {}}};
    const auto thick = thickness("t", wanted, lines, ThicknessValues::each).evaluate({wanted, false, 1, 0, {}}).values;
    for (std::size_t i = 0; i < lines.size(); ++i) lines[i].target = thick[i];
    problem.quantities = {measured_points("scan", problem.surface, scan),
                          section_area("rib", problem.surface, {{1, 0, 0}, 0.2, area}),
                          thickness("spars", problem.surface, lines, ThicknessValues::each)};
    for (const std::vector<std::string>& names :
         {std::vector<std::string>{"scan"}, {"rib"}, {"spars"}, {"scan", "rib", "spars"}}) {
        problem.fit = names;
        const RunResult r = fit(problem);
        EXPECT_LT(largest_distance(problem, r), 1e-5) << names[0] << ": " << r.reason;
        EXPECT_GT(std::sqrt(r.objective_start), 1e-4) << names[0];
    }
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
    problem.fitting = {Loss::huber, 0, 0};
    EXPECT_THROW(fit(problem), InvalidInput);
    problem.fitting = {Loss::none, 0, -1};
    EXPECT_THROW(fit(problem), InvalidInput);
    problem.fitting = {};
    problem.fit = {"match"};
    problem.parameters.kinds = {VariableKind::stiffness};
    EXPECT_THROW(fit(problem), InvalidInput);
}
