#include "cli/program_case.hpp"

/// `output: {keep: ...}`: which folders of evaluations stay, and that nothing is paid twice when they have gone.
namespace strake {
namespace {

class Keep : public ProgramCase {
protected:
    std::string keeping(const std::string& policy, const std::string& more = "") const {
        return external_case(more, budget + "output: {keep: " + policy + "}\n");
    }
    std::set<std::string> folders(const std::string& out) const {
        std::set<std::string> names;
        std::error_code none;
        for (const auto& entry : fs::directory_iterator(folder / out / "evaluations", none))
            names.insert(entry.path().filename().string());
        return names;
    }
    int best_of(const std::string& out) const {
        return Json::parse(bytes_of(folder / out / "run.json"))["best_evaluation"];
    }
    static std::string name_of(int evaluation) {
        char name[16];
        std::snprintf(name, sizeof name, "%06d", evaluation);
        return name;
    }
    void succeeds(const std::vector<std::string>& arguments, int status = 0) const {
        const ProgramRun run = run_strake(arguments);
        EXPECT_EQ(run.status, status) << run.err;
    }
};

TEST_F(Keep, PoliciesLeaveWhatTheySayAndTheRunIsTheSame) {
    undisturbed();
    ASSERT_GE(folders("whole").size(), 4U);  // all, by default
    for (const std::string policy : {"failed", "best", "none"}) {
        succeeds({"run", keeping(policy), "--out", path(policy), "-q"});
        expect_same("whole", policy);
    }
    EXPECT_TRUE(folders("failed").empty());
    EXPECT_TRUE(folders("none").empty());
    EXPECT_EQ(folders("best"), std::set<std::string>{name_of(best_of("best"))});
    EXPECT_FALSE(bytes_of(folder / "best/evaluations" / name_of(best_of("best")) / "result.json").empty());
}

TEST_F(Keep, FailedOnesStayWithAllOfTheirAttempts) {
    mark("fail-3");
    mark("once-2");  // the first attempt fails, the second does not: the evaluation is a success
    succeeds({"run", keeping("failed", ", on_failure: shrink_step, retries: 1"), "--out", path("out"), "-q"});
    EXPECT_EQ(folders("out"), (std::set<std::string>{"000003", "000003-2"}));
    EXPECT_NE(bytes_of(folder / "out/evaluations/000003/stderr.log").find("licence server"), std::string::npos);
}

TEST_F(Keep, AnAbortKeepsItsFolderUnderEveryPolicyAndGoesOn) {
    undisturbed();
    mark("fail-4");
    succeeds({"run", keeping("none"), "--out", path("out"), "-q"}, 5);
    EXPECT_EQ(folders("out"), std::set<std::string>{"000004"});
    fs::remove(folder / "fail-4");
    fs::remove(folder / "calls");
    succeeds({"resume", path("out"), "-q"});
    EXPECT_TRUE(folders("out").empty());
    EXPECT_EQ(calls().count(1) + calls().count(2) + calls().count(3), 0U);
    expect_same("whole", "out");
}

TEST_F(Keep, ARaisedBudgetPaysForNothingAgain) {
    succeeds({"run", keeping("best"), "--out", path("out"), "-q"});
    const auto before = calls();
    fs::remove(folder / "calls");
    succeeds({"resume", path("out"), "--evaluations", "14", "-q"});
    for (const int number : calls()) EXPECT_EQ(before.count(number), 0U) << number;
}

TEST_F(Keep, GradientsThatMayStillBeAskedForFindTheirFolder) {
    undisturbed();
    succeeds({"run", keeping("none", gradients_apart), "--out", path("apart"), "-q"});
    expect_same("whole", "apart", true);
    EXPECT_LE(folders("apart").size(), 3U);  // the last, the best, the best of the level
    const auto before = calls(), gradients = calls("gradient-calls");
    EXPECT_EQ(before.size(), std::set<int>(before.begin(), before.end()).size());
    fs::remove(folder / "calls");
    fs::remove(folder / "gradient-calls");
    succeeds({"resume", path("apart"), "--evaluations", "16", "-q"});
    for (const int number : calls()) EXPECT_EQ(before.count(number), 0U) << number;
    for (const int number : calls("gradient-calls")) EXPECT_EQ(gradients.count(number), 0U) << number;
}

TEST_F(Keep, AKillAtAnyMomentLosesNothingAndLeavesNothing) {
    undisturbed();
    mark("jitter");
    const std::string case_file = keeping("failed");
    Started first(folder, {"run", case_file, "--out", path("out"), "-q"});
    for (int k = 0; k < 40 && recorded("out").size() < 4 && !first.has_ended(); ++k) pause_ms(50);
    first.send(SIGKILL);
    first.wait();
    const std::set<int> known = recorded("out");
    fs::remove(folder / "calls");
    succeeds({"resume", path("out"), "-q"});
    for (const int number : calls()) EXPECT_EQ(known.count(number), 0U) << number;
    EXPECT_TRUE(folders("out").empty());
    expect_same("whole", "out");
}

TEST_F(Keep, FieldsOfProgramsOutliveTheirFolders) {
    // Each design brings its own field: its number at every vertex.
    std::string words = program;
    words.replace(words.find("answer = "), 9,
                  "open(\"cp.csv\", \"w\").writelines(\"%d,%d\\n\" % (k, number) for k in range(len(p)))\n"
                  "answer = {\"fields\": {\"cp\": \"cp.csv\"}}\nanswer |= ");
    folder.write("bulk.py", words);
    succeeds({"run", keeping("failed"), "--out", path("out"), "-q"});
    EXPECT_TRUE(folders("out").empty());
    std::map<std::string, std::string> before;
    for (const auto& entry : fs::directory_iterator(folder / "out/series"))
        before[entry.path().filename().string()] = bytes_of(entry.path());
    ASSERT_GE(before.size(), 2U);
    for (const auto& [name, bytes] : before) EXPECT_NE(bytes.find("Name=\"cp\""), std::string::npos) << name;
    succeeds({"resume", path("out"), "--evaluations", "12", "-q"});
    for (const auto& [name, bytes] : before) EXPECT_EQ(bytes, bytes_of(folder / "out/series" / name)) << name;
}

}  // namespace
}  // namespace strake
