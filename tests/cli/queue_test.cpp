#include "cli/program_case.hpp"
#include "core/error.hpp"

#include <optional>

/// Evaluations as jobs of Slurm: a fake one, and, where it is installed, a real one of a single node.
namespace strake {
namespace {

const std::string differences = "optimize: {finite_differences: true, budget: {evaluations: 8}}\n";
const std::string twenty = "optimize: {finite_differences: true, budget: {evaluations: 20}}\n";
const std::string no_gradients = ", gradients: false";

class Queue : public ProgramCase {
protected:
    void SetUp() override {
        ProgramCase::SetUp();
        old_path_ = std::getenv("PATH");
        fs::create_directory(folder / "slurm");
        setenv("FAKE_SLURM_DIR", path("slurm").c_str(), 1);
        setenv("PATH", text(FAKE_SLURM, ":", old_path_).c_str(), 1);
    }
    void TearDown() override { setenv("PATH", old_path_.c_str(), 1); }
    std::string job_case(const std::string& more = "") const {
        return external_case(no_gradients + ", scheduler: {slurm: [--partition=main], poll: 0.2s}" + more, differences);
    }
    void ask_whole() const {
        ASSERT_EQ(run_strake({"run", external_case(no_gradients, differences), "--out", path("whole"), "-q"}).status,
                  0);
        fs::remove(folder / "calls");
    }
    void say(const std::string& what, const std::string& words = "") const { folder.write("slurm/" + what, words); }
    std::size_t lines(const std::string& what) const {
        const std::string all = bytes_of(folder / "slurm" / what);
        return static_cast<std::size_t>(std::count(all.begin(), all.end(), '\n'));
    }
    ProgramRun run(const std::string& file, const std::string& out) const {
        return run_strake({"run", file, "--out", path(out), "-q"});
    }

private:
    std::string old_path_;
};

TEST_F(Queue, JobsGiveTheBitsOfARunWithoutAQueue) {
    ask_whole();
    const ProgramRun jobs = run(job_case(", parallel: 3"), "jobs");
    EXPECT_EQ(jobs.status, 0) << jobs.err;
    expect_same("whole", "jobs");
    EXPECT_EQ(lines("submitted"), calls().size());
    EXPECT_NE(bytes_of(folder / "slurm/submitted").find("--partition=main"), std::string::npos);
    EXPECT_FALSE(bytes_of(folder / "jobs/evaluations/000001/job").empty());
}

TEST_F(Queue, AStartAfterAKillFollowsTheSameJob) {
    ask_whole();
    mark("sleep-2");
    const Started killed(folder, {"run", job_case(), "--out", path("a"), "-q"});
    while (!fs::exists(folder / "sleeping")) pause_ms(5);
    killed.send(SIGKILL);
    killed.wait();
    const std::size_t before = lines("submitted");
    fs::remove(folder / "a/evaluations/000002/job");  // as if it had been killed before it was told the number
    EXPECT_EQ(run_strake({"resume", path("a"), "-q"}).status, 0);
    expect_same("whole", "a");
    EXPECT_EQ(before, 2u);
    EXPECT_EQ(lines("submitted"), calls().size());
    for (const int number : calls()) EXPECT_EQ(calls().count(number), 1u) << number;
}

TEST_F(Queue, AnInterruptLeavesTheJobAndSaysSo) {
    ask_whole();
    mark("sleep-2");
    const Started asked(folder, {"run", job_case(), "--out", path("a"), "-q"});
    while (!fs::exists(folder / "sleeping")) pause_ms(5);
    asked.send(SIGINT);
    EXPECT_EQ(asked.wait(), 75);
    EXPECT_NE(asked.messages().find("job 2 (bulk, evaluation 2)"), std::string::npos) << asked.messages();
    EXPECT_EQ(lines("cancelled"), 0u);
    EXPECT_EQ(run_strake({"resume", path("a"), "-q"}).status, 0);
    expect_same("whole", "a");
    EXPECT_EQ(calls().count(2), 1u);
}

TEST_F(Queue, WhatCanNeverStartIsFoundAndCancelled) {
    say("pending", "PartitionConfig");
    const ProgramRun never = run(job_case(), "a");
    EXPECT_EQ(never.status, 5);
    EXPECT_NE(never.err.find("never_starts"), std::string::npos) << never.err;
    EXPECT_NE(never.err.find("PartitionConfig"), std::string::npos) << never.err;
    EXPECT_EQ(lines("cancelled"), 1u);
    say("pending", "Resources");
    const ProgramRun waited =
        run(external_case(no_gradients + ", scheduler: {slurm: [], wait: 1s, poll: 0.2s}", differences), "b");
    EXPECT_EQ(waited.status, 5);
    EXPECT_NE(waited.err.find("did not start within 1 s, pending for Resources"), std::string::npos) << waited.err;
    EXPECT_EQ(lines("cancelled"), 2u);
}

TEST_F(Queue, FailuresOfJobsAreNamed) {
    say("refuse");
    const ProgramRun refused = run(job_case(), "a");
    EXPECT_EQ(refused.status, 5);
    EXPECT_NE(refused.err.find("submit: "), std::string::npos) << refused.err;
    EXPECT_NE(refused.err.find("Invalid partition name"), std::string::npos) << refused.err;
    fs::remove(folder / "slurm/refuse");
    mark("fail-1");
    const ProgramRun failed = run(job_case(), "b");
    EXPECT_EQ(failed.status, 5);
    EXPECT_NE(failed.err.find("exit status 1"), std::string::npos) << failed.err;
    EXPECT_NE(failed.err.find("licence server is down"), std::string::npos) << failed.err;
    fs::remove(folder / "fail-1");
    EXPECT_EQ(run_strake({"resume", path("b"), "-q"}).status, 0) << "a job that failed is submitted anew";
    mark("sleep-1");
    const ProgramRun late = run(job_case(", timeout: 1s"), "c");
    EXPECT_EQ(late.status, 5);
    EXPECT_NE(late.err.find("longer than the timeout of 1 s"), std::string::npos) << late.err;
}

TEST_F(Queue, AJobThatIsCancelledByOthersIsTriedAgain) {
    ask_whole();
    mark("sleep-2");
    const Started asked(folder, {"run", job_case(", retries: 1"), "--out", path("a")});
    while (!fs::exists(folder / "sleeping")) pause_ms(5);
    fs::remove(folder / "sleep-2");
    EXPECT_EQ(std::system("scancel 2"), 0);
    EXPECT_EQ(asked.wait(), 0) << asked.messages();
    EXPECT_NE(asked.messages().find("vanished: "), std::string::npos) << asked.messages();
    expect_same("whole", "a");
    EXPECT_EQ(calls().count(2), 2u);
}

/// A full disk leaves the file of the exit status empty, or cut: with a whole result beside it that is no success.
TEST_F(Queue, AnEmptyOrCutExitStatusIsNoSuccess) {
    for (const std::string left : {"", "0"}) {
        SCOPED_TRACE("'" + left + "'");
        const std::string out = left.empty() ? "a" : "b";
        mark("sleep-2");
        mark("long-2");
        fs::remove(folder / "sleeping");
        const std::size_t job = lines("submitted") + 2;
        const Started asked(folder, {"run", job_case(), "--out", path(out), "-q"});
        while (!fs::exists(folder / "sleeping")) pause_ms(5);
        const std::string place = out + "/evaluations/000002/";
        folder.write(place + "result.json", "{\"value\": 1}");
        folder.write(place + "exit", left);
        EXPECT_EQ(std::system(("scancel " + std::to_string(job)).c_str()), 0);
        EXPECT_EQ(asked.wait(), 5) << asked.messages();
        const std::string words =
            left.empty() ? "its file exit is empty" : "its file exit holds '0' and no exit status";
        EXPECT_NE(asked.messages().find(words), std::string::npos) << asked.messages();
        fs::remove_all(folder / "calls");
    }
}

TEST_F(Queue, AbortCancelsTheOtherJobs) {
    mark("fail-2");
    mark("sleep-3");
    const ProgramRun aborted = run(job_case(", parallel: 3"), "a");
    EXPECT_EQ(aborted.status, 5) << aborted.err;
    EXPECT_GE(lines("cancelled"), 1u);
}

TEST_F(Queue, GradientCommandsAreJobsThatAreFollowedToo) {
    undisturbed();
    mark("gradient-sleep-1");
    const std::string file = external_case(gradients_apart + ", scheduler: {slurm: [], poll: 0.2s}");
    const Started killed(folder, {"run", file, "--out", path("a"), "-q"});
    while (!fs::exists(folder / "sleeping")) pause_ms(5);
    killed.send(SIGKILL);
    killed.wait();
    EXPECT_EQ(lines("submitted"), 2u);
    EXPECT_EQ(run_strake({"resume", path("a"), "-q"}).status, 0);
    expect_same("whole", "a", true);
    EXPECT_EQ(lines("submitted"), calls().size() + calls("gradient-calls").size());
    EXPECT_EQ(calls("gradient-calls").count(1), 1u) << "the same job";
    for (const char* name : {"gradient-job", "gradient-exit", "gradient-stdout.log", "gradient-job.sh", "job.sh"})
        EXPECT_TRUE(fs::exists(folder / "a/evaluations/000001" / name)) << name;
}

/// A real Slurm of one node, with a queue of its own.
class RealSlurm : public ProgramCase {
protected:
    void SetUp() override {
        if (!std::getenv("STRAKE_SLURM")) GTEST_SKIP() << "run by ./test.sh --slurm";  // starts a cluster of its own
        const char* const needed =
            "command -v slurmctld sbatch munged /usr/sbin/slurmctld /usr/sbin/munged > /dev/null";
        if (std::system(needed) >> 8 == 127)
            GTEST_SKIP() << "slurm-wlm and munge are not installed";  // large, for these tests alone
        ProgramCase::SetUp();
        is_up_ = true;
        ASSERT_EQ(std::system(text(SLURM_SCRIPT, " up ", path("slurm"), " 4").c_str()), 0);
        setenv("SLURM_CONF", path("slurm/slurm.conf").c_str(), 1);
    }
    void TearDown() override {
        if (is_up_) std::system(text(SLURM_SCRIPT, " down ", path("slurm")).c_str());
    }

private:
    bool is_up_ = false;
};

/// Twenty evaluations as jobs of a real Slurm, one cancelled by hand, and a restart in the middle.
TEST_F(RealSlurm, EachEvaluationIsPaidOnce) {
    ASSERT_EQ(run_strake({"run", external_case(no_gradients, twenty), "--out", path("whole"), "-q"}).status, 0);
    fs::remove(folder / "calls");
    const std::string file =
        external_case(no_gradients + ", retries: 1, parallel: 4, scheduler: {slurm: [--partition=main]}", twenty);
    mark("sleep-3");
    mark("sleep-16");  // of level 2, which begins when all of level 1 is there
    const auto begin = std::chrono::steady_clock::now();
    const Started run(folder, {"run", file, "--out", path("jobs")});
    while (!fs::exists(folder / "sleeping")) pause_ms(5);
    fs::remove(folder / "sleep-3");
    pause_ms(500);
    run.send(SIGKILL);  // while jobs run
    run.wait();
    const Started again(folder, {"resume", path("jobs")});
    pause_ms(500);
    fs::remove(folder / "sleeping");
    while (!fs::exists(folder / "sleeping")) pause_ms(5);
    fs::remove(folder / "sleep-16");
    std::string job = bytes_of(folder / "jobs/evaluations/000016/job");
    while (job.empty()) pause_ms(20), job = bytes_of(folder / "jobs/evaluations/000016/job");
    EXPECT_EQ(std::system(text("scancel ", job).c_str()), 0);
    EXPECT_EQ(again.wait(), 0) << again.messages();
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
    expect_same("whole", "jobs");
    EXPECT_EQ(calls().count(16), 2u) << "the cancelled one";
    for (const int number : calls()) EXPECT_TRUE(calls().count(number) == 1 || number == 16) << number;
    std::cout << recorded("jobs").size() << " evaluations, " << calls().size() << " jobs, " << seconds.count()
              << " s\n";
}

/// Two hundred designs at sixteen places, killed twice.
TEST_F(RealSlurm, ASampleThatIsKilledTwicePaysForEachDesignOnce) {
    const std::vector<std::string> design{"sample", external_case(no_gradients, budget), "-n", "200", "-q", "--out"};
    const auto sample = [&](const std::string& out) {
        std::vector<std::string> words = design;
        words.push_back(path(out));
        return words;
    };
    ASSERT_EQ(run_strake(sample("whole")).status, 0);
    fs::remove(folder / "calls");
    external_case(no_gradients + ", parallel: 16, scheduler: {slurm: [--partition=main]}", budget);
    const auto begin = std::chrono::steady_clock::now();
    std::optional<Started> run(std::in_place, folder, sample("jobs"));
    for (const std::size_t paid : {40u, 120u}) {
        while (calls().size() < paid && !run->has_ended()) pause_ms(20);
        ASSERT_FALSE(run->has_ended()) << run->messages();
        run->send(SIGKILL);
        run->wait();
        run.emplace(folder, std::vector<std::string>{"resume", path("jobs"), "-q"});
    }
    EXPECT_EQ(run->wait(), 0) << run->messages();
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
    EXPECT_EQ(bytes_of(folder / "jobs/samples.csv"), bytes_of(folder / "whole/samples.csv"));
    EXPECT_EQ(calls().size(), 200u);
    for (int number = 1; number <= 200; ++number) EXPECT_EQ(calls().count(number), 1u) << number;
    std::cout << calls().size() << " jobs, " << seconds.count() << " s\n";
}

}  // namespace
}  // namespace strake
