#include "report/run_folder.hpp"

#include "core/error.hpp"
#include "optimize/run/coarse_to_fine.hpp"
#include "problems.hpp"

#include <gtest/gtest.h>
#include <unistd.h>
#include <fstream>

using namespace strake;

namespace {

namespace fs = std::filesystem;

struct TemporaryFolder {
    fs::path path = fs::temp_directory_path() / ("strake_run_folder_" + std::to_string(::getpid()));
    TemporaryFolder() { fs::remove_all(path); }
    ~TemporaryFolder() { fs::remove_all(path); }
};

std::string contents(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

Problem small_problem() {
    Problem problem = ellipsoid_problem(2, 2);
    problem.objective = "volume";
    problem.maximize = true;
    problem.optimize.max_evaluations = 8;
    return problem;
}

RunResult run_into(const fs::path& path, const Problem& problem) {
    RunFolder folder(path);
    folder.write_case("case: ellipsoid\n");
    folder.begin(problem, {"volume", "area"}, SurfaceFormat::off, SeriesPolicy::every_accepted);
    RunEvents events;
    events.level = [&](const LevelStart& level) { folder.add(level); };
    events.evaluation = [&](const EvaluationRecord& record) { folder.add(record); };
    events.accepted = [&](const AcceptedDesign& design) { folder.add(design); };
    const RunResult result = optimize(problem, events);
    folder.finish(result);
    for (const std::string& file : folder.files()) EXPECT_TRUE(fs::exists(path / file)) << file;
    return result;
}

}  // namespace

TEST(RunFolder, HoldsTheRunAndEqualRunsGiveEqualBytes) {
    TemporaryFolder temporary;
    const Problem problem = small_problem();
    const RunResult result = run_into(temporary.path / "a", problem);
    run_into(temporary.path / "b", problem);
    for (const char* file : {"history.csv", "run.json", "best.off", "levels/best.csv", "levels/labels_2.csv"}) {
        EXPECT_FALSE(contents(temporary.path / "a" / file).empty()) << file;
        EXPECT_EQ(contents(temporary.path / "a" / file), contents(temporary.path / "b" / file)) << file;
    }
    const Points best = read_surface(temporary.path / "a" / "best.off").mesh.vertices;
    EXPECT_EQ(best, result.vertices);  // 17 digits: bit for bit
    const std::string history = contents(temporary.path / "a" / "history.csv");
    EXPECT_EQ(history.substr(0, history.find('\n')),
              "evaluation,level,status,objective,volume,area,max_violation,accepted");
    EXPECT_EQ(std::count(history.begin(), history.end(), '\n'), result.evaluations + 1);
    EXPECT_NE(contents(temporary.path / "a" / "run.json").find("\"max_violation\""), std::string::npos);
}

/// A callback that changes the working directory must not redirect what is written.
TEST(RunFolder, ARelativeFolderStaysWhereItIs) {
    TemporaryFolder temporary;
    fs::create_directories(temporary.path / "elsewhere");
    const fs::path before = fs::current_path();
    fs::current_path(temporary.path);
    {
        RunFolder folder("run");
        fs::current_path(temporary.path / "elsewhere");
        folder.write_case("case: a\n");
    }
    fs::current_path(before);
    EXPECT_EQ(contents(temporary.path / "run" / "case.yaml"), "case: a\n");
    EXPECT_TRUE(fs::is_empty(temporary.path / "elsewhere"));
    EXPECT_FALSE(fs::exists(temporary.path / "run" / "lock"));
}

TEST(RunFolder, WhatEndedBeforeItBeganIsNoObstacleOrSaid) {
    TemporaryFolder temporary;
    fs::create_directories(temporary.path);
    std::ofstream(temporary.path / "lock") << "12345 elsewhere\n";
    EXPECT_NO_THROW(check_run_folder(temporary.path));
    { const RunFolder folder(temporary.path); }
    std::ofstream(temporary.path / "case.yaml") << "# run of a case in /cases\n";
    try {
        check_run_folder(temporary.path);
        ADD_FAILURE() << "was accepted";
    } catch (const OutputError& begun) {
        EXPECT_NE(std::string(begun.what()).find("`strake resume "), std::string::npos) << begun.what();
    }
}

TEST(RunFolder, NeverOverwrites) {
    TemporaryFolder temporary;
    fs::create_directories(temporary.path);
    EXPECT_NO_THROW(check_run_folder(temporary.path));
    std::ofstream(temporary.path / "notes.txt") << "mine";
    EXPECT_THROW(check_run_folder(temporary.path), OutputError);
    EXPECT_THROW(RunFolder folder(temporary.path), OutputError);
    EXPECT_THROW(check_run_folder(temporary.path / "notes.txt"), OutputError);
    EXPECT_EQ(contents(temporary.path / "notes.txt"), "mine");
}

TEST(History, RowsHaveSeventeenDigitsAndGapsForWhatIsMissing) {
    EvaluationRecord record;
    record.evaluation = 3;
    record.level = 2;
    record.status = "not_converged";
    EXPECT_EQ(history_row(record, 2), "3,2,not_converged,,,,,0");
    record.status = "ok";
    record.objective = 0.1;
    record.values = {0.1, -2};
    record.max_violation = 0;
    record.accepted = true;
    EXPECT_EQ(history_row(record, 2),
              "3,2,ok,1.0000000000000001e-01,1.0000000000000001e-01,-2.0000000000000000e+00,0.0000000000000000e+00,1");
}
