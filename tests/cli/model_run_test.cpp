#include "cli/program_case.hpp"
#include "core/error.hpp"

/// method: model with a program: batches at the same time, the same bits, and nothing paid twice.
namespace strake {
namespace {

class ModelRun : public ProgramCase {
protected:
    std::string model_case(const std::string& more = "", const std::string& options = "method: model, ") const {
        return external_case(", gradients: false" + more, "optimize: {" + options + "budget: {evaluations: 20}}\n");
    }
};

TEST_F(ModelRun, GivesTheSameBitsHoweverManyRunAtTheSameTime) {
    ASSERT_EQ(run_strake({"run", model_case(), "--out", path("whole"), "-q"}).status, 0);
    mark("jitter");
    for (const int n : {3, 8}) {
        const std::string out = text("n", n);
        const ProgramRun run = run_strake({"run", model_case(text(", parallel: ", n)), "--out", path(out), "-q"});
        EXPECT_EQ(run.status, 0) << run.err;
        expect_same("whole", out);
    }
}

TEST_F(ModelRun, KilledInABatchPaysNothingTwice) {
    ASSERT_EQ(run_strake({"run", model_case(), "--out", path("whole"), "-q"}).status, 0);
    fs::remove(folder / "calls");
    const std::string file = model_case(", parallel: 8");
    for (const char* what : {"sleep-5", "long-5"}) mark(what);  // of the first batch, 2 to 9
    const Started run(folder, {"run", file, "--out", path("a"), "-q"});
    std::set<int> ended;
    while (ended.size() < 7) {
        pause_ms(5);
        for (const int number : calls())
            if (fs::exists(folder / text("a/evaluations/00000", number, "/answered"))) ended.insert(number);
    }
    run.send(SIGKILL);
    run.wait();
    fs::remove(folder / "sleep-5");
    EXPECT_EQ(run_strake({"resume", path("a"), "-q"}).status, 0);
    expect_same("whole", "a");
    EXPECT_EQ(ended.count(5), 0u);
    for (const int number : ended) EXPECT_EQ(calls().count(number), 1u) << number;
}

/// A long run: its order of levels, its looks at mirror images, and shapes that it does not pay for come again from
/// what the journal holds.
TEST_F(ModelRun, KilledInALongRunGivesTheSameBits) {
    const std::string long_run =
        "surface: {file: s.obj}\nhold: point\nparameters: {fields: 6, variables: [normal], patches_per_level: [4, "
        "16]}\n" +
        by_program + "optimize: {budget: {evaluations: 80}}\n";
    std::string text = long_run;
    text.replace(text.find('@'), 1, ", gradients: false, parallel: 8");
    const std::string file = folder.write("case.yaml", text).string();
    const ProgramRun whole = run_strake({"run", file, "--out", path("whole")});
    ASSERT_EQ(whole.status, 0) << whole.err;
    EXPECT_NE(whole.err.find("method: auto chooses model"), std::string::npos) << whole.err;
    fs::remove(folder / "calls");
    const Started run(folder, {"run", file, "--out", path("a"), "-q"});
    while (!run.has_ended() && calls().size() < 40) pause_ms(10);
    EXPECT_FALSE(run.has_ended()) << "after " << calls().size() << " calls";
    run.send(SIGKILL);
    run.wait();
    const ProgramRun rest = run_strake({"resume", path("a"), "-q"});
    ASSERT_EQ(rest.status, 0) << rest.err;
    expect_same("whole", "a");
}

TEST_F(ModelRun, IsChosenWhereTheBudgetIsShortAndSaysSo) {
    const ProgramRun checked = run_strake({"check", model_case("", "")});
    EXPECT_NE(checked.out.find("method: auto chooses model, in batches of 8: 'bulk' has no gradient"),
              std::string::npos)
        << checked.out;
    const ProgramRun run = run_strake({"run", model_case("", ""), "--out", path("auto")});
    EXPECT_EQ(run.status, 0) << run.err;
    EXPECT_NE(run.err.find("method: auto chooses model"), std::string::npos) << run.err;
    ASSERT_EQ(run_strake({"run", model_case(), "--out", path("stated"), "-q"}).status, 0);
    expect_same("stated", "auto");
    // A raised budget does not change what was chosen.
    ASSERT_EQ(run_strake({"resume", path("auto"), "--evaluations", "+60", "-q"}).status, 0);
    const std::string all = bytes_of(folder / "auto/history.csv"), before = bytes_of(folder / "stated/history.csv");
    EXPECT_EQ(all.substr(0, before.size()), before);
}

}  // namespace
}  // namespace strake
