#include "optimize/run/coarse_to_fine.hpp"

#include "core/error.hpp"
#include "objectives/external/external.hpp"
#include "optimize/evaluate/evaluation.hpp"
#include "problems.hpp"

#include <gtest/gtest.h>
#include <unistd.h>
#include <algorithm>
#include <cstdlib>
#include <filesystem>

using namespace strake;

namespace {

Problem more_volume() {
    Problem problem = ellipsoid_problem(3, 3);
    maximize_volume(problem);
    return problem;
}

}  // namespace

TEST(CoarseToFine, GainsVolumeUnderAnAreaLimit) {
    std::vector<EvaluationRecord> history;
    int accepted = 0;
    RunEvents events;
    events.evaluation = [&](const EvaluationRecord& r) { history.push_back(r); };
    events.accepted = [&](const AcceptedDesign& d) {
        ++accepted;
        EXPECT_EQ(d.vertices.rows(), d.dJ_dv.rows());
    };
    const Problem problem = more_volume();
    // What a level starts from, solved anew from rest: the values that it takes over must be its own.
    const auto rest = rest_facts(problem);
    events.level = [&](const LevelStart& level) {
        if (history.empty()) return;
        ShapeEvaluator evaluator(problem, rest, {});
        evaluator.enter(level.space);
        const ShapeEvaluation anew = evaluator.evaluate(level.x, 1);
        double best = 0;
        for (const EvaluationRecord& record : history)
            if (record.accepted) best = record.objective;
        EXPECT_NEAR(anew.values[0], best, 1e-8 * best);  // a step below 1e-9 of the diagonal is left by either solve
    };
    const RunResult r = optimize(problem, events);
    EXPECT_TRUE(r.is_done()) << r.status << ": " << r.reason;
    EXPECT_GT(r.objective, 1.03 * r.objective_start);
    EXPECT_LE(r.values[1], (1.02 + 1.1e-6) * r.values_start[1]);
    ASSERT_EQ(r.levels.size(), 3u);
    for (std::size_t k = 1; k < 3; ++k) {
        EXPECT_LT(r.levels[k].inherited_shape_change, 1e-10);
        EXPECT_GE(r.levels[k].objective_end, r.levels[k].objective_start);
    }
    EXPECT_EQ(static_cast<int>(history.size()), r.evaluations);
    double best = 0;
    for (const EvaluationRecord& record : history)
        if (record.status == "ok" && record.max_violation <= 1e-6) best = std::max(best, record.objective);
    EXPECT_EQ(r.objective, best);
    for (const int t : problem.fixed)
        for (int k = 0; k < 3; ++k) {
            const int v = problem.surface.triangles(t, k);
            EXPECT_EQ(problem.surface.vertices.row(v), r.vertices.row(v));
        }
}

TEST(CoarseToFine, SameInputGivesTheSameHistory) {
    std::vector<double> first, second;
    Problem problem = more_volume();
    problem.optimize.max_evaluations = 9;
    for (auto* list : {&first, &second}) {
        RunEvents events;
        events.evaluation = [&](const EvaluationRecord& r) { list->push_back(r.objective); };
        const RunResult r = optimize(problem, events);
        EXPECT_EQ(r.status, "budget");
        EXPECT_LE(r.evaluations, 9);
    }
    EXPECT_EQ(first, second);
}

TEST(CoarseToFine, ALevelEndsForDetailsOnlyWhereTheRuleAllowsIt) {
    Problem problem = ellipsoid_problem(2, 3);
    maximize_volume(problem);
    const auto left_early = [&](double progress_below) {
        problem.optimize.progress_below = progress_below;
        const RunResult r = optimize(problem);
        return std::count_if(r.levels.begin(), r.levels.end(), [](const LevelSummary& level) {
            return level.stop == "finer details are expected to gain more" || level.stop == "progress slackened";
        });
    };
    EXPECT_GT(left_early(0.01), 0);
    EXPECT_EQ(left_early(0), 0);
}

TEST(CoarseToFine, QuantityFailureEndsTheRun) {
    Problem problem = more_volume();
    const auto evaluate = problem.quantities[0].evaluate;
    problem.quantities[0].evaluate = [=](const QuantityRequest& request) {
        QuantityResult result = evaluate(request);
        if (request.evaluation == 3) result.failure = Failure{"timeout", "solver.sh: killed after 2 s"};
        return result;
    };
    const RunResult r = optimize(problem);
    EXPECT_EQ(r.status, "evaluation_failed");
    EXPECT_NE(r.reason.find("killed after 2 s"), std::string::npos);
    EXPECT_EQ(r.evaluations, 3);
    problem.quantities[0].evaluate = [=](const QuantityRequest& request) {
        QuantityResult result = evaluate(request);
        result.values[0] = std::numeric_limits<double>::quiet_NaN();
        return result;
    };
    EXPECT_EQ(optimize(problem).status, "evaluation_failed");
}

TEST(CoarseToFine, UnreachableConstraintIsInfeasible) {
    Problem problem = more_volume();
    problem.constraints[0].max = {};
    problem.constraints[0].min = 50;
    problem.optimize.max_evaluations = 12;
    const RunResult r = optimize(problem);
    EXPECT_EQ(r.status, "infeasible");
    EXPECT_GT(r.max_violation, 0.1);
}

TEST(CoarseToFine, WrongProblemsAreRefused) {
    Problem problem = more_volume();
    problem.objective = "drag";
    EXPECT_THROW(optimize(problem), InvalidInput);
    problem = more_volume();
    problem.objective.clear();
    EXPECT_THROW(optimize(problem), InvalidInput);
    problem = more_volume();
    problem.constraints[0].min = 1.5;
    EXPECT_THROW(optimize(problem), InvalidInput);
    problem = more_volume();
    problem.fixed.clear();
    for (int t = 0; t + 1 < problem.surface.num_triangles(); ++t) problem.fixed.push_back(t);
    EXPECT_ANY_THROW(optimize(problem));
}

TEST(CoarseToFine, ExternalObjectiveGivesTheHistoryOfTheBuiltInOne) {
    ASSERT_EQ(std::system("python3 -c pass 2>/dev/null"), 0) << "the set-up scripts install python3";
    namespace fs = std::filesystem;
    const fs::path folder = fs::temp_directory_path() / ("strake_external_" + std::to_string(::getpid()));
    fs::create_directories(folder);
    const auto history = [&](bool external_volume) {
        Problem problem = more_volume();
        problem.surface = ellipsoid({1, 0.6, 0.4}, 2);
        const Problem coarse = ellipsoid_problem(2, 2);
        problem.tree = coarse.tree;
        problem.prism_height = coarse.prism_height;
        problem.fixed = coarse.fixed;
        problem.optimize.max_evaluations = 10;
        problem.quantities = coarse.quantities;
        if (external_volume) {
            ExternalCommand command;
            command.name = "volume";
            command.command = {"python3", std::string(STRAKE_CASES) + "/external/volume.py", "{request}", "{result}"};
            command.format = "obj";
            command.case_dir = folder;
            command.evaluations_dir = folder / "evaluations";
            command.diagonal = box_diagonal(problem.surface);
            command.timeout_s = 60;
            problem.quantities[0] = external(command);
        }
        std::vector<EvaluationRecord> records;
        RunEvents events;
        events.evaluation = [&](const EvaluationRecord& r) { records.push_back(r); };
        optimize(problem, events);
        return records;
    };
    const auto inside = history(false), outside = history(true);
    fs::remove_all(folder);
    ASSERT_EQ(inside.size(), outside.size());
    for (std::size_t i = 0; i < inside.size(); ++i) {
        EXPECT_EQ(inside[i].status, outside[i].status) << outside[i].reason;
        EXPECT_EQ(inside[i].accepted, outside[i].accepted);
        EXPECT_NEAR(inside[i].objective, outside[i].objective, 1e-10 * inside[i].objective);
        EXPECT_NEAR(inside[i].values[1], outside[i].values[1], 1e-10 * inside[i].values[1]);
    }
}
