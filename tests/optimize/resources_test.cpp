#include "optimize/run/coarse_to_fine.hpp"
#include "problems.hpp"

#include <gtest/gtest.h>
#include <unistd.h>
#include <filesystem>
#include <fstream>

/// A long run must not grow: memory and descriptors over a thousand evaluations.
namespace strake {
namespace {

long resident_bytes() {
    long total = 0, resident = 0;
    std::ifstream("/proc/self/statm") >> total >> resident;
    return resident * ::sysconf(_SC_PAGESIZE);
}

long open_files() {
    long count = 0;
    for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) ++count;
    return count;
}

}  // namespace

TEST(Resources, AThousandEvaluationsKeepMemoryAndFilesConstant) {
    if (!std::filesystem::exists("/proc/self/statm")) GTEST_SKIP() << "needs /proc";
    Problem problem = ellipsoid_problem(1, 2);
    problem.parameters.kinds = {VariableKind::load};
    problem.objective = "volume";
    problem.maximize = true;
    problem.optimize.method = Method::esch;  // random within the bounds, then slsqp: many of its shapes fail
    long after_fifty = 0, at_the_end = 0, files = 0;
    int evaluations = 0, failed = 0;
    RunEvents events;
    events.evaluation = [&](const EvaluationRecord& record) {
        failed += record.status != "ok";
        if (++evaluations == 50) after_fifty = resident_bytes(), files = open_files();
        if (evaluations % 250 == 0) {
            EXPECT_EQ(open_files(), files);
        }
        at_the_end = resident_bytes();
    };
    // Runs end when they have converged, others with other seeds follow.
    for (problem.optimize.seed = 1; evaluations < 1000; ++problem.optimize.seed) {
        problem.optimize.max_evaluations = 1000 - evaluations;
        optimize(problem, events);
        ASSERT_LT(problem.optimize.seed, 20u);
    }
    EXPECT_EQ(evaluations, 1000);
    EXPECT_GT(failed, 10);
    EXPECT_LT(at_the_end - after_fifty, 5 * 1024 * 1024);
    if (std::getenv("STRAKE_TELL"))
        std::cout << "TELL " << at_the_end - after_fifty << " bytes, " << failed << " failed\n";
}

}  // namespace strake
