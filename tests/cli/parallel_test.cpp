#include "cli/program_case.hpp"
#include "core/error.hpp"

/// Programs that run at the same time: the same bits, in whatever order they finish.
namespace strake {
namespace {

class Parallel : public ProgramCase {
protected:
    const std::string differences = "optimize: {finite_differences: true, budget: {evaluations: 30}}\n";
    std::string values_case(const std::string& more = "") const {
        return external_case(", gradients: false" + more, differences);
    }
};

TEST_F(Parallel, RandomOrdersGiveTheBitsOfOneAfterAnother) {
    ASSERT_EQ(run_strake({"run", values_case(), "--out", path("whole"), "-q"}).status, 0);
    mark("jitter");
    for (const int n : {2, 3, 16}) {
        const std::string out = text("n", n);
        const ProgramRun run = run_strake({"run", values_case(text(", parallel: ", n)), "--out", path(out), "-q"});
        EXPECT_EQ(run.status, 0) << run.err;
        expect_same("whole", out);
    }
}

TEST_F(Parallel, ProgramsOfOneEvaluationRunSideBySide) {
    std::string text =
        body +
        "quantities:\n  bulk: {command: [python3, \"-S\", \"{case_dir}/bulk.py\", \"{request}\"] @}\n"
        "  slow: {command: [sh, \"-c\", \"sleep 0.3; echo '{\\\"value\\\": 1}' > result.json\"], gradients: "
        "false}\n  late: {command: [sh, \"-c\", \"sleep 0.3; echo '{\\\"value\\\": 2}' > "
        "result.json\"], gradients: false}\nobjective: {maximize: bulk}\n"
        "optimize: {budget: {evaluations: 4}}\n";
    const auto seconds = [&](const std::string& more, const std::string& out) {
        std::string with = text;
        with.replace(with.find('@'), 1, more);
        const std::string file = folder.write("case.yaml", with).string();
        const ProgramRun run = run_strake({"run", file, "--out", path(out), "-q"});
        EXPECT_EQ(run.status, 0) << run.err;
        return Json::parse(run_strake({"status", path(out), "--json"}).out)["seconds"].get<double>();
    };
    const double serial = seconds("", "a"), parallel = seconds(", parallel: 2", "b");
    expect_same("a", "b");
    EXPECT_LT(parallel, serial - 0.5) << "two of three programs waited for each other four times";
}

TEST_F(Parallel, AKilledRunPaysForNothingTwiceAndAnInterruptedOneLeavesNothingRunning) {
    ASSERT_EQ(run_strake({"run", values_case(), "--out", path("whole"), "-q"}).status, 0);
    fs::remove(folder / "calls");
    const std::string file = values_case(", parallel: 3");
    mark("sleep-3");
    const Started run(folder, {"run", file, "--out", path("a"), "-q"});
    while (!fs::exists(folder / "sleeping")) pause_ms(5);
    while (calls().size() < 4) pause_ms(5);
    pause_ms(400);  // the others have ended
    run.send(SIGKILL);
    run.wait();
    fs::remove(folder / "sleep-3");
    EXPECT_EQ(run_strake({"resume", path("a"), "-q"}).status, 0);
    expect_same("whole", "a");
    for (const int number : calls()) EXPECT_TRUE(number == 3 || calls().count(number) == 1) << number;

    for (const char* what : {"sleep-2", "sleep-3", "long-2", "long-3"}) mark(what);
    fs::remove(folder / "sleeping");
    const Started other(folder, {"run", file, "--out", path("b"), "-q"});
    while (!fs::exists(folder / "sleeping")) pause_ms(5);
    pause_ms(200);
    const auto begin = std::chrono::steady_clock::now();
    other.send(SIGTERM);
    EXPECT_EQ(other.wait(), 75) << other.messages();
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(25));
    fs::remove(folder / "sleep-2");
    fs::remove(folder / "sleep-3");
    EXPECT_EQ(run_strake({"resume", path("b"), "-q"}).status, 0);
    expect_same("whole", "b");
}

TEST_F(Parallel, AFailureThatEndsTheRunEndsTheOthersAndItsNeighboursAreKept) {
    ASSERT_EQ(run_strake({"run", values_case(), "--out", path("whole"), "-q"}).status, 0);
    fs::remove(folder / "calls");
    mark("fail-3");
    mark("sleep-4");
    mark("long-4");
    const auto begin = std::chrono::steady_clock::now();
    const ProgramRun run = run_strake({"run", values_case(", parallel: 4"), "--out", path("a"), "-q"});
    EXPECT_EQ(run.status, 5) << run.err;
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(25)) << "nobody waits for 4";
    EXPECT_NE(run.err.find("licence server is down"), std::string::npos) << run.err;
    fs::remove(folder / "fail-3");
    fs::remove(folder / "sleep-4");
    EXPECT_EQ(run_strake({"resume", path("a"), "-q"}).status, 0);
    expect_same("whole", "a");
    EXPECT_EQ(calls().count(2), 1u) << "2 had ended and was not paid again";
}

TEST_F(Parallel, GradientCommandsAndACacheChangeNothing) {
    undisturbed();
    const std::string file = external_case(gradients_apart + ", parallel: 2, cache: answers");
    for (const char* out : {"first", "second"}) {
        const ProgramRun run = run_strake({"run", file, "--out", path(out)});
        EXPECT_EQ(run.status, 0) << run.err;
        expect_same("whole", out);
        EXPECT_EQ(run.err.find("bulk (gradient) is taken from the cache") != std::string::npos, out[0] == 's');
    }
    for (const char* each : {"calls", "gradient-calls"})
        for (const int number : calls(each)) EXPECT_EQ(calls(each).count(number), 1u) << each << number;
    EXPECT_LE(calls("gradient-calls").size(), calls().size());
    EXPECT_FALSE(fs::exists(folder / "second/evaluations/000001"));
    for (const auto& entry : fs::directory_iterator(folder / "answers")) fs::remove(entry.path());
    const ProgramRun check = run_strake({"check", file, "--evaluate"});
    EXPECT_EQ(check.status, 0) << check.err;
    EXPECT_TRUE(fs::is_empty(folder / "answers")) << "a check asks the program and keeps nothing";
}

TEST_F(Parallel, FailedPointsOfAGradientAreReplacedByTheOtherSideInTheSameOrder) {
    for (const char* what : {"fail-3", "fail-8"}) mark(what);
    const std::string policy = ", on_failure: shrink_step";
    const ProgramRun one = run_strake({"run", values_case(policy), "--out", path("one"), "-q"});
    mark("jitter");
    const ProgramRun many =
        run_strake({"run", values_case(text(policy, ", parallel: 5")), "--out", path("many"), "-q"});
    EXPECT_EQ(one.status, many.status) << one.err << many.err;
    expect_same("one", "many");
    EXPECT_NE(bytes_of(folder / "one/history.csv").find("\n3,1,quantity_failed"), std::string::npos);
}

}  // namespace
}  // namespace strake
