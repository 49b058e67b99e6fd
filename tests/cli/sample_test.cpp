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
    ASSERT_EQ(sample("whole", 12).status, 0);
    EXPECT_EQ(recorded("whole").size(), 12u);
    mark("jitter");
    for (const int n : {3, 8}) {
        const std::string out = text("n", n);
        const ProgramRun run = sample(out, 12, {"--parallel", std::to_string(n)});
        EXPECT_EQ(run.status, 0) << run.err;
        expect_equal("whole", out);
    }
    fs::remove(folder / "calls");
    for (const char* what : {"sleep-7", "long-7"}) mark(what);
    const Started run(folder, {"sample", sampled_case(), "-n", "12", "--parallel", "3", "--out", path("a"), "-q"});
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
    ASSERT_EQ(sample("long", 10).status, 0);
    ASSERT_EQ(sample("short", 7).status, 0);
    const ProgramRun more = run_strake({"resume", path("short"), "--evaluations", "+3", "-q"});
    EXPECT_EQ(more.status, 0) << more.err;
    expect_equal("long", "short");
    EXPECT_NE(bytes_of(folder / "long/samples.csv").find("\n5,quantity_failed,"), std::string::npos);
    ASSERT_EQ(sample("lhs", 4, {"--method", "lhs"}).status, 0);
    const ProgramRun fixed = run_strake({"resume", path("lhs"), "--evaluations", "+5"});
    EXPECT_EQ(fixed.status, 0);
    EXPECT_NE(fixed.out.find("use sobol"), std::string::npos) << fixed.out;
}

TEST_F(SampleProgram, TellsMainEffectsAndASearchGoesOnFromThem) {
    const ProgramRun run = sample("s", 12, {"--json"});
    ASSERT_EQ(run.status, 0) << run.err;
    const Json j = Json::parse(run.out);
    EXPECT_EQ(j["status"], "sampled");
    ASSERT_TRUE(j["samples"]["values"].contains("bulk"));
    const Json& effects = j["samples"]["values"]["bulk"]["main_effects"];
    EXPECT_EQ(effects.size(), j["samples"]["variables"].size());
    for (const Json& effect : effects)
        EXPECT_TRUE(effect["share"].is_number() && effect["error"].is_number() && effect["total"].is_number());
    folder.write("calls", "");
    const std::string go =
        folder
            .write("go.yaml",
                   bytes_of(sampled_case()) + "optimize: {method: cobyla, start_from: s, budget: {evaluations: 4}}\n")
            .string();
    const ProgramRun on = run_strake({"run", go, "--out", path("on")});
    EXPECT_EQ(on.status, 0) << on.err;
    // It starts at the best of the samples.
    const Json end = Json::parse(bytes_of(folder / "on/run.json"));
    EXPECT_NEAR(end["objective_start"].get<double>(), j["objective"].get<double>(),
                1e-9 * j["objective"].get<double>());
    EXPECT_NE(j["best_evaluation"], 1);
    // The table of one run is one that another reads.
    folder.write("calls", "");
    const ProgramRun read =
        run_strake({"sample", sampled_case(), "--read", path("s/samples.csv"), "--out", path("r"), "-q"});
    EXPECT_EQ(read.status, 0) << read.err;
    EXPECT_EQ(calls().size(), 0u);
    EXPECT_EQ(Json::parse(bytes_of(folder / "r/run.json"))["best_evaluation"], j["best_evaluation"]);
}

TEST_F(SampleProgram, SaysWhatIsWrongWithARemedy) {
    const auto refused = [&](const std::vector<std::string>& arguments, const std::string& words, int status = 2) {
        const ProgramRun run = run_strake(arguments);
        EXPECT_EQ(run.status, status) << run.err;
        EXPECT_NE(run.err.find(words), std::string::npos) << run.err;
        EXPECT_FALSE(fs::exists(folder / "x"));
    };
    const std::string file = sampled_case();
    refused({"sample", file, "--out", path("x")}, "-n 64");
    refused({"sample", file, "-n", "1", "--out", path("x")}, "--designs");
    refused({"sample", file, "-n", "9", "--seed", "2", "--out", path("x")}, "--seed is for --method lhs");
    refused({"sample", file, "-n", "9", "--method", "levels", "--out", path("x"), "-q"}, "take method sobol or lhs");
    const auto refused_table = [&](const std::string& table, const std::string& words) {
        const std::string name = folder.write("t.csv", table).string();
        refused({"sample", file, "--read", name, "--out", path("x"), "-q"}, words);
    };
    refused({"sample", file, "--read", path("none.csv"), "--out", path("x")}, "no such file; give a table", 3);
    refused_table("speed,bulk\n1,2\n", "there is no column for the variable");
    refused_table("speed,mass\n1,2\n", "no column is one of the values of the case");
    refused_table("speed,bulk\nnan,2\n", "column 'speed': 'nan' is not a finite number; correct it, or remove the row");
    refused_table("speed,bulk\n1,2,3\n", "has 3 fields, the first line names 2 columns");
    refused_table("speed,bulk\n", "there is no row below");
}

/// Two values of one call; with no --method and no finite differences, too.
TEST_F(SampleProgram, RefusesATableWithSomeOfTheValuesOfAProgram) {
    std::string two = bytes_of(sampled_case(", outputs: [volume, mass]"));
    two.replace(two.find("maximize: bulk"), 14, "maximize: bulk.mass");
    const std::string file = folder.write("two.yaml", two).string();
    const std::string table = folder.write("t.csv", "x,bulk.mass\n0,1\n").string();
    const ProgramRun run = run_strake({"sample", file, "--read", table, "--out", path("x"), "-q"});
    EXPECT_EQ(run.status, 2) << run.err;
    EXPECT_NE(run.err.find("a column for bulk.mass, and none for bulk.volume"), std::string::npos) << run.err;
    EXPECT_TRUE(calls().empty());
}

/// The case says how; the command line has the last word, and all of it stands in the folder for `resume`.
TEST_F(SampleProgram, TakesTheMethodOfTheCaseUnlessToldAnother) {
    const std::string file =
        folder.write("lhs.yaml", bytes_of(sampled_case()) + "sample: {method: lhs}\noptimize: {seed: 3}\n").string();
    const auto samples = [&](const std::string& out, const std::vector<std::string>& more) {
        std::vector<std::string> arguments{"sample", file, "-n", "3", "--out", path(out), "-q"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        const ProgramRun run = run_strake(arguments);
        EXPECT_EQ(run.status, 0) << run.err;
        return bytes_of(folder / out / "samples.csv");
    };
    const std::string of_case = samples("a", {}), of_seed = samples("b", {"--seed", "4"}),
                      of_word = samples("c", {"--method", "sobol"});
    EXPECT_EQ(of_case, samples("d", {"--method", "lhs", "--seed", "3"}));
    EXPECT_EQ(of_case, samples("e", {"--set", "sample.method=sobol", "--set", "sample={method: lhs}", "--seed", "3"}));
    EXPECT_NE(of_case, of_seed);
    EXPECT_NE(of_case, of_word);
    EXPECT_NE(bytes_of(folder / "b/case.yaml").find("seed: 4"), std::string::npos);
}

}  // namespace
}  // namespace strake
