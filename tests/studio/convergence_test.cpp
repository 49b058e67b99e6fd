#include "studio/convergence.hpp"

#include "tests/casefile/folder.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace strake {
namespace {

using Columns = std::vector<std::vector<double>>;
using Names = std::vector<std::string>;

TEST(Convergence, ReadsSu2sHistory) {
    const auto table = read_convergence(
        "\"Time_Iter\",\"Inner_Iter\",     \"rms[Rho]\"     ,       \"CL\"\n"
        "          0,           0,         -3.521,     0.1\n"
        "          0,           1,         -4.25e0,     nan\n"
        "          0,           2,  -5");
    EXPECT_EQ(table.names, (Names{"Time_Iter", "Inner_Iter", "rms[Rho]", "CL"}));
    ASSERT_EQ(table.columns.size(), 4u);
    EXPECT_EQ(table.columns[1], (std::vector<double>{0, 1})) << "the last line is being written";
    EXPECT_EQ(table.columns[2], (std::vector<double>{-3.521, -4.25}));
    EXPECT_TRUE(std::isnan(table.columns[3][1]));
}

TEST(Convergence, ReadsOpenFoamsSolverInfoWithoutItsWords) {
    const auto table = read_convergence(
        "# Solver information\n"
        "# Time          \tU_solver      \tUx_initial    \tU_converged\n"
        "1               \tsmoothSolver  \t1.0e+00       \tfalse\n"
        "2               \tsmoothSolver  \t5.0e-01       \tfalse\n");
    EXPECT_EQ(table.names, (Names{"Time", "Ux_initial"}));
    EXPECT_EQ(table.columns, (Columns{{1, 2}, {1, 0.5}}));
}

TEST(Convergence, ReadsALogOfOpenFoam) {
    const auto table = read_convergence(
        "Build  : v2212\nTime = 1\n\n"
        "smoothSolver:  Solving for Ux, Initial residual = 1, Final residual = 0.05, No Iterations 3\n"
        "GAMG:  Solving for p, Initial residual = 0.9, Final residual = 0.08, No Iterations 4\n"
        "GAMG:  Solving for p, Initial residual = 0.3, Final residual = 0.02, No Iterations 4\n"
        "Time = 2s\n\n"
        "smoothSolver:  Solving for Ux, Initial residual = 0.25, Final residual = 0.01, No Iterations 3\n");
    EXPECT_EQ(table.names, (Names{"Time", "Ux", "p"}));
    EXPECT_EQ(table.columns[0], (std::vector<double>{1, 2}));
    EXPECT_EQ(table.columns[1], (std::vector<double>{1, 0.25}));
    EXPECT_EQ(table.columns[2][0], 0.9) << "the first of a time";
    EXPECT_TRUE(std::isnan(table.columns[2][1]));
}

TEST(Convergence, ReadsNumbersWithoutNames) {
    const auto table = read_convergence("1 0.5\n2 0.25\r\n");
    EXPECT_EQ(table.names, (Names{"iteration", "column 2"}));
    EXPECT_EQ(table.columns, (Columns{{1, 2}, {0.5, 0.25}}));
}

TEST(Convergence, SaysNothingOfWhatIsNoTable) {
    for (const char* bytes : {"", "\n\n", "hello\n", "1", ",,,\n", "#\n", "Solving for x, Initial residual = 1\n"})
        EXPECT_TRUE(read_convergence(bytes).columns.empty() || read_convergence(bytes).columns[0].empty()) << bytes;
}

TEST(Convergence, TakesTheEndsOfALongTable) {
    std::string bytes;
    for (int k = 0; k < 5000; ++k) bytes += std::to_string(k) + "," + std::to_string(2 * k) + "\n";
    const auto table = read_convergence(bytes, 100);
    ASSERT_EQ(table.columns[0].size(), 100u);
    EXPECT_EQ(table.columns[0].front(), 0);
    EXPECT_EQ(table.columns[0].back(), 4999);
    EXPECT_EQ(table.columns[1].back(), 9998);
}

TEST(Convergence, FindsTheNewestFilesAndFollowsNoLinkOutOfTheRun) {
    const Folder folder;
    const std::filesystem::path run = folder.path() / "run", outside = folder.path() / "outside";
    std::filesystem::create_directories(run / "evaluations/000003");
    for (const char* file : {"run/evaluations/000001/log", "run/evaluations/000002/drag/log",
                             "run/evaluations/000002-2/drag/log", "run/evaluations/notes/log", "outside/log"})
        folder.write(file, "1 2\n");
    std::filesystem::create_symlink(outside / "log", run / "evaluations/000003/log");
    const auto files = convergence_files(run, {{"drag", "log"}});
    ASSERT_EQ(files.size(), 3u);
    EXPECT_EQ(files[0].name, "000002-2/drag/log");
    EXPECT_EQ(files[1].name, "000002/drag/log");
    EXPECT_EQ(files[2].name, "000001/log");
    EXPECT_EQ(files[2].evaluation, 1);
    EXPECT_EQ(convergence_files(run, {{"drag", "log"}}, 1).size(), 1u);
    EXPECT_TRUE(convergence_files(outside, {{"drag", "log"}}).empty());
}

}  // namespace
}  // namespace strake
