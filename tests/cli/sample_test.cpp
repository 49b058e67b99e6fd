#include "cli/program_case.hpp"
#include "core/error.hpp"

/// `strake sample`: a run like others.
namespace strake {
namespace {

class SampleProgram : public ProgramCase {
protected:
    std::string sampled_case(const std::string& more = "") const {
        return external_case(", gradients: false, on_failure: shrink_step" + more, "");
    }
    ProgramRun sample(const std::string& out, int designs, const std::vector<std::string>& more = {}) const {
        std::vector<std::string> arguments{"sample", sampled_case(), "-n", std::to_string(designs), "--out", path(out)};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return run_strake(arguments);
    }
    void expect_equal(const std::string& a, const std::string& b) const {
        for (const char* file : {"history.csv", "samples.csv", "best.obj", "levels/best.design"}) {
            EXPECT_FALSE(bytes_of(folder / a / file).empty()) << file;
            EXPECT_EQ(bytes_of(folder / a / file), bytes_of(folder / b / file)) << file;
        }
    }
};

TEST_F(SampleProgram, GivesTheSameBitsWhateverRunsInParallelAndAfterKills) {
    ASSERT_EQ(sample("whole", 20).status, 0);
    EXPECT_EQ(recorded("whole").size(), 20u);
    mark("jitter");
    for (const int n : {3, 8}) {
        const std::string out = text("n", n);
        const ProgramRun run = sample(out, 20, {"--parallel", std::to_string(n)});
        EXPECT_EQ(run.status, 0) << run.err;
        expect_equal("whole", out);
    }
    fs::remove(folder / "calls");
    for (const char* what : {"sleep-7", "long-7"}) mark(what);
    const Started run(folder, {"sample", sampled_case(), "-n", "20", "--parallel", "3", "--out", path("a"), "-q"});
    while (recorded("a").size() < 6) pause_ms(10);
    run.send(SIGKILL);
    run.wait();
    const std::multiset<int> before = calls();
    const std::set<int> paid = recorded("a");
    fs::remove(folder / "sleep-7");
    fs::remove(folder / "calls");
    EXPECT_EQ(run_strake({"resume", path("a"), "-q"}).status, 0);
    for (const int number : calls()) EXPECT_FALSE(paid.contains(number)) << number << " was paid again";
    expect_equal("whole", "a");
}

TEST_F(SampleProgram, GoesOnWhenMoreAreWantedAndFailedDesignsStay) {
    mark("fail-5");
    ASSERT_EQ(sample("long", 14).status, 0);
    ASSERT_EQ(sample("short", 9).status, 0);
    const ProgramRun more = run_strake({"resume", path("short"), "--evaluations", "+5", "-q"});
    EXPECT_EQ(more.status, 0) << more.err;
    expect_equal("long", "short");
    EXPECT_NE(bytes_of(folder / "long/samples.csv").find("\n5,quantity_failed,"), std::string::npos);
    ASSERT_EQ(sample("lhs", 9, {"--method", "lhs"}).status, 0);
    const ProgramRun fixed = run_strake({"resume", path("lhs"), "--evaluations", "+5"});
    EXPECT_EQ(fixed.status, 0);
    EXPECT_NE(fixed.out.find("use sobol"), std::string::npos) << fixed.out;
}

TEST_F(SampleProgram, TellsMainEffectsAndASearchGoesOnFromThem) {
    const ProgramRun run = sample("s", 16, {"--json"});
    ASSERT_EQ(run.status, 0) << run.err;
    const Json j = Json::parse(run.out);
    EXPECT_EQ(j["status"], "sampled");
    ASSERT_TRUE(j["samples"]["values"].contains("bulk"));
    const Json& effects = j["samples"]["values"]["bulk"]["main_effects"];
    EXPECT_EQ(effects.size(), j["samples"]["variables"].size());
    for (const Json& effect : effects) EXPECT_TRUE(effect["share"].is_number() && effect["error"].is_number());
    folder.write("calls", "");
    const std::string go =
        folder
            .write("go.yaml",
                   bytes_of(sampled_case()) + "optimize: {method: model, start_from: s, budget: {evaluations: 9}}\n")
            .string();
    const ProgramRun on = run_strake({"run", go, "--out", path("on")});
    EXPECT_EQ(on.status, 0) << on.err;
    EXPECT_NE(on.err.find("16 samples are known"), std::string::npos) << on.err;
    EXPECT_LE(calls().size(), 9u);
    EXPECT_GE(Json::parse(bytes_of(folder / "on/run.json"))["objective"].get<double>(), j["objective"].get<double>());
    // The table of one run is one that another reads.
    folder.write("calls", "");
    const ProgramRun read =
        run_strake({"sample", sampled_case(), "--read", path("s/samples.csv"), "--out", path("r"), "-q"});
    EXPECT_EQ(read.status, 0) << read.err;
    EXPECT_EQ(calls().size(), 0u);
    EXPECT_EQ(Json::parse(bytes_of(folder / "r/run.json"))["best_evaluation"], j["best_evaluation"]);
}

TEST_F(SampleProgram, SaysWhatIsWrongWithARemedy) {
    const auto refused = [&](const std::vector<std::string>& arguments, const std::string& words) {
        const ProgramRun run = run_strake(arguments);
        EXPECT_EQ(run.status, 2) << run.err;
        EXPECT_NE(run.err.find(words), std::string::npos) << run.err;
        EXPECT_FALSE(fs::exists(folder / "x"));
    };
    const std::string file = sampled_case();
    refused({"sample", file, "--out", path("x")}, "-n 64");
    refused({"sample", file, "-n", "1", "--out", path("x")}, "--designs");
    const std::string table = folder.write("t.csv", "speed,bulk\n1,2\n").string();
    refused({"sample", file, "--read", table, "--out", path("x"), "-q"}, "there is no column for the variable");
    const std::string none = folder.write("n.csv", "speed,mass\n1,2\n").string();
    refused({"sample", file, "--read", none, "--out", path("x"), "-q"}, "no column is one of the values of the case");
}

}  // namespace
}  // namespace strake
