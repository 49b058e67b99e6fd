#include "optimize/journal/journal.hpp"

#include "core/mesh/temp_folder.hpp"
#include "optimize/journal/journal_tables.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/wait.h>
#include <unistd.h>
#include <bit>
#include <csignal>
#include <cstdint>

namespace strake {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

JournalFacts facts() {
    JournalFacts f;
    f.case_yaml = "case: a\n";
    f.case_dir = "/cases/a b";
    f.host = "node7";
    f.is_fit = true;
    f.values = {"volume", "aero.drag"};
    f.parameters = {"alpha"};
    f.files = {{"surface.file", "00ff"}};
    return f;
}

JournalEvaluation evaluation(int number) {
    JournalEvaluation e;
    e.number = number;
    e.level = 2;
    e.status = "ok";
    e.x = Eigen::Vector4d(1.0 / 3, -0.0, 5e-324, 1e300 * number);
    e.values = {0.1 * number, -1e-17};
    e.parameters = {0.05};
    e.objective = 0.1 * number;
    e.max_violation = 0;
    e.accepted = number == 1;
    e.surface = "ab";
    e.seconds = 0.25;
    e.elapsed = 0.25 * number;
    return e;
}

JournalCall call(int number) {
    JournalCall c{number, "aero.drag", "12", "34", {}, 1.5};
    c.result.values = {0.1, 0.2};
    c.result.dJ_dv = {Points::Random(7, 3), Points::Random(7, 3)};
    c.result.dJ_dp = {Eigen::VectorXd::Constant(2, nan), Eigen::VectorXd::Constant(2, -0.5)};
    c.result.remarks = {"exit: exit status 3; attempt 2 of 3 follows"};
    return c;
}

std::vector<std::uint64_t> bits(const auto& values) {
    std::vector<std::uint64_t> all;
    for (const double v : values) all.push_back(std::bit_cast<std::uint64_t>(v));
    return all;
}

class JournalFile : public testing::Test {
protected:
    TempFolder folder;
    std::filesystem::path file = folder / "journal.sqlite";

    void fill(int evaluations) const {
        const auto journal = Journal::create(file, facts(), {0, 60, 0});
        for (int k = 1; k <= evaluations; ++k) {
            journal->add(call(k));
            journal->add(evaluation(k));
        }
    }
    void expect_refused(const std::string& words) const {
        const std::string before = bytes_of(file);
        try {
            Journal::open(file);
            ADD_FAILURE() << "was opened";
        } catch (const InputError& refused) {
            EXPECT_NE(std::string(refused.what()).find(words), std::string::npos) << refused.what();
            EXPECT_EQ(std::string(refused.what()).find(file.string()), 0u) << refused.what();
        }
        EXPECT_EQ(bytes_of(file), before);
    }
};

/// A rebuilt journal has its limits before its evaluations.
TEST_F(JournalFile, LimitsComeIntoForceWhereTheyDid) {
    const auto journal = Journal::create(file, facts(), {0, 2, 0});
    journal->add(RunLimits{2, 4, 0});
    EXPECT_EQ(journal->limits_after(0).evaluations, 2);
    journal->add(evaluation(1));
    EXPECT_EQ(journal->limits_after(1).evaluations, 2);
    EXPECT_EQ(journal->limits_after(2).evaluations, 4);
    EXPECT_EQ(journal->limits().evaluations, 4);
    journal->set_limits(9, 0);  // before the last one is in force: it takes its place
    const auto looked = Journal::look(file);
    for (const int after : {1, 2}) {
        EXPECT_EQ(journal->limits_after(after).evaluations, after == 1 ? 2 : 9);
        EXPECT_EQ(looked->limits_after(after).evaluations, after == 1 ? 2 : 9);
    }
}

TEST_F(JournalFile, GivesBackEveryBit) {
    fill(3);
    const auto journal = Journal::open(file);
    EXPECT_EQ(journal->facts().case_yaml, facts().case_yaml);
    EXPECT_EQ(journal->facts().case_dir, facts().case_dir);
    EXPECT_EQ(journal->facts().host, "node7");
    EXPECT_TRUE(journal->facts().is_fit);
    EXPECT_EQ(journal->facts().values, facts().values);
    EXPECT_EQ(journal->facts().parameters, facts().parameters);
    EXPECT_EQ(journal->facts().files, facts().files);
    ASSERT_EQ(journal->evaluations().size(), 3u);
    const JournalEvaluation &was = evaluation(2), &is = *journal->find(2);
    EXPECT_EQ(bits(is.x), bits(was.x));
    EXPECT_EQ(bits(is.values), bits(was.values));
    EXPECT_EQ(is.elapsed, was.elapsed);
    EXPECT_EQ(journal->find(4), nullptr);
    EXPECT_FALSE(journal->find_call(4, "aero.drag"));
    const auto given = journal->find_call(2, "aero.drag");
    ASSERT_TRUE(given);
    srand(1);
    EXPECT_EQ(given->result.values, call(2).result.values);
    EXPECT_EQ(given->result.dJ_dv[1].rows(), 7);
    EXPECT_TRUE(given->result.dJ_dp[0].array().isNaN().all());
    EXPECT_EQ(given->result.dJ_dp[1], Eigen::VectorXd::Constant(2, -0.5));
    EXPECT_EQ(given->result.remarks, call(2).result.remarks);
    EXPECT_FALSE(given->result.failure);
}

TEST_F(JournalFile, AFailureKeepsItsWordsAndWhatHasNoNumberHasNone) {
    {
        const auto journal = Journal::create(file, facts(), {0, 60, 0});
        JournalCall failed{1, "aero.drag", "12", "34", {}, 0};
        failed.result.failure = Failure{"exit", "exit status 3\n  in a folder"};
        journal->add(failed);
        JournalEvaluation none = evaluation(1);
        none.status = "quantity_failed";
        none.values.clear();
        none.objective = none.max_violation = nan;
        journal->add(none);
    }
    const auto journal = Journal::open(file);
    EXPECT_EQ(journal->find_call(1, "aero.drag")->result.failure->message, "exit status 3\n  in a folder");
    EXPECT_TRUE(std::isnan(journal->find(1)->objective));
    EXPECT_TRUE(journal->find(1)->values.empty());
}

TEST_F(JournalFile, AFailureThatEndedTheRunIsAskedAgain) {
    {
        const auto journal = Journal::create(file, facts(), {0, 60, 0});
        journal->add(evaluation(1));
        JournalEvaluation last = evaluation(2);
        last.is_final_failure = true;
        journal->add(last);
        EXPECT_EQ(Journal::look(file)->evaluations().size(), 2u) << "to look at, it is there";
    }
    const auto journal = Journal::open(file);
    EXPECT_EQ(journal->evaluations().size(), 1u);
    journal->add(evaluation(2));
    EXPECT_THROW(journal->add(evaluation(4)), InvalidInput);
}

TEST_F(JournalFile, LimitsHoldFromWhereTheyWereRaised) {
    fill(3);
    {
        const auto journal = Journal::open(file);
        journal->set_limits(60, 0);
        journal->set_limits(80, 0);
        journal->set_limits(100, 7);
    }
    const auto journal = Journal::open(file);
    EXPECT_EQ(journal->limits_after(0).evaluations, 60);
    EXPECT_EQ(journal->limits_after(2).evaluations, 60);
    EXPECT_EQ(journal->limits_after(3).evaluations, 100);
    EXPECT_EQ(journal->limits().seconds, 7);
    EXPECT_EQ(journal->limits().evaluations, 100);
}

TEST_F(JournalFile, CanBeLookedAtWhileItIsWritten) {
    const auto journal = Journal::create(file, facts(), {0, 60, 0});
    for (int k = 1; k <= 3; ++k) {
        journal->add(evaluation(k));
        EXPECT_EQ(Journal::look(file)->evaluations().size(), static_cast<std::size_t>(k));
    }
}

/// A living run's file must not be read as one that nobody writes: what is in its log would be missed.
TEST_F(JournalFile, OneThatIsLockedIsNotReadAsItLies) {
    fill(2);
    sqlite3* other = nullptr;
    ASSERT_EQ(sqlite3_open(file.c_str(), &other), SQLITE_OK);
    sqlite3_exec(other, "PRAGMA locking_mode = EXCLUSIVE; BEGIN EXCLUSIVE; DELETE FROM evaluations WHERE number = 2",
                 nullptr, nullptr, nullptr);
    try {
        Journal::look(file);
        ADD_FAILURE() << "was read while it was locked";
    } catch (const OutputError& locked) {
        EXPECT_NE(std::string(locked.what()).find("another program holds it locked"), std::string::npos)
            << locked.what();
    }
    sqlite3_close(other);
    EXPECT_EQ(Journal::look(file)->evaluations().size(), 2u);
}

/// A value that SQLite does not take would else be stored as none.
TEST_F(JournalFile, WhatIsTooLargeToKeepIsSaid) {
    sqlite3* db = nullptr;
    ASSERT_EQ(sqlite3_open(file.c_str(), &db), SQLITE_OK);
    make_tables(db, file);
    sqlite3_limit(db, SQLITE_LIMIT_LENGTH, 300);
    try {
        insert(db, file, call(1));
        ADD_FAILURE() << "was kept";
    } catch (const OutputError& refused) {
        EXPECT_NE(std::string(refused.what()).find("cannot keep a value of 360 bytes, the limit is 300"),
                  std::string::npos)
            << refused.what();
    }
    sqlite3_close(db);
}

/// What `add` has returned from is there, however the process ends.
TEST_F(JournalFile, SurvivesAKill) {
    const pid_t child = fork();
    if (child == 0) {
        const auto journal = Journal::create(file, facts(), {0, 60, 0});
        for (int k = 1; k <= 5; ++k) journal->add(call(k)), journal->add(evaluation(k));
        journal->add(call(6));
        kill(getpid(), SIGKILL);
    }
    int status = 0;
    waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status));
    const auto journal = Journal::open(file);
    EXPECT_EQ(journal->evaluations().size(), 5u);
    EXPECT_TRUE(journal->find_call(6, "aero.drag"));
}

TEST_F(JournalFile, WhatIsNoJournalIsRefused) {
    EXPECT_THROW(Journal::open(file), InputError);  // missing
    folder.write("journal.sqlite", "");
    expect_refused("holds nothing");
    std::filesystem::remove(file);
    sqlite3* other = nullptr;
    sqlite3_open(file.c_str(), &other);
    sqlite3_exec(other, "CREATE TABLE mine (x)", nullptr, nullptr, nullptr);
    sqlite3_close(other);
    expect_refused("is no journal of Strake");
    folder.write("journal.sqlite",
                 "once upon a time there was a file that was no database, and rather a long one at that");
    expect_refused("damaged");
    std::filesystem::remove(file);
    std::filesystem::create_directory(file);
    EXPECT_THROW(Journal::open(file), InputError);
}

TEST_F(JournalFile, ANewerVersionIsRefused) {
    fill(1);
    std::string bytes = bytes_of(file);
    ASSERT_EQ(bytes[63], 1) << "user_version stands at byte 60";
    bytes[63] = 9;
    folder.write("journal.sqlite", bytes);
    expect_refused("is of version 9");
}

/// Damage is never taken for a result: wherever a bit has flipped, the journal is refused or says what it said.
TEST_F(JournalFile, DamageIsNoticed) {
    fill(40);
    const std::string whole = bytes_of(file);
    folder.write("journal.sqlite", whole.substr(0, whole.size() / 2));
    expect_refused("damaged");
    int refused = 0;
    for (std::size_t at = 100; at < whole.size(); at += 131) {
        std::string bytes = whole;
        bytes[at] = static_cast<char>(bytes[at] ^ 4);
        folder.write("journal.sqlite", bytes);
        try {
            const auto journal = Journal::open(file);
            ASSERT_LE(journal->evaluations().size(), 40u);
            for (const JournalEvaluation& e : journal->evaluations())
                EXPECT_EQ(bits(e.x), bits(evaluation(e.number).x));
        } catch (const InputError&) {
            ++refused;
        } catch (const OutputError&) {
            ++refused;
        }
    }
    EXPECT_GT(refused, 50);
}

/// What the run is about is checked as its evaluations are; damage of the header and of the tables' names is called so.
TEST_F(JournalFile, DamageOfFactsAndHeaderIsCalledDamage) {
    fill(3);
    const std::string whole = bytes_of(file), yaml = Journal::open(file)->facts().case_yaml;
    int refused = 0;
    const std::size_t step = 7;
    for (std::size_t at = 0; at < whole.size(); at += at < 100 ? 1 : step) {
        std::string bytes = whole;
        bytes[at] = static_cast<char>(bytes[at] ^ 2);
        folder.write("journal.sqlite", bytes);
        try {
            const auto journal = Journal::open(file);
            EXPECT_EQ(journal->facts().case_yaml, yaml) << "byte " << at;
        } catch (const InputError& error) {
            ++refused;
            const std::string why = error.what();
            EXPECT_TRUE(why.find("damaged") != why.npos || why.find("is no journal of Strake") != why.npos ||
                        why.find("holds nothing") != why.npos)
                << at << ": " << why;
        }  // whatever else is thrown fails the test
    }
    EXPECT_GT(refused, 100);
}

TEST(ContentHash, TellsBytesAndSurfacesApart) {
    EXPECT_EQ(content_hash(""), "cbf29ce484222325");
    EXPECT_NE(content_hash("a"), content_hash("b"));
    TriMesh mesh = icosphere(1);
    const std::string before = content_hash(mesh);
    EXPECT_EQ(content_hash(icosphere(1)), before);
    mesh.vertices(3, 1) = std::nextafter(mesh.vertices(3, 1), 9.0);
    EXPECT_NE(content_hash(mesh), before);
}

}  // namespace
}  // namespace strake
