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

/// Waits for the other of two programs of the same evaluation where a file `meet` is there; writes down when it comes
/// and goes.
const char* const meet = R"(import json, os, sys, time
here, me, other = os.path.dirname(os.path.abspath(__file__)), *sys.argv[1:]
number = json.load(open("request.json"))["evaluation"]
def note(what):
    with open(here + "/visits", "a") as visits:
        visits.write(what + "\n")
note("in")
open("%s/here-%s-%d" % (here, me, number), "w").close()
end = time.time() + 60
while os.path.exists(here + "/meet") and not os.path.exists("%s/here-%s-%d" % (here, other, number)):
    if time.time() > end:
        sys.exit(other + " did not come")
    time.sleep(0.01)
note("out")
json.dump({"value": 1}, open("result.json", "w"))
)";

TEST_F(Parallel, ProgramsOfOneEvaluationRunSideBySide) {
    folder.write("meet.py", meet);
    std::string text = body +
                       "quantities:\n  bulk: {command: [python3, \"-S\", \"{case_dir}/bulk.py\", \"{request}\"] @}\n"
                       "  early: {command: [python3, \"-S\", \"{case_dir}/meet.py\", early, late], gradients: false}\n"
                       "  late: {command: [python3, \"-S\", \"{case_dir}/meet.py\", late, early], gradients: false}\n"
                       "objective: {maximize: bulk}\noptimize: {budget: {evaluations: 4}}\n";
    const auto visits = [&](const std::string& more, const std::string& out) {
        fs::remove(folder / "visits");
        std::string with = text;
        with.replace(with.find('@'), 1, more);
        const std::string file = folder.write("case.yaml", with).string();
        const ProgramRun run = run_strake({"run", file, "--out", path(out), "-q"});
        EXPECT_EQ(run.status, 0) << run.err;
        return bytes_of(folder / "visits");
    };
    const std::string serial = visits("", "a");
    for (size_t at = 0; at < serial.size(); at += 7) EXPECT_EQ(serial.substr(at, 7), "in\nout\n");
    std::vector<fs::path> old;
    for (const auto& entry : fs::directory_iterator(folder.path()))
        if (entry.path().filename().string().starts_with("here-")) old.push_back(entry.path());
    for (const fs::path& each : old) fs::remove(each);
    mark("meet");
    EXPECT_EQ(visits(", parallel: 2", "b").substr(0, 6), "in\nin\n");
    expect_same("a", "b");
}

TEST_F(Parallel, AKilledRunPaysForNothingTwiceAndAnInterruptedOneLeavesNothingRunning) {
    ASSERT_EQ(run_strake({"run", values_case(), "--out", path("whole"), "-q"}).status, 0);
    fs::remove(folder / "calls");
    const std::string file = values_case(", parallel: 3");
    for (const char* what : {"sleep-3", "long-3"}) mark(what);
    const Started run(folder, {"run", file, "--out", path("a"), "-q"});
    std::set<int> ended;
    while (ended.size() < 4) {
        pause_ms(5);
        for (const int number : calls())
            if (fs::exists(folder / text("a/evaluations/00000", number, "/answered"))) ended.insert(number);
    }
    run.send(SIGKILL);
    run.wait();
    fs::remove(folder / "sleep-3");
    EXPECT_EQ(run_strake({"resume", path("a"), "-q"}).status, 0);
    expect_same("whole", "a");
    EXPECT_EQ(ended.count(3), 0u);
    for (const int number : ended) EXPECT_EQ(calls().count(number), 1u) << number;

    for (const char* what : {"sleep-2", "sleep-3", "long-2", "long-3"}) mark(what);
    fs::remove(folder / "sleeping");
    const Started other(folder, {"run", file, "--out", path("b"), "-q"});
    while (!fs::exists(folder / "sleeping")) pause_ms(5);
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
        expect_same("whole", out, true);
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
