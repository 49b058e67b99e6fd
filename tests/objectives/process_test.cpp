#include "core/error.hpp"
#include "external_fixture.hpp"
#include "objectives/external/external.hpp"
#include "objectives/external/log.hpp"

#include <sys/stat.h>
#include <sys/wait.h>
#include <chrono>
#include <csignal>
#include <thread>

using namespace strake;
using Process = ExternalTest;

namespace {

/// True when the process is gone, or a zombie that only waits for init.
bool is_gone(int pid) {
    const std::string status = contents(text("/proc/", pid, "/stat"));
    const std::size_t name_end = status.rfind(')');
    return name_end == std::string::npos || status.substr(name_end + 2, 1) == "Z";
}

bool goes_soon(int pid) {
    for (int k = 0; k < 1000 && !is_gone(pid); ++k) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return is_gone(pid);
}

std::filesystem::path script(const std::filesystem::path& folder, const std::string& text, int mode = 0755) {
    const auto file = folder / "script";
    std::ofstream(file) << text;
    ::chmod(file.c_str(), mode);
    return file;
}

long resident_kb() {
    const std::string status = contents("/proc/self/status");
    return std::stol(status.substr(status.find("VmRSS:") + 6));
}

}  // namespace

TEST_F(Process, EverySpawnFailureIsNamed) {
    struct Case {
        std::string program, words;
    };
    std::filesystem::create_directory(folder / "directory");
    script(folder, "#!/no/such/interpreter\n");
    std::filesystem::rename(folder / "script", folder / "shebang");
    script(folder, "no first line\n");
    std::filesystem::rename(folder / "script", folder / "nothing");
    script(folder, "#!/bin/sh\n", 0644);
    std::filesystem::rename(folder / "script", folder / "plain");
    const Case cases[] = {{"./missing", "does not exist"},
                          {"./directory", "is a directory"},
                          {"./plain", "may not be executed (mode 644); chmod +x"},
                          {"./shebang", "interpreter"},
                          {"./nothing", "not a program for this machine"},
                          {"no-such-program-anywhere", "not on PATH"}};
    int evaluation = 0;
    for (const Case& c : cases) {
        ExternalCommand command = fake("ok");
        command.command.front() = c.program;
        const QuantityResult result = ask(command, false, ++evaluation);
        ASSERT_TRUE(result.failure) << c.program;
        EXPECT_EQ(result.failure->kind, "spawn") << result.failure->message;
        EXPECT_TRUE(has(result.failure->message, c.words)) << result.failure->message;
        if (c.program != "./shebang" && c.program != "./nothing") {
            EXPECT_TRUE(check_program(command)) << c.program;
        }
    }
    ExternalCommand command = fake("ok");
    command.command.push_back(std::string(4 << 20, 'x'));
    EXPECT_TRUE(has(ask(command, false, ++evaluation).failure->message, "too long"));
}

TEST_F(Process, ArgumentsAreNotSeenByAShell) {
    ExternalCommand command = fake("ok");
    command.command = {script(folder, "#!/bin/sh\nprintf '%s|' \"$@\" > arguments\n"),
                       "a b; exit 3",
                       "$(id)",
                       "{folder}/*",
                       "x{case_dir}y{case_dir}",
                       "{other}",
                       "'\"\n"};
    EXPECT_EQ(ask(command).failure->kind, "no_result");
    const auto home = folder / "evaluations/000001";
    EXPECT_EQ(contents(home / "arguments"), "a b; exit 3|$(id)|" + home.string() + "/*|x" + folder.string() + "y" +
                                                folder.string() + "|{other}|'\"\n|");
}

TEST_F(Process, ExitStatusCountsEvenWithAResult) {
    const QuantityResult with_result = ask(fake("exit_1_with_result"), true, 1);
    ASSERT_TRUE(with_result.failure);
    EXPECT_EQ(with_result.failure->kind, "exit");
    EXPECT_TRUE(has(with_result.failure->message, "exit status 1"));
    const QuantityResult result = ask(fake("exit_3"), true, 2);
    EXPECT_EQ(result.failure->kind, "exit");
    EXPECT_TRUE(has(result.failure->message, "exit status 3"));
    EXPECT_TRUE(has(result.failure->message, "    diverged at step 17?")) << result.failure->message;
    EXPECT_FALSE(has(result.failure->message, "\x1b"));
}

TEST_F(Process, SignalIsNamed) {
    const QuantityResult result = ask(fake("die"));
    ASSERT_TRUE(result.failure);
    EXPECT_EQ(result.failure->kind, "signal");
    EXPECT_TRUE(has(result.failure->message, "SIGSEGV")) << result.failure->message;
}

TEST_F(Process, TimeoutEndsTheWholeGroup) {
    int evaluation = 0;
    for (const char* role : {"hang", "ignore_term"}) {
        ExternalCommand command = fake(role);
        command.timeout_s = 2;
        command.grace_s = 0.3;
        const auto start = std::chrono::steady_clock::now();
        const QuantityResult result = ask(command, false, ++evaluation);
        ASSERT_TRUE(result.failure) << role;
        EXPECT_EQ(result.failure->kind, "timeout");
        EXPECT_TRUE(has(result.failure->message, role[0] == 'h' ? "ended with SIGTERM" : "ignored SIGTERM"))
            << result.failure->message;
        EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10));
        const std::string pid = contents(folder / text("evaluations/00000", evaluation) / "grandchild.pid");
        ASSERT_FALSE(pid.empty()) << role;
        EXPECT_TRUE(goes_soon(std::stoi(pid))) << role;
    }
}

/// Whatever a program does, we are back in timeout + grace and a little (no hanging program ends within a minute), and
/// its log's end is in the message.
TEST_F(Process, NoWayToHangTakesLongerThanTimeoutAndGrace) {
    int evaluation = 0;
    for (const char* role :
         {"spin", "hang", "ignore_term", "flood_and_hang", "close_outputs_and_hang", "stop_itself"}) {
        ExternalCommand command = fake(role);
        command.timeout_s = 1;
        const auto begin = std::chrono::steady_clock::now();
        const QuantityResult result = ask(command, true, ++evaluation);
        const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
        ASSERT_TRUE(result.failure) << role;
        EXPECT_EQ(result.failure->kind, "timeout") << role << ": " << result.failure->message;
        EXPECT_LT(seconds.count(), command.timeout_s + command.grace_s + 4) << role;
        if (std::string(role) == "spin") {
            EXPECT_TRUE(has(result.failure->message, "    iteration 17")) << result.failure->message;
        }
    }
}

TEST_F(Process, AResultCountsOnlyAsItIsWhenTheProgramEnds) {
    const QuantityResult late = ask(fake("late"), false, 1);
    ASSERT_TRUE(late.failure);
    EXPECT_EQ(late.failure->kind, "no_result");
    const QuantityResult twice = ask(fake("twice"), true, 2);
    ASSERT_FALSE(twice.failure) << twice.failure->message;
    EXPECT_NEAR(twice.values.at(0), mesh.vertices.sum(), 1e-12);
    // What is written late meets a folder that nobody looks at any more: the next attempt has another.
    std::this_thread::sleep_for(std::chrono::milliseconds(1800));
    EXPECT_TRUE(std::filesystem::exists(folder / "evaluations/000001/result.json"));
    ExternalCommand again = fake("no_result");
    again.may_follow_others = true;
    EXPECT_EQ(ask(again, false, 1).failure->kind, "no_result");
}

TEST_F(Process, AFlakyProgramIsTriedAgainAndEachFailureTold) {
    ExternalCommand command = fake("flaky");
    command.retries = 2;
    command.pause_s = 0.01;
    const QuantityResult result = ask(command, true);
    ASSERT_FALSE(result.failure) << result.failure->message;
    ASSERT_EQ(result.remarks.size(), 2u);
    EXPECT_TRUE(has(result.remarks[0], "exit: ")) << result.remarks[0];
    std::filesystem::remove(folder / "flaky");
    command.retries = 1;
    const QuantityResult failed = ask(command, true, 2);
    ASSERT_TRUE(failed.failure);
    EXPECT_TRUE(has(failed.failure->message, "no licence")) << failed.failure->message;
    EXPECT_TRUE(has(failed.failure->message, "2 attempts failed")) << failed.failure->message;
}

TEST_F(Process, LeftoversOfTheGroupAreEndedAndTheResultTaken) {
    const QuantityResult result = ask(fake("leftover"), true);
    ASSERT_FALSE(result.failure) << result.failure->message;
    const std::string pid = contents(folder / "evaluations/000001/grandchild.pid");
    ASSERT_FALSE(pid.empty());
    EXPECT_TRUE(goes_soon(std::stoi(pid)));
}

TEST_F(Process, GrandchildThatLeftTheGroupAndHoldsThePipeDoesNotHoldUs) {
    const auto start = std::chrono::steady_clock::now();
    const QuantityResult result = ask(fake("daemon_holds_pipe"), true);
    const auto seconds = std::chrono::steady_clock::now() - start;
    const std::string pid = contents(folder / "evaluations/000001/grandchild.pid");
    ASSERT_FALSE(pid.empty());
    ::kill(std::stoi(pid), SIGKILL);
    EXPECT_FALSE(result.failure);
    EXPECT_LT(seconds, std::chrono::seconds(10));
}

TEST_F(Process, ProgramEndsWhenWeAreKilled) {
    ExternalCommand command = fake("unused");
    command.command = {"sh", "-c", "echo $$ > pid.new; mv pid.new pid; exec sleep 60"};
    const pid_t we = ::fork();
    if (we == 0) {
        ask(command);
        ::_exit(0);
    }
    const auto file = folder / "evaluations/000001/pid";
    for (int k = 0; k < 1000 && !std::filesystem::exists(file); ++k)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    ::kill(we, SIGKILL);
    ::waitpid(we, nullptr, 0);
    ASSERT_TRUE(std::filesystem::exists(file));
    EXPECT_TRUE(goes_soon(std::stoi(contents(file))));
}

TEST_F(Process, FloodOfOutputIsCutInTheMiddleAndCostsNoMemory) {
    const long before = resident_kb();
    const QuantityResult result = ask(fake("flood"), true);
    ASSERT_FALSE(result.failure) << result.failure->message;
    EXPECT_LT(resident_kb() - before, 8000);
    const auto home = folder / "evaluations/000001";
    for (const char* name : {"stdout.log", "stderr.log"}) {
        EXPECT_GE(std::filesystem::file_size(home / name), 10u << 20);
        EXPECT_LE(std::filesystem::file_size(home / name), (10u << 20) + 70000);
    }
    const std::string log = contents(home / "stderr.log");
    EXPECT_TRUE(has(log, "bytes omitted]"));
    EXPECT_EQ(log.substr(log.size() - 14), "the last line\n");
}

TEST_F(Process, EveryCallReturnsItsDescriptors) {
    const auto open_descriptors = [] {
        return std::distance(std::filesystem::directory_iterator("/proc/self/fd"), {});
    };
    ExternalCommand command = fake("ok");
    command.command = {"sh", "-c", "echo '{\"value\": 1}' > result.json"};
    ask(command, false, 1);
    const auto before = open_descriptors();
    for (int evaluation = 2; evaluation < 20; ++evaluation) EXPECT_FALSE(ask(command, false, evaluation).failure);
    command.command.front() = "./missing";
    EXPECT_TRUE(ask(command, false, 20).failure);
    EXPECT_EQ(open_descriptors(), before);
}

/// It is started while all signals wait, so that none of our handlers runs in it.
TEST_F(Process, SignalsOfAProgramAreAtTheirDefaults) {
    ExternalCommand command = fake("ok");
    command.command = {"sh", "-c",
                       "grep -E 'Sig(Blk|Ign)' /proc/self/status > signals; echo '{\"value\": 1}' > result.json"};
    sigset_t one, before, after;
    sigemptyset(&one);
    sigaddset(&one, SIGUSR2);
    ASSERT_EQ(::pthread_sigmask(SIG_BLOCK, &one, &before), 0);
    ask(command, false, 1);
    ::pthread_sigmask(SIG_SETMASK, &before, &after);
    EXPECT_EQ(contents(folder / "evaluations/000001/signals"),
              "SigBlk:\t0000000000000000\nSigIgn:\t0000000000000000\n");
    EXPECT_EQ(sigismember(&after, SIGUSR2), 1) << "ours are as they were";
    EXPECT_EQ(sigismember(&after, SIGUSR1), 0) << "ours are as they were";
}

/// A thousand programs at a time: who waits for one looks up five times a second, and when it ends. Looks are counted
/// by how often this thread gave the processor away.
TEST_F(Process, WaitingForAProgramCostsNothing) {
    const auto naps = [] {
        const std::string status = contents("/proc/thread-self/status"), name = "\nvoluntary_ctxt_switches:";
        return std::stol(status.substr(status.find(name) + name.size()));
    };
    ExternalCommand command = fake("ok");
    command.command = {"sh", "-c", "echo '{\"value\": 1}' > result.json"};
    const long before_short = naps();
    ask(command, false, 1);
    const long of_files = naps() - before_short;
    command.command.back() = "sleep 2; " + command.command.back();
    const long before_long = naps();
    ask(command, false, 2);
    EXPECT_LT(naps() - before_long, of_files + 60) << "by looks every 20 ms 100";
}

TEST(Log, WhatAProgramPrintsIsMadeHarmless) {
    EXPECT_EQ(printable_line("\x1b[1;31mred\x1b[0m \x1b]0;title\x07 end\x07"), "red  end?");
    EXPECT_EQ(printable_line("caf\xc3\xa9 \xff \xc2\x9b \xe2\x80\xae \xed\xa0\x80 \xc3"), "caf\xc3\xa9 ? ?? ??? ??? ?");
    EXPECT_EQ(printable_line(std::string(1000, 'x')).size(), 204u);
    EXPECT_EQ(printable_tail("1\n2\n\n  \n3\r4\n", 3), "    2\n    3\n    4");
    EXPECT_EQ(printable_tail("", 3), "");
}
