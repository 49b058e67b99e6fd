#include "cli/program_case.hpp"
#include "core/error.hpp"

/// `strake step`: a run whose programs somebody else starts.
namespace strake {
namespace {

class Step : public ProgramCase {
protected:
    const std::string differences = "optimize: {finite_differences: true, budget: {evaluations: 14}}\n";
    std::string values_case(const std::string& more = "") const {
        return external_case(", gradients: false" + more, differences);
    }
    ProgramRun step(const std::string& file, bool json = false) const {
        std::vector<std::string> arguments{"step", file, "--out", path("stepped"), "-q"};
        if (json) arguments.push_back("--json");
        return run_strake(arguments);
    }
    static std::vector<std::string> lines(const std::string& text) {
        std::vector<std::string> all;
        std::istringstream in(text);
        for (std::string line; std::getline(in, line);) all.push_back(line);
        return all;
    }
    static int answer(const std::string& where) {
        return WEXITSTATUS(std::system(text("sh ", where, "/command.sh").c_str()));
    }
    /// Steps and answers, in reverse order, until the run ends. @return how many folders each step handed out.
    std::vector<std::size_t> drive(const std::string& file, int& status) const {
        std::vector<std::size_t> handed;
        for (int k = 0; k < 100; ++k) {
            const ProgramRun run = step(file);
            status = run.status;
            if (status != 0) return handed;
            std::vector<std::string> folders = lines(run.out);
            if (folders.empty()) return handed;
            handed.push_back(folders.size());
            for (auto where = folders.rbegin(); where != folders.rend(); ++where) EXPECT_EQ(answer(*where), 0);
        }
        return handed;
    }
};

TEST_F(Step, DrivenToTheEndTheHistoryIsThatOfRun) {
    const std::string file = external_case();
    undisturbed();
    int status = -1;
    const std::vector<std::size_t> handed = drive(file, status);
    EXPECT_EQ(status, 0);
    EXPECT_EQ(handed.size(), calls().size());
    for (const int number : calls()) EXPECT_EQ(calls().count(number), 1u) << number;
    expect_same("whole", "stepped");
    const ProgramRun again = step(file, true);
    EXPECT_EQ(again.status, 0);
    EXPECT_EQ(Json::parse(again.out)["status"], Json::parse(bytes_of(folder / "whole/run.json"))["status"]);
}

/// What the case leaves to the run stays that of its first step.
TEST_F(Step, ARunThatSaysNothingOfItsVariablesGoesOn) {
    std::string text =
        "surface: {file: s.obj}\nhold: point\nparameters: {max_displacement: 5%}\n" + budget + by_program;
    text.replace(text.find('@'), 1, "");
    text.erase(text.find("constraints:"));  // without any, `split` is chosen, too
    const std::string file = folder.write("case.yaml", text).string();
    int status = -1;
    EXPECT_GE(drive(file, status).size(), 3u);
    EXPECT_EQ(status, 0) << "its first step resolved more than it says";
    EXPECT_NE(bytes_of(folder / "stepped/case.yaml").find("split: sensitivity"), std::string::npos);
}

TEST_F(Step, TheLineThatSaysHowItGoesOnCanBeCopied) {
    const std::string file = external_case();
    const ProgramRun run = run_strake({"step", file, "--out", path("by hand")});
    EXPECT_EQ(run.status, 0) << run.err;
    EXPECT_NE(run.err.find(text("then `strake step ", file, " --out '", path("by hand"), "'` again")),
              std::string::npos)
        << run.err;
}

TEST_F(Step, ABatchIsHandedOutAtOnceAndTheNumbersStayThose) {
    ASSERT_EQ(run_strake({"run", values_case(), "--out", path("whole"), "-q"}).status, 0);
    fs::remove(folder / "calls");
    int status = -1;
    const std::vector<std::size_t> handed = drive(values_case(", parallel: 4"), status);
    EXPECT_EQ(status, 0);
    EXPECT_EQ(*std::max_element(handed.begin(), handed.end()), 4u);
    expect_same("whole", "stepped");
}

TEST_F(Step, WaitsAsLongAsItTakesAndPicksUpWhatIsThere) {
    const std::string file = values_case(", parallel: 3");
    ASSERT_EQ(step(file).status, 0);
    const ProgramRun waiting = step(file, true);
    EXPECT_EQ(waiting.status, 0);
    const Json told = Json::parse(waiting.out);
    EXPECT_EQ(told["status"], "waiting");
    ASSERT_EQ(told["awaited"].size(), 1u);
    const std::string first = told["awaited"][0]["folder"];
    EXPECT_EQ(told["awaited"][0]["command"][0], "python3");
    for (const char* name : {"surface.obj", "request.json", "command.sh"})
        EXPECT_TRUE(fs::exists(fs::path(first) / name));
    EXPECT_EQ(Json::parse(run_strake({"status", path("stepped"), "--json"}).out)["status"], "waiting");
    // A program that is at work has written nothing that counts.
    std::ofstream(fs::path(first) / "result.json") << "{\"val";
    std::ofstream(fs::path(first) / "running") << "";
    EXPECT_EQ(step(file).status, 0);
    EXPECT_EQ(recorded("stepped").size(), 0u);
    ASSERT_EQ(answer(first), 0);
    const std::vector<std::string> batch = lines(step(file).out);
    ASSERT_EQ(batch.size(), 3u) << "all that may run at the same time";
    ASSERT_EQ(answer(batch[2]), 0);
    EXPECT_EQ(lines(step(file).out).size(), 3u) << "the next takes its place";
    EXPECT_EQ(recorded("stepped").size(), 1u) << "but the first of the batch is still awaited";
}

TEST_F(Step, AFailureIsReportedRetriedAndEndsTheRun) {
    const std::string file = values_case(", retries: 1");
    mark("fail-1");
    const std::string first = lines(step(file).out).at(0);
    EXPECT_EQ(answer(first), 1);
    const std::string second = lines(step(file).out).at(0);
    EXPECT_EQ(second, text(first, "-2"));
    EXPECT_EQ(answer(second), 1);
    const ProgramRun failed = step(file);
    EXPECT_EQ(failed.status, 5);
    EXPECT_NE(failed.err.find("reported"), std::string::npos) << failed.err;
    EXPECT_NE(failed.err.find("licence server is down"), std::string::npos) << failed.err;
    fs::remove(folder / "fail-1");
    fs::remove(fs::path(second) / "failed");
    EXPECT_EQ(answer(second), 0);
    EXPECT_EQ(step(file).status, 0);
    EXPECT_EQ(recorded("stepped").size(), 1u);
}

TEST_F(Step, GradientCommandsAreHandedOutInTheFoldersOfTheirValues) {
    undisturbed();
    const std::string file = external_case(gradients_apart);
    const std::string first = lines(step(file).out).at(0);
    EXPECT_EQ(answer(first), 0);
    const Json told = Json::parse(step(file, true).out);
    ASSERT_EQ(told["awaited"].size(), 1u);
    EXPECT_EQ(told["awaited"][0]["folder"], first) << "the gradient of the same evaluation";
    EXPECT_EQ(told["awaited"][0]["request"], first + "/gradient_request.json");
    EXPECT_EQ(told["awaited"][0]["command"].back(), first + "/gradient.json");
    EXPECT_TRUE(fs::exists(fs::path(first) / "gradient-awaited"));
    int status = -1;
    drive(file, status);
    EXPECT_EQ(status, 0);
    expect_same("whole", "stepped", true);
    for (const char* each : {"calls", "gradient-calls"})
        for (const int number : calls(each)) EXPECT_EQ(calls(each).count(number), 1u) << each << number;
    EXPECT_LE(calls("gradient-calls").size(), calls().size());
}

TEST_F(Step, AGradientCommandThatFailsIsReportedAndRetried) {
    const std::string file = external_case(gradients_apart + ", retries: 1");
    mark("gradient-fail-1");
    const std::string first = lines(step(file).out).at(0);
    EXPECT_EQ(answer(first), 0);
    for (int attempt = 0; attempt < 2; ++attempt) {
        EXPECT_EQ(lines(step(file).out).at(0), first);
        EXPECT_EQ(answer(first), 1);
    }
    const ProgramRun failed = step(file);
    EXPECT_EQ(failed.status, 5);
    EXPECT_NE(failed.err.find("gradient: the file 'gradient-2-failed' is there"), std::string::npos) << failed.err;
    fs::remove(folder / "gradient-fail-1");
    fs::remove(fs::path(first) / "gradient-2-failed");
    EXPECT_EQ(answer(first), 0);
    EXPECT_NE(lines(step(file).out).at(0), first) << "the next";
    EXPECT_EQ(calls().count(1), 1u);
    EXPECT_TRUE(recorded("stepped").contains(1));
}

/// What a case that says nothing of its variables has by default may depend on the budget, and on the release.
TEST_F(Step, ALargerBudgetKeepsTheVariablesThatTheRunBeganWith) {
    const auto with = [&](int evaluations, const std::string& fields) {
        std::string yaml = bytes_of(
            external_case(", gradients: false", text("optimize: {budget: {evaluations: ", evaluations, "}}\n")));
        const std::string variables = ", variables: [load]";
        yaml.replace(yaml.find(variables), variables.size(), fields);
        return folder.write("case.yaml", yaml).string();
    };
    for (const std::string began : {"", ", fields: auto, variables: [load]", ", fields: none"}) {
        fs::remove_all(folder / "stepped");
        ASSERT_EQ(step(with(10, began)).status, 0);
        const ProgramRun again = step(with(began.empty() ? 1100 : 100, ""));  // whose defaults are none and auto
        EXPECT_EQ(again.status, 0) << again.err;
        const std::string yaml = bytes_of(folder / "stepped/case.yaml");
        EXPECT_EQ(yaml.find("fields: auto") != std::string::npos, began != ", fields: none") << yaml;
        EXPECT_EQ(yaml.find("variables: [normal]") != std::string::npos, began.empty()) << yaml;
    }
    EXPECT_EQ(step(with(1100, ", fields: auto")).status, 2) << "stated: another case";
}

TEST_F(Step, KeepsThePointThatHoldsTheRun) {
    std::string yaml = bytes_of(external_case(", gradients: false", ""));
    for (const std::string said : {", variables: [load]", "fixed: [root]\n"}) {
        ASSERT_NE(yaml.find(said), std::string::npos) << yaml;
        yaml.erase(yaml.find(said), said.size());
    }
    const std::string file = folder.write("case.yaml", yaml).string();
    ASSERT_EQ(step(file).status, 0);
    EXPECT_NE(bytes_of(folder / "stepped/case.yaml").find("hold: point"), std::string::npos);
    const ProgramRun again = step(file);
    EXPECT_EQ(again.status, 0) << again.err;
}

TEST_F(Step, AnotherCaseOrFolderIsRefused) {
    ASSERT_EQ(step(values_case()).status, 0);
    const ProgramRun other = step(external_case(", gradients: false, retries: 3", differences));
    EXPECT_EQ(other.status, 2);
    EXPECT_NE(other.err.find("quantities.bulk.retries"), std::string::npos) << other.err;
    fs::create_directory(folder / "full");
    folder.write("full/file", "x");
    EXPECT_EQ(run_strake({"step", values_case(), "--out", path("full")}).status, 4);
}

}  // namespace
}  // namespace strake
