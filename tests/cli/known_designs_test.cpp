#include "cli/program_case.hpp"
#include "core/error.hpp"

/// What the folder of `start_from` has paid for counts.
namespace strake {
namespace {

class KnownDesigns : public ProgramCase {
protected:
    void SetUp() override {
        ProgramCase::SetUp();
        mark("fail-4");
        const ProgramRun run =
            run_strake({"sample", values_case(), "-n", "12", "--out", path("sampled"), "--parallel", "4", "-q"});
        ASSERT_EQ(run.status, 0) << run.err;
        fs::remove(folder / "calls");
        fs::remove(folder / "fail-4");
    }
    /// @param more keys of the program. @param tail of the case
    std::string values_case(const std::string& more = "", const std::string& tail = "") const {
        return external_case(
            ", gradients: false, on_failure: shrink_step" + more + "}, ratio: {expression: \"bulk / area\"", tail);
    }
    static std::string search(const std::string& from, int evaluations = 17) {
        return text("optimize: {method: model, start_from: ", from, ", budget: {evaluations: ", evaluations, "}}\n");
    }
    ProgramRun run(const std::string& file, const std::string& out) const {
        fs::remove(folder / "calls");
        return run_strake({"run", file, "--out", path(out)});
    }
    double objective(const std::string& out) const {
        return Json::parse(bytes_of(folder / out / "run.json"))["objective"].get<double>();
    }
    static bool says(const ProgramRun& run, const std::string& words) {
        return run.err.find(words) != std::string::npos;
    }
};

TEST_F(KnownDesigns, AreNotPaidAgainAndSaveEvaluations) {
    const ProgramRun told = run(values_case("", search("sampled")), "known");
    EXPECT_EQ(told.status, 0) << told.err;
    EXPECT_TRUE(says(told, "12 designs of ") && says(told, "are known and not paid again")) << told.err;
    EXPECT_TRUE(says(told, "the program was not called")) << told.err;
    const std::size_t paid = calls().size();
    EXPECT_FALSE(calls().contains(1)) << "the start was paid for";
    // The best design alone, without what else is known.
    fs::create_directories(folder / "best_alone");
    fs::copy(folder / "sampled/levels", folder / "best_alone/levels");
    const ProgramRun alone = run(values_case("", search("best_alone")), "alone");
    EXPECT_EQ(alone.status, 0) << alone.err;
    EXPECT_FALSE(says(alone, "are known"));
    EXPECT_EQ(calls().size(), paid + 1);
    EXPECT_GT(objective("known"), objective("alone"));
}

TEST_F(KnownDesigns, GiveTheSameBitsHoweverManyRunInParallelAndAfterAKill) {
    ASSERT_EQ(run(values_case("", search("sampled")), "whole").status, 0);
    for (const int n : {3, 8}) {
        const std::string out = text("n", n);
        EXPECT_EQ(run(values_case(text(", parallel: ", n), search("sampled")), out).status, 0);
        expect_same("whole", out);
    }
    fs::remove(folder / "calls");
    for (const char* what : {"sleep-12", "long-12"}) mark(what);
    const Started killed(folder, {"run", values_case(", parallel: 3", search("sampled")), "--out", path("a"), "-q"});
    while (recorded("a").size() < 10) pause_ms(10);
    killed.send(SIGKILL);
    killed.wait();
    const std::set<int> paid = recorded("a");
    fs::remove(folder / "sleep-12");
    fs::remove(folder / "calls");
    const ProgramRun resumed = run_strake({"resume", path("a"), "-q"});
    EXPECT_EQ(resumed.status, 0) << resumed.err;
    for (const int number : calls()) EXPECT_FALSE(paid.contains(number)) << number << " was paid again";
    expect_same("whole", "a");
    // What it knew has to stay: with more designs it would ask for others.
    ASSERT_EQ(run_strake({"resume", path("sampled"), "--evaluations", "+2", "-q"}).status, 0);
    const ProgramRun refused = run_strake({"resume", path("a"), "--evaluations", "+1", "-q"});
    EXPECT_EQ(refused.status, 2);
    EXPECT_TRUE(says(refused, "optimize.start_from")) << refused.err;
    fs::remove(folder / "sampled/journal.sqlite");
    const ProgramRun gone = run_strake({"resume", path("a"), "--evaluations", "+1", "-q"});
    EXPECT_EQ(gone.status, 2);
    EXPECT_TRUE(says(gone, "they are no longer there")) << gone.err;
}

TEST_F(KnownDesigns, OfAnEarlierRunAndOfATableCount) {
    ASSERT_EQ(run(values_case("", search("sampled")), "first").status, 0);
    const ProgramRun told = run(values_case("", search("first")), "second");
    EXPECT_TRUE(says(told, "are known and not paid again")) << told.err;
    EXPECT_FALSE(calls().contains(1));
    EXPECT_GE(objective("second"), objective("first") * (1 - 1e-9));
    ASSERT_EQ(run_strake({"sample", values_case(), "--read", path("sampled/samples.csv"), "--out", path("table"), "-q"})
                  .status,
              0);
    const ProgramRun read = run(values_case("", search("table")), "third");
    EXPECT_TRUE(says(read, "12 designs of ")) << read.err;
    EXPECT_FALSE(calls().contains(1));
}

/// The case of a sample that says nothing of its variables has fields; so has the search that goes on from it.
TEST_F(KnownDesigns, OfFieldsThatNobodyStatedCount) {
    const auto without_variables = [&](const std::string& file, const std::string& tail) {
        std::string yaml = bytes_of(values_case("", tail));
        const std::string stated = ", variables: [load]";
        yaml.erase(yaml.find(stated), stated.size());
        return folder.write(file, yaml).string();
    };
    const std::string file = without_variables("few.yaml", "");
    ASSERT_EQ(run_strake({"sample", file, "-n", "8", "--out", path("spread"), "-q"}).status, 0);
    const std::string tail = "optimize: {method: model, start_from: spread, budget: {evaluations: 3}}\n";
    const ProgramRun told = run(without_variables("more.yaml", tail), "more");
    EXPECT_EQ(told.status, 0) << told.err;
    EXPECT_TRUE(says(told, "8 designs of ")) << told.err;
    // Loads cannot keep a shape that fields have made: `check` says so, too.
    const std::string loads = values_case("", tail);
    for (const char* command : {"run", "check"}) {
        const ProgramRun refused = run_strake({command, loads});
        EXPECT_EQ(refused.status, 2) << command;
        EXPECT_TRUE(says(refused, "which this case does not have; keep fields, given and planform under parameters"))
            << refused.err;
    }
}

/// Another program, other values, other variables: each is told with its remedy, and nothing wrong is learned.
TEST_F(KnownDesigns, ThatMeanSomethingElseAreNotUsed) {
    const auto changed = [&](const std::string& was, const std::string& is) {
        std::string yaml = bytes_of(values_case("", search("sampled", 3)));
        EXPECT_NE(yaml.find(was), std::string::npos);
        yaml.replace(yaml.find(was), was.size(), is);
        fs::remove_all(folder / "changed");
        return run(folder.write("changed.yaml", yaml).string(), "changed");
    };
    const ProgramRun command = changed("\"-E\", ", "");
    EXPECT_TRUE(says(command, "the program of 'bulk' was called by another command there; use the same command"))
        << command.err;
    EXPECT_TRUE(calls().contains(1));
    const ProgramRun name = changed("ratio:", "quotient:");
    EXPECT_TRUE(says(name, "there is no value called 'quotient'; give it the name that it has there")) << name.err;
    const ProgramRun formula = changed("bulk / area", "bulk / area^2");
    EXPECT_TRUE(says(formula, "the designs that are known are not used: at the same shape 'ratio' was")) << formula.err;
    const ProgramRun kind = changed("variables: [load]", "variables: [normal]");
    EXPECT_TRUE(says(kind, "they differ in variables that this run does not have")) << kind.err;
    EXPECT_FALSE(calls().contains(1)) << "the start is the same design";
}

}  // namespace
}  // namespace strake
