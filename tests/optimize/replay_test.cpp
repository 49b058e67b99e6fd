#include "core/mesh/temp_folder.hpp"
#include "optimize/journal/journal.hpp"
#include "optimize/nlp/program/methods.hpp"
#include "optimize/run/coarse_to_fine.hpp"
#include "optimize/run/fit.hpp"
#include "optimize/run/history.hpp"
#include "problems.hpp"

#include <gtest/gtest.h>

/// A run that died, by whatever method, is replayed from its journal and ends as if nothing had happened.
namespace strake {
namespace {

/// The program was killed.
struct Killed {};

/// Volume as a program would give it, counted.
Quantity counted_volume(const TriMesh& surface, std::vector<int>& calls) {
    Quantity counted = volume(surface);
    counted.names = {"bulk"};
    counted.program = "count";
    counted.evaluate = [inner = counted.evaluate, &calls](const QuantityRequest& request) {
        calls.push_back(request.evaluation);
        return inner(request);
    };
    return counted;
}

struct Told {
    std::string history;
    RunResult result;
};

/// @param dies_after evaluations that are told before the end; 0: it lives.
Told run(const Problem& problem, Journal* journal, int dies_after = 0) {
    Told told;
    RunEvents events;
    int fresh = 0;
    events.evaluation = [&](const EvaluationRecord& record) {
        told.history += history_row(record, record.values.size()) + "\n";
        if (!record.is_replayed && ++fresh == dies_after) throw Killed{};
    };
    try {
        told.result = problem.fit.empty() ? optimize(problem, events, journal) : fit(problem, events, journal);
    } catch (const Killed&) {
    }
    return told;
}

std::unique_ptr<Journal> fresh(const std::filesystem::path& file, const Problem& problem) {
    JournalFacts facts;
    facts.case_yaml = "case: test\n";
    return Journal::create(file, facts, {0, problem.optimize.max_evaluations, problem.optimize.max_seconds});
}

/// Every start is killed after so many evaluations of its own.
void expect_survives(const Problem& problem, std::vector<int>& calls, int step = 5) {
    calls.clear();
    const Told whole = run(problem, nullptr);
    const std::vector<int> needed = calls;
    ASSERT_GT(whole.result.evaluations, 6) << whole.result.reason;
    const TempFolder folder;
    calls.clear();
    fresh(folder / "j", problem);
    Told told;
    int starts = 0;
    do {
        const auto journal = Journal::open(folder / "j");
        told = run(problem, journal.get(), step);
    } while (told.result.levels.empty() && ++starts < 100);
    EXPECT_EQ(starts, whole.result.evaluations / step);
    EXPECT_EQ(told.history, whole.history);
    EXPECT_EQ(told.result.status, whole.result.status);
    EXPECT_EQ(told.result.reason, whole.result.reason);
    EXPECT_EQ(told.result.vertices, whole.result.vertices);
    EXPECT_EQ(calls, needed) << "nothing was paid twice";
}

/// As much volume as little more area can hold.
Problem small(std::vector<int>& calls) {
    Problem problem = ellipsoid_problem(1, 2);
    problem.parameters.kinds = {VariableKind::normal_load};
    problem.quantities.push_back(counted_volume(problem.surface, calls));
    maximize_volume(problem);
    problem.objective = "bulk";
    problem.optimize.max_evaluations = 8;
    return problem;
}

class EveryMethodReplays : public testing::TestWithParam<MethodFacts> {};

TEST_P(EveryMethodReplays, EndsWithTheSameBitsAndPaysNothingTwice) {
    std::vector<int> calls;
    Problem problem = small(calls);
    problem.optimize.method = GetParam().method;
    problem.optimize.max_evaluations = 24;
    expect_survives(problem, calls);
}

TEST_P(EveryMethodReplays, StopsOnRequest) {
    std::vector<int> calls;
    Problem problem = small(calls);
    problem.optimize.method = GetParam().method;
    problem.optimize.max_evaluations = 24;
    RunEvents events;
    events.stop_wanted = [&] { return calls.size() == 3; };
    const RunResult stopped = optimize(problem, events);
    EXPECT_EQ(stopped.status, "interrupted");
    EXPECT_EQ(calls.size(), 3u);
    EXPECT_GT(stopped.best_evaluation, 0);
}

INSTANTIATE_TEST_SUITE_P(Replay, EveryMethodReplays, testing::ValuesIn(all_methods()),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(Replay, OfGradientsThatAreInheritedAndPartlyGuessed) {
    std::vector<int> calls;
    Problem problem = ellipsoid_problem(2, 3);
    problem.quantities.push_back(counted_volume(problem.surface, calls));
    maximize_volume(problem);
    problem.objective = "bulk";
    for (Quantity& quantity : problem.quantities) quantity.has_sensitivities = false;
    problem.optimize.finite_differences = true;
    problem.optimize.max_evaluations = 240;
    const RunResult whole = optimize(problem);
    ASSERT_GE(whole.levels.size(), 2u) << whole.reason;
    expect_survives(problem, calls, 37);
}

TEST(Replay, OfStartsDifferencesAndFailuresThatShortenSteps) {
    std::vector<int> calls;
    Problem problem = ellipsoid_problem(1, 2);
    problem.parameters.kinds = {VariableKind::normal_load};
    Quantity failing = counted_volume(problem.surface, calls);
    failing.has_sensitivities = false;
    failing.failing_shortens_step = true;
    failing.evaluate = [inner = failing.evaluate](const QuantityRequest& request) {
        QuantityResult result = inner(request);
        if (request.evaluation % 5 == 4) return QuantityResult{{}, {}, Failure{"exit", "exit status 1"}};
        result.dJ_dv.clear();
        return result;
    };
    problem.quantities.push_back(failing);
    problem.objective = "bulk";
    problem.maximize = true;
    problem.optimize.finite_differences = true;
    problem.optimize.starts = 2;
    problem.optimize.max_evaluations = 30;
    expect_survives(problem, calls);
}

TEST(Replay, OfAFit) {
    std::vector<int> calls;
    Problem problem = ellipsoid_problem(1, 2);
    TriMesh wanted = problem.surface;
    wanted.vertices.col(2) *= 1.05;
    problem.quantities = {target_shape_same("match", problem.surface, wanted), counted_volume(problem.surface, calls)};
    problem.fit = {"match"};
    problem.optimize.max_evaluations = 20;
    expect_survives(problem, calls);
}

/// Of several programs in an evaluation, those that have ended are not paid again when a later one dies.
TEST(Replay, ACallThatEndedIsKeptBeforeItsEvaluationEnds) {
    const TempFolder folder;
    std::vector<int> calls, later;
    Problem problem = small(calls);
    Quantity second = counted_volume(problem.surface, later);
    second.names = {"second"};
    bool dies = true;
    second.evaluate = [inner = second.evaluate, &dies](const QuantityRequest& request) {
        if (dies && request.evaluation == 4) throw Killed{};
        return inner(request);
    };
    problem.quantities.push_back(second);
    run(problem, fresh(folder / "j", problem).get());
    ASSERT_EQ(calls.back(), 4);
    dies = false;
    const Told told = run(problem, Journal::open(folder / "j").get());
    EXPECT_EQ(std::count(calls.begin(), calls.end(), 4), 1);
    EXPECT_EQ(std::count(later.begin(), later.end(), 4), 1);
    EXPECT_EQ(told.history, run(problem, nullptr).history);
}

TEST(Replay, AnotherProblemIsNoticedAtTheFirstDesignThatDiffers) {
    const TempFolder folder;
    std::vector<int> calls;
    Problem problem = small(calls);
    const Told whole = run(problem, fresh(folder / "j", problem).get());
    problem.maximize = false;
    calls.clear();
    try {
        run(problem, Journal::open(folder / "j").get());
        FAIL() << "was not noticed";
    } catch (const ReplayMismatch& mismatch) {
        const std::string words = mismatch.what();
        EXPECT_NE(words.find("evaluation 2"), std::string::npos) << words;
        EXPECT_NE(words.find("variable p"), std::string::npos) << words;
    }
    EXPECT_TRUE(calls.empty()) << "and nothing is paid for it";
    EXPECT_EQ(static_cast<int>(Journal::open(folder / "j")->evaluations().size()), whole.result.evaluations);
}

TEST(Replay, OtherValuesAreNoticed) {
    const TempFolder folder;
    std::vector<int> calls;
    Problem problem = small(calls);
    run(problem, fresh(folder / "j", problem).get());
    problem.quantities[1] = volume(problem.surface);
    problem.quantities[1].names = {"area"};
    EXPECT_THROW(run(problem, Journal::open(folder / "j").get()), ReplayMismatch);
}

/// A larger budget goes on from the end; the evaluations before stay what they were, and the best is not paid again.
TEST(Replay, ARaisedBudgetGoesOn) {
    for (const bool is_fit : {false, true}) {
        const TempFolder folder;
        std::vector<int> calls;
        Problem problem = small(calls);
        if (!is_fit) problem.parameters.kinds = {VariableKind::load};
        problem.optimize.max_evaluations = is_fit ? 4 : 8;
        if (is_fit) {
            problem.constraints.clear();
            TriMesh wanted = problem.surface;
            wanted.vertices.col(2) *= 1.05;
            problem.quantities[0] = target_shape_same("match", problem.surface, wanted);
            problem.fit = {"match"};
        }
        const Told first = run(problem, fresh(folder / "j", problem).get());
        ASSERT_EQ(first.result.status, "budget") << is_fit << first.history;
        Journal::open(folder / "j")->set_limits(30, 0);
        calls.clear();
        const Told then = run(problem, Journal::open(folder / "j").get());
        EXPECT_EQ(then.history.substr(0, first.history.size()), first.history);
        EXPECT_GT(then.result.evaluations, first.result.evaluations);
        EXPECT_LE(then.result.evaluations, 30);
        EXPECT_EQ(static_cast<int>(calls.size()) <= then.result.evaluations - first.result.evaluations, true);
        if (is_fit)
            EXPECT_LT(then.result.objective, first.result.objective);
        else
            EXPECT_GT(then.result.objective, first.result.objective);
        // And that run can be killed and resumed, too.
        calls.clear();
        const Told again = run(problem, Journal::open(folder / "j").get());
        EXPECT_EQ(again.history, then.history);
        EXPECT_TRUE(calls.empty());
    }
}

/// A stop is asked for between evaluations, after every iteration of a deformation, and as a level is set up, and none
/// of its moments leaves a trace in what comes out.
TEST(Replay, AStopWhileTheShellIsSolvedLeavesTheSameBits) {
    std::vector<int> calls;
    const Problem problem = small(calls);
    int asked = 0, stop_at = 0;
    const auto run_with = [&](Journal* journal) {
        Told told;
        RunEvents events;
        asked = 0;
        events.stop_wanted = [&] { return ++asked >= stop_at && stop_at > 0; };
        events.evaluation = [&](const EvaluationRecord& record) {
            told.history += history_row(record, record.values.size()) + "\n";
        };
        told.result = optimize(problem, events, journal);
        return told;
    };
    const Told whole = run_with(nullptr);
    const std::vector<int> needed = std::exchange(calls, {});
    const int all_askings = asked;
    EXPECT_GT(all_askings, 3 * whole.result.evaluations);
    int stops = 0;
    for (int moment = 2; moment <= all_askings; moment += 5, calls.clear()) {
        SCOPED_TRACE(moment);
        const TempFolder folder;
        const auto journal = fresh(folder / "j", problem);
        stop_at = moment;
        const Told cut = run_with(journal.get());
        EXPECT_EQ(cut.result.status, "interrupted");
        EXPECT_LE(asked, moment + 1) << "it ends at once, or with a solve that this iteration has ended";
        EXPECT_EQ(static_cast<int>(journal->evaluations().size()), cut.result.evaluations);
        stop_at = 0;
        const Told told = run_with(Journal::open(folder / "j").get());
        EXPECT_EQ(told.history, whole.history);
        EXPECT_EQ(told.result.vertices, whole.result.vertices);
        EXPECT_EQ(calls, needed) << "nothing was paid twice";
        ++stops;
    }
    EXPECT_GE(stops, 5);
}

TEST(Replay, AStopOnRequestIsNoFailure) {
    const TempFolder folder;
    std::vector<int> calls;
    const Problem problem = small(calls);
    const Told whole = run(problem, nullptr);
    calls.clear();
    RunEvents events;
    events.stop_wanted = [&] { return calls.size() == 3; };
    const RunResult stopped = optimize(problem, events, fresh(folder / "j", problem).get());
    EXPECT_EQ(stopped.status, "interrupted");
    EXPECT_EQ(stopped.evaluations, 3);
    EXPECT_GT(stopped.best_evaluation, 0);
    EXPECT_FALSE(stopped.is_done());
    // The level that was cut short tells what it has found, not zeros.
    EXPECT_EQ(stopped.levels.back().evaluations, 3);
    EXPECT_EQ(stopped.levels.back().objective_end, stopped.objective);
    EXPECT_FALSE(stopped.levels.back().stop.empty());
    EXPECT_EQ(run(problem, Journal::open(folder / "j").get()).history, whole.history);
}

}  // namespace
}  // namespace strake
