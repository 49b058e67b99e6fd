#include "cli/program_case.hpp"
#include "core/error.hpp"

#include <sys/resource.h>
#include <fstream>
#include <iterator>
#include <random>

/// Runs that are killed, interrupted, or shut out, and what `resume` makes of them.
namespace strake {
namespace {

/// `test.sh --long`: fifty kills of each kind.
bool is_long() { return std::getenv("STRAKE_LONG") != nullptr; }

class Resume : public ProgramCase {
protected:
    /// Kills the run again and again until one start comes to its end. @return how often.
    int run_with_kills(const std::string& file, const std::string& out, int seed, int max_ms) const {
        std::mt19937 random(static_cast<unsigned>(seed));
        int kills = 0;
        for (int status = -1; status != 0 && kills < 200;) {
            // Whatever a kill leaves, one of the two takes it.
            const bool begun = fs::exists(folder / out / "case.yaml");
            const std::set<int> paid = begun ? recorded(out) : std::set<int>();
            folder.write("calls", "");
            std::vector<std::string> arguments{"resume", path(out), "-q"};
            if (!begun) arguments = {"run", file, "--out", path(out), "-q"};
            const Started run(folder, arguments);
            // Later starts are given longer, so that there is an end.
            pause_ms(static_cast<int>(random() % static_cast<unsigned>(max_ms + 40 * kills)));
            run.send(SIGKILL);
            status = run.wait();
            for (const int number : calls()) EXPECT_FALSE(paid.contains(number)) << number << " was paid again";
            if (status == 128 + SIGKILL) {
                ++kills;
            } else {
                EXPECT_EQ(status, 0) << run.messages();
                if (status != 0) return kills;
            }
        }
        return kills;
    }
};

TEST_F(Resume, AfterKillsAtAnyMomentTheBitsAreThoseOfAnUndisturbedRun) {
    const std::string file = folder.write("case.yaml", body + built_in + budget).string();
    ASSERT_EQ(run_strake({"run", file, "--out", path("whole"), "-q"}).status, 0);
    int kills = 0;
    for (int seed = 1; kills < (is_long() ? 50 : 20); ++seed) {
        const std::string out = "killed" + std::to_string(seed);
        kills += run_with_kills(file, out, seed, 150);
        expect_same("whole", out);
        if (HasFailure()) return;
    }
}

TEST_F(Resume, NoFinishedCallOfAProgramIsPaidTwice) {
    const std::string file = external_case();
    undisturbed();
    int kills = 0;
    for (int seed = 1; kills < (is_long() ? 50 : 8); ++seed) {
        const std::string out = "killed" + std::to_string(seed);
        kills += run_with_kills(file, out, seed, 400);
        expect_same("whole", out);
        if (HasFailure()) return;
    }
    EXPECT_EQ(run_strake({"history", path("killed1"), "--csv"}).out, bytes_of(folder / "whole/history.csv"));
}

TEST_F(Resume, OfAFitAndFromAMovedFolder) {
    TriMesh wanted = ellipsoid({1, 0.6, 0.4}, 2);
    wanted.vertices.col(2) *= 1.05;
    write_surface(folder / "wanted.obj", wanted, SurfaceFormat::obj);
    const std::string file =
        folder
            .write("case.yaml",
                   body + "quantities: {m: {type: target_shape, file: wanted.obj, match: same}}\nfit: [m]\n" + budget)
            .string();
    const ProgramRun whole = run_strake({"fit", file, "--out", path("whole"), "-q"});
    const Started run(folder, {"fit", file, "--out", path("killed"), "-q"});
    while (bytes_of(folder / "killed/history.csv").size() < 300) pause_ms(5);
    run.send(SIGKILL);
    run.wait();
    fs::rename(folder / "killed", folder / "moved");
    EXPECT_EQ(run_strake({"resume", path("moved"), "-q"}).status, whole.status);
    expect_same("whole", "moved");
}

TEST_F(Resume, ABudgetCanBeRaisedAndNothingElseChanged) {
    const std::string file = external_case(", retries: 1");
    ASSERT_EQ(run_strake({"run", file, "--out", path("a"), "-q"}).status, 0);
    const std::string history = bytes_of(folder / "a/history.csv"), yaml = bytes_of(folder / "a/case.yaml");
    const auto edited = [&](const std::string& from, const std::string& to) {
        std::string text = yaml;
        text.replace(text.find(from), from.size(), to);
        folder.write("a/case.yaml", text);
        return run_strake({"resume", path("a"), "-q"});
    };
    const auto expect_refused = [&](const ProgramRun& run, const std::string& words) {
        EXPECT_EQ(run.status, 2);
        EXPECT_NE(run.err.find(words), std::string::npos) << run.err;
        EXPECT_EQ(bytes_of(folder / "a/history.csv"), history);
    };
    expect_refused(edited("load]", "load_normal]"), "parameters.variables[0]");
    expect_refused(edited("max: 1.02", "max: 1.03"), "constraints.area.max");
    expect_refused(edited("retries: 1", "retries: 2"), "quantities.bulk.retries");
    expect_refused(edited("\"-E\"", "\"-I\""), "quantities.bulk.command[2]");
    expect_refused(edited("evaluations: 10", "evaluations: 9"), "can only be raised");
    folder.write("a/case.yaml", yaml);
    expect_refused(run_strake({"resume", path("a"), "-q", "--evaluations", "+1.5"}), "whole number");
    expect_refused(run_strake({"resume", path("a"), "-q", "--time", "5"}), "--time");

    folder.write("calls", "");
    EXPECT_EQ(edited("timeout: 1h", "timeout: 2h").status, 0);
    EXPECT_EQ(bytes_of(folder / "a/history.csv"), history);
    EXPECT_EQ(run_strake({"resume", path("a"), "-q", "--evaluations", "+4"}).status, 0);
    const std::string longer = bytes_of(folder / "a/history.csv");
    EXPECT_EQ(longer.substr(0, history.size()), history);
    const std::size_t made = recorded("a").size();
    EXPECT_GT(made, 10u);
    EXPECT_LE(made, 14u);
    EXPECT_LE(calls().size(), made - 10);
    for (const int number : calls()) EXPECT_GT(number, 10);
    EXPECT_EQ(edited("evaluations: 10", "evaluations: 20").status, 0);
    EXPECT_GT(recorded("a").size(), made);

    std::string surface = bytes_of(folder / "s.obj");
    folder.write("s.obj", surface + "# another file\n");
    const ProgramRun other = run_strake({"resume", path("a"), "-q"});
    EXPECT_EQ(other.status, 2);
    EXPECT_NE(other.err.find("surface.file"), std::string::npos) << other.err;
}

TEST_F(Resume, TheFirstSignalEndsInOrderAndTheSecondAtOnce) {
    const std::string file = external_case();
    undisturbed();
    for (const char* what : {"sleep-4", "long-4"}) mark(what);
    const Started run(folder, {"run", file, "--out", path("a"), "-q"});
    while (!fs::exists(folder / "sleeping")) pause_ms(5);
    const ProgramRun status = run_strake({"status", path("a"), "--json"});
    EXPECT_EQ(status.status, 0) << status.err;
    const Json told = Json::parse(status.out);
    EXPECT_EQ(told["status"], "running");
    EXPECT_EQ(told["evaluations"], 3);
    EXPECT_EQ(told["running"]["process"], std::to_string(run.process()));
    // Meanwhile nobody else gets in.
    for (const std::vector<std::string>& arguments :
         {std::vector<std::string>{"run", file, "--out", path("a"), "-q"}, {"resume", path("a"), "-q"}}) {
        const ProgramRun other = run_strake(arguments);
        EXPECT_EQ(other.status, 4);
        EXPECT_NE(other.err.find("process " + std::to_string(run.process())), std::string::npos) << other.err;
    }
    const auto begin = std::chrono::steady_clock::now();
    run.send(SIGINT);
    EXPECT_EQ(run.wait(), 75) << run.messages();
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(20)) << "the program got TERM";
    EXPECT_NE(run.messages().find("strake resume " + path("a")), std::string::npos) << run.messages();
    EXPECT_EQ(Json::parse(run_strake({"status", path("a"), "--json"}).out)["status"], "interrupted");
    EXPECT_EQ(recorded("a").size(), 3u);

    mark("deaf-4");
    fs::remove(folder / "sleeping");
    const Started deaf(folder, {"resume", path("a"), "-q"});
    while (!fs::exists(folder / "sleeping")) pause_ms(5);
    pause_ms(50);  // it turns a deaf ear
    const auto asked = std::chrono::steady_clock::now();
    while (!deaf.has_ended()) {  // two signals that come too close are one
        deaf.send(SIGTERM);
        pause_ms(100);
    }
    EXPECT_EQ(deaf.wait(), 128 + SIGTERM);
    EXPECT_NE(deaf.messages().find("ended at once"), std::string::npos) << deaf.messages();
    EXPECT_NE(deaf.messages().find("strake resume " + path("a")), std::string::npos) << deaf.messages();
    EXPECT_LT(std::chrono::steady_clock::now() - asked, std::chrono::seconds(4)) << "the program had five to end";
    fs::remove(folder / "sleep-4");
    EXPECT_EQ(run_strake({"resume", path("a"), "-q"}).status, 0);
    expect_same("whole", "a");
    EXPECT_TRUE(fs::exists(folder / "a/evaluations/000004-3")) << "each attempt had a folder of its own";
}

TEST_F(Resume, AnAbortIsAskedAgainOnceItIsMended) {
    const std::string file = external_case();
    undisturbed();
    mark("fail-5");
    const ProgramRun failed = run_strake({"run", file, "--out", path("a"), "-q"});
    EXPECT_EQ(failed.status, 5);
    EXPECT_NE(failed.err.find("licence server is down"), std::string::npos) << failed.err;
    EXPECT_NE(failed.err.find("strake resume"), std::string::npos) << failed.err;
    EXPECT_EQ(run_strake({"resume", path("a"), "-q"}).status, 5);
    fs::remove(folder / "fail-5");
    folder.write("calls", "");
    EXPECT_EQ(run_strake({"resume", path("a"), "-q"}).status, 0);
    expect_same("whole", "a");
    EXPECT_EQ(*calls().begin(), 5);
}

TEST_F(Resume, RetriesLeaveTheSameBitsAndAreNoEvaluations) {
    undisturbed();
    for (const char* flaky : {"once-1", "once-3", "once-4", "once-9"}) mark(flaky);
    folder.write("calls", "");
    const ProgramRun run = run_strake({"run", external_case(", retries: 1"), "--out", path("a")});
    EXPECT_EQ(run.status, 0) << run.err;
    expect_same("whole", "a");
    EXPECT_EQ(calls().count(3), 2u);
    EXPECT_NE(run.err.find("evaluation 3: exit: "), std::string::npos) << run.err;
    EXPECT_TRUE(fs::exists(folder / "a/evaluations/000003/stderr.log")) << "the failed attempt is kept";
    EXPECT_TRUE(fs::exists(folder / "a/evaluations/000003-2/result.json"));
}

TEST_F(Resume, AFailureCanBeAStepTooFarOrAValue) {
    mark("fail-3");
    const ProgramRun shrunk = run_strake({"run", external_case(", on_failure: shrink_step"), "--out", path("a"), "-q"});
    EXPECT_EQ(shrunk.status, 0) << shrunk.err;
    const std::string history = bytes_of(folder / "a/history.csv");
    EXPECT_NE(history.find("\n3,2,quantity_failed,,"), std::string::npos) << history;
    const std::string cobyla = "optimize: {method: cobyla, budget: {evaluations: 6}}\n";
    const ProgramRun replaced = run_strake(
        {"run", external_case(", gradients: false, on_failure: {value: 0.125}", cobyla), "--out", path("b")});
    EXPECT_EQ(replaced.status, 0) << replaced.err;
    EXPECT_NE(bytes_of(folder / "b/history.csv").find("\n3,1,ok,1.2500000000000000e-01"), std::string::npos);
    EXPECT_NE(replaced.err.find("0.125 is used instead"), std::string::npos) << replaced.err;
    const ProgramRun refused = run_strake({"check", external_case(", on_failure: {value: 0.125}")});
    EXPECT_EQ(refused.status, 2);
    EXPECT_NE(refused.err.find("gradients: false"), std::string::npos) << refused.err;
}

TEST_F(Resume, WhatIsNoRunOrADamagedOneIsRefusedAndLeftAlone) {
    fs::create_directory(folder / "empty");
    EXPECT_EQ(run_strake({"resume", path("empty")}).status, 2);
    EXPECT_EQ(run_strake({"status", path("empty")}).status, 3);
    EXPECT_TRUE(fs::is_empty(folder / "empty"));
    const std::string file = folder.write("case.yaml", body + built_in + budget).string();
    ASSERT_EQ(run_strake({"run", file, "--out", path("a"), "-q"}).status, 0);
    const std::string whole = bytes_of(folder / "a/journal.sqlite"), history = bytes_of(folder / "a/history.csv");
    for (const std::string& bytes : {whole.substr(0, whole.size() / 2), std::string("no database at all"),
                                     std::string(whole.size(), 'x'), std::string()}) {
        folder.write("a/journal.sqlite", bytes);
        const ProgramRun run = run_strake({"resume", path("a"), "-q"});
        EXPECT_EQ(run.status, 3) << run.err;
        EXPECT_NE(run.err.find("journal.sqlite: "), std::string::npos) << run.err;
        EXPECT_EQ(bytes_of(folder / "a/history.csv"), history);
        EXPECT_EQ(bytes_of(folder / "a/journal.sqlite"), bytes);
    }
    // A torn row and lost files are made whole again.
    folder.write("a/journal.sqlite", whole);
    folder.write("a/history.csv", history.substr(0, history.size() - 30));
    fs::remove(folder / "a/best.obj");
    fs::remove(folder / "a/case.yaml");
    folder.write("a/lock", "999999 nowhere\n");
    const ProgramRun mended = run_strake({"resume", path("a"), "-q"});
    EXPECT_EQ(mended.status, 0) << mended.err;
    EXPECT_EQ(bytes_of(folder / "a/history.csv"), history);
    EXPECT_TRUE(fs::exists(folder / "a/best.obj"));
}

TEST_F(Resume, AFullDiskLosesNothing) {
    const std::string file = folder.write("case.yaml", body + built_in + budget).string();
    ASSERT_EQ(run_strake({"run", file, "--out", path("whole"), "-q"}).status, 0);
    const Started full(folder, {"run", file, "--out", path("a"), "-q"}, [] {
        signal(SIGXFSZ, SIG_IGN);
        const rlimit limit{40000, 40000};
        setrlimit(RLIMIT_FSIZE, &limit);
    });
    EXPECT_EQ(full.wait(), 4) << full.messages();
    EXPECT_NE(full.messages().find(path("a")), std::string::npos) << full.messages();
    EXPECT_GT(recorded("a").size(), 0u);
    EXPECT_EQ(run_strake({"resume", path("a"), "-q"}).status, 0);
    expect_same("whole", "a");
}

/// A disk of its own, in a name space of the test's own: where that is not allowed there is none.
TEST_F(Resume, AFullDiskIsCalledSo) {
    const std::string file = external_case(), disk = path("disk");
    undisturbed();
    fs::create_directory(disk);
    const auto on_disk = [&](int kilobytes, const std::string& command) {
        return std::system(("unshare -rm sh -c 'mount -t tmpfs -o size=" + std::to_string(kilobytes) + "k none " +
                            disk + " && { " + command + "; cp -r " + disk + "/. " + path("kept") + "; }' 2>/dev/null")
                               .c_str());
    };
    fs::create_directory(path("kept"));
    if (on_disk(64, "true") != 0) GTEST_SKIP() << "no name spaces for users";  // a small disk is mounted in one
    int told = 0, begun = 0;
    for (const int kilobytes : {48, 180, 230, 280}) {
        fs::remove_all(path("kept"));
        fs::create_directory(path("kept"));
        fs::remove(folder / "calls");
        on_disk(kilobytes, STRAKE_PROGRAM " run " + file + " --out " + disk + "/a -q 2>" + path("words"));
        const std::string words = bytes_of(path("words"));
        SCOPED_TRACE(std::to_string(kilobytes) + " kB: " + words);
        EXPECT_EQ(words.find("SQLite"), std::string::npos);
        EXPECT_EQ(words.find("I/O error"), std::string::npos);
        told += words.find("journal.sqlite: cannot write: the disk is full") != std::string::npos;
        const std::string resumed = "kept/a";
        if (!fs::exists(folder / resumed)) continue;  // nothing had been begun
        ++begun;
        ASSERT_EQ(run_strake({"resume", path(resumed), "-q"}).status, 0);
        for (const int number : calls()) EXPECT_EQ(calls().count(number), 1u) << "evaluation " << number;
        expect_same("whole", resumed);
    }
    EXPECT_GT(told, 0) << "no size of these ends in the journal";
    EXPECT_GT(begun, 1) << "all of these end before the run begins";
}

/// A kill in the first moments: a lone lock, or a case with a journal that holds nothing yet.
TEST_F(Resume, ARunThatEndedBeforeItBeganCanBeStarted) {
    const std::string file = external_case();
    ASSERT_EQ(run_strake({"run", file, "--out", path("whole"), "-q"}).status, 0);
    fs::create_directory(folder / "lone");
    folder.write("lone/lock", "99999999 elsewhere\n");
    const ProgramRun asked = run_strake({"resume", path("lone"), "-q"});
    EXPECT_EQ(asked.status, 2);
    EXPECT_NE(asked.err.find("`strake run CASE --out "), std::string::npos) << asked.err;
    EXPECT_EQ(run_strake({"run", file, "--out", path("lone"), "-q"}).status, 0);
    expect_same("whole", "lone");
    for (const bool has_file : {false, true}) {
        const std::string out = has_file ? "empty" : "none";
        fs::create_directory(folder / out);
        fs::copy_file(folder / "whole/case.yaml", folder / out / "case.yaml");
        const std::string yaml = bytes_of(folder / out / "case.yaml");
        ASSERT_TRUE(yaml.starts_with("# run of a case in ")) << yaml.substr(0, 80);
        if (has_file) folder.write(out + "/journal.sqlite", "");
        const ProgramRun refused = run_strake({"run", file, "--out", path(out), "-q"});
        EXPECT_EQ(refused.status, 4);
        EXPECT_NE(refused.err.find("ended before its first evaluation; `strake resume "), std::string::npos)
            << refused.err;
        const ProgramRun started = run_strake({"resume", path(out)});
        EXPECT_EQ(started.status, 0) << started.err;
        EXPECT_NE(started.err.find("it starts now"), std::string::npos) << started.err;
        EXPECT_EQ(bytes_of(folder / "whole/history.csv"), bytes_of(folder / out / "history.csv"));
    }
}

/// What a program has answered, and what of the journal can still be read, is paid for once.
TEST_F(Resume, ADamagedJournalIsRebuiltFromWhatIsThere) {
    ASSERT_EQ(run_strake({"run", external_case(), "--out", path("whole"), "-q"}).status, 0);
    const std::string bytes = bytes_of(folder / "whole/journal.sqlite");
    const std::string history = bytes_of(folder / "whole/history.csv");
    const auto rows = std::count(history.begin(), history.end(), '\n') - 1;
    ASSERT_GT(rows, 5);
    for (const std::string damage : {"lost", "emptied", "cut", "flipped"}) {
        fs::copy(folder / "whole", folder / damage, fs::copy_options::recursive);
        const std::string name = damage + "/journal.sqlite";
        if (damage == "lost") fs::remove(folder / name);
        if (damage == "emptied") folder.write(name, "");
        if (damage == "cut") folder.write(name, bytes.substr(0, bytes.size() / 2));
        if (damage == "flipped") {
            std::string flipped = bytes;
            flipped[flipped.find("bulk", flipped.size() / 2)] ^= 4;  // in a row of calls
            folder.write(name, flipped);
        }
        fs::remove(folder / "calls");
        const ProgramRun refused = run_strake({"resume", path(damage), "-q"});
        EXPECT_EQ(refused.status, 3) << damage;
        EXPECT_NE(refused.err.find(" --rebuild` makes a new journal"), std::string::npos) << refused.err;
        EXPECT_NE(refused.err.find(text("history.csv lists ", rows, " evaluations")), std::string::npos) << refused.err;
        EXPECT_EQ(refused.err.find("remove"), std::string::npos) << refused.err;
        const ProgramRun rebuilt = run_strake({"resume", path(damage), "--rebuild"});
        EXPECT_EQ(rebuilt.status, 0) << damage << ": " << rebuilt.err;
        EXPECT_NE(rebuilt.err.find("rebuilt the journal: "), std::string::npos) << rebuilt.err;
        EXPECT_TRUE(calls().empty()) << damage << ": " << calls().size() << " calls were paid again";
        expect_same("whole", damage);
        EXPECT_EQ(fs::exists(folder / damage / "journal.damaged.sqlite"), damage != "lost");
    }
}

/// A budget that was raised is in force again where it was, and a journal that is kept from an earlier try is in
/// nobody's way.
TEST_F(Resume, ARebuiltRunHasItsLimitsAndItsCase) {
    const std::string file =
        folder.write("case.yaml", body + built_in + "optimize: {budget: {evaluations: 6}}\n").string();
    ASSERT_EQ(run_strake({"run", file, "--out", path("whole"), "-q"}).status, 0);
    ASSERT_EQ(run_strake({"resume", path("whole"), "--evaluations", "12", "-q"}).status, 0);
    const std::string history = bytes_of(folder / "whole/history.csv"),
                      bytes = bytes_of(folder / "whole/journal.sqlite");
    ASSERT_GT(std::count(history.begin(), history.end(), '\n'), 8);
    EXPECT_NE(bytes_of(folder / "whole/case.yaml").find("\n# meaning of its keys: "), std::string::npos);
    for (const std::string damage : {"cut", "tried", "lost"}) {
        fs::copy(folder / "whole", folder / damage, fs::copy_options::recursive);
        folder.write(damage + "/journal.sqlite", bytes.substr(0, damage == "lost" ? 0 : bytes.size() - 4096));
        if (damage == "tried") folder.write(damage + "/journal.damaged.sqlite", "of an earlier try");
        const ProgramRun rebuilt = run_strake({"resume", path(damage), "--rebuild", "-q"});
        EXPECT_EQ(rebuilt.status, 0) << damage << ": " << rebuilt.err;
        const std::string again = bytes_of(folder / damage / "history.csv");
        if (damage == "lost") {  // the limit is the number of rows
            EXPECT_EQ(std::count(again.begin(), again.end(), '\n'), std::count(history.begin(), history.end(), '\n'));
        } else {
            EXPECT_EQ(again, history) << damage << ": " << rebuilt.err;
        }
        if (damage == "tried") {
            EXPECT_EQ(bytes_of(folder / "tried/journal.damaged.sqlite"), "of an earlier try");
        }
        EXPECT_EQ(rebuilt.err.find("does not say which version"), std::string::npos);
    }
    // Of a run whose case.yaml says nothing: as before 0.2, and told.
    fs::copy(folder / "whole", folder / "old", fs::copy_options::recursive);
    std::string yaml = bytes_of(folder / "old/case.yaml");
    const std::size_t note = yaml.find("# meaning of its keys");
    folder.write("old/case.yaml", yaml.erase(note, yaml.find('\n', note) + 1 - note));
    folder.write("old/journal.sqlite", "");
    const ProgramRun old = run_strake({"resume", path("old"), "--rebuild", "-q"});
    EXPECT_NE(old.err.find("goes on as before 0.2, where max_displacement bounds variables"), std::string::npos)
        << old.err;
}

TEST_F(Resume, ALostCaseComesFromTheJournal) {
    const std::string file =
        folder.write("case.yaml", body + built_in + "optimize: {budget: {evaluations: 3}}\n").string();
    ASSERT_EQ(run_strake({"run", file, "--out", path("run"), "-q"}).status, 0);
    const std::string yaml = bytes_of(folder / "run/case.yaml");
    fs::remove(folder / "run/case.yaml");
    EXPECT_EQ(run_strake({"resume", path("run"), "-q"}).status, 0);
    EXPECT_EQ(bytes_of(folder / "run/case.yaml"), yaml);
}

/// The program has run, and there is no room for what it said.
TEST_F(Resume, AnAnswerThatFoundNoRoomInTheJournalIsNotPaidAgain) {
    const std::string file = external_case();
    undisturbed();
    int lost = 0;
    for (const rlim_t room : {60'000, 100'000, 140'000, 180'000}) {
        const std::string out = "full" + std::to_string(room);
        fs::remove(folder / "calls");
        const Started full(folder, {"run", file, "--out", path(out), "-q"}, [room] {
            signal(SIGXFSZ, SIG_IGN);
            const rlimit limit{room, room};
            setrlimit(RLIMIT_FSIZE, &limit);
        });
        if (full.wait() == 0) continue;
        ++lost;
        EXPECT_EQ(run_strake({"resume", path(out), "-q"}).status, 0) << room;
        for (const int number : calls()) EXPECT_EQ(calls().count(number), 1u) << room << ": evaluation " << number;
        expect_same("whole", out);
    }
    EXPECT_GT(lost, 1);
}

/// A reader that goes away ends nothing.
TEST_F(Resume, ARunWhoseOutputNobodyReadsGoesOn) {
    const std::string file = folder.write("case.yaml", body + built_in + budget).string();
    ASSERT_EQ(run_strake({"run", file, "--out", path("whole"), "-q"}).status, 0);
    const Started unread(folder, {"run", file, "--out", path("a")}, [] {
        int ends[2];
        if (pipe(ends) != 0) _exit(126);
        close(ends[0]);
        dup2(ends[1], 1);
        dup2(ends[1], 2);
    });
    EXPECT_EQ(unread.wait(), 4) << "done; what was printed is lost";
    expect_same("whole", "a");
}

/// The second signal ends the program at once: nothing that it has started stays behind.
TEST_F(Resume, ASecondSignalKillsAProgramThatIgnoresTheFirst) {
    const std::string file = external_case();
    mark("sleep-4");
    mark("deaf-4");
    mark("long-4");
    const Started asked(folder, {"run", file, "--out", path("a"), "-q"});
    while (!fs::exists(folder / "sleeping")) pause_ms(5);
    const auto runs = [&] {
        for (const auto& entry : fs::directory_iterator("/proc")) {
            std::ifstream line(entry.path() / "cmdline", std::ios::binary);
            const std::string words{std::istreambuf_iterator<char>(line), {}};
            // Its first word is python3, under whatever path: a launcher may have put one in front.
            if (words.substr(0, words.find('\0')).find("python3") != std::string::npos &&
                words.find(folder.path().filename().string()) != std::string::npos)
                return true;
        }
        return false;
    };
    for (int k = 0; k < 200 && !runs(); ++k) pause_ms(5);  // a process may come and go while they are listed
    EXPECT_TRUE(runs());
    while (!asked.has_ended()) {  // two signals that come too close are one
        asked.send(SIGINT);
        pause_ms(100);
    }
    EXPECT_EQ(asked.wait(), 128 + SIGINT);
    for (int k = 0; k < 200 && runs(); ++k) pause_ms(5);
    EXPECT_FALSE(runs());
}

TEST_F(Resume, AFolderThatMayNotBeWrittenIsToldAndCanStillBeLookedAt) {
    const std::string file = folder.write("case.yaml", body + built_in + budget).string();
    ASSERT_EQ(run_strake({"run", file, "--out", path("a"), "-q"}).status, 0);
    fs::permissions(folder.path(), fs::perms(0755));
    fs::permissions(folder / "a", fs::perms(0555));
    // Nobody may be shut out of the folder of all temporary files, too.
    const auto as_nobody = [run = path("a")] {
        if (geteuid() == 0 && (setuid(65534) != 0 || access(run.c_str(), R_OK | X_OK) != 0)) _exit(126);
    };
    const Started resumed(folder, {"resume", path("a"), "-q"}, as_nobody);
    const int status = resumed.wait();
    if (status == 126) GTEST_SKIP() << "cannot be started as another user";  // and root may write anywhere
    EXPECT_EQ(status, 4) << resumed.messages();
    EXPECT_NE(resumed.messages().find("Permission denied"), std::string::npos) << resumed.messages();
    const Started looked(folder, {"status", path("a")}, as_nobody);
    EXPECT_EQ(looked.wait(), 0) << looked.messages();
}

}  // namespace
}  // namespace strake
