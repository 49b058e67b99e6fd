#include "optimize/journal/journal.hpp"

#include "core/error.hpp"
#include "core/text/hash.hpp"
#include "optimize/journal/journal_tables.hpp"
#include "optimize/journal/packed_arrays.hpp"

#include <sqlite3.h>
#include <unistd.h>
#include <algorithm>
#include <cstdio>
#include <limits>

namespace strake {
namespace {

constexpr int application = 1400140139;  // as in the tables
constexpr int version = 1;

void execute(sqlite3* db, const std::filesystem::path& file, const char* sql) {
    if (const int code = sqlite3_exec(db, sql, nullptr, nullptr, nullptr); code != SQLITE_OK)
        throw_sqlite(db, file, code);
}

/// Several changes that are on the disk together or not at all.
class Transaction {
public:
    Transaction(sqlite3* db, const std::filesystem::path& file) : db_(db), file_(file) {
        execute(db, file, "BEGIN IMMEDIATE");
    }
    ~Transaction() {
        if (!done_) sqlite3_exec(db_, "ROLLBACK", nullptr, nullptr, nullptr);
    }
    void commit() {
        execute(db_, file_, "COMMIT");
        done_ = true;
    }

private:
    sqlite3* db_;
    const std::filesystem::path& file_;
    bool done_ = false;
};

void write_fact(sqlite3* db, const std::filesystem::path& file, const std::string& name, const std::string& value) {
    Statement(db, file, "INSERT OR REPLACE INTO facts VALUES (?, ?)").bind(name).bind(value).run();
}

/// Where SQLite says that such a file may not be written, its header is not what was written.
bool is_writable(const std::filesystem::path& file) {
    const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
    return ::access(file.c_str(), W_OK) == 0 && ::access(folder.c_str(), W_OK) == 0;
}

}  // namespace

Journal::Journal(const std::filesystem::path& file, int flags) : file_(file) {
    int code = sqlite3_open_v2(file.c_str(), &db_, flags, nullptr);
    sqlite3_busy_timeout(db_, 10000);  // of a reader that looks while we write
    if (code == SQLITE_OK) return;
    try {
        throw_sqlite(db_, file, code);
    } catch (...) {
        sqlite3_close(db_);
        throw;
    }
}

Journal::~Journal() { sqlite3_close(db_); }

std::unique_ptr<Journal> Journal::create(const std::filesystem::path& file, const JournalFacts& facts,
                                         const RunLimits& limits) {
    std::unique_ptr<Journal> journal(new Journal(file, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE));
    sqlite3* db = journal->db_;
    // With a log ahead of the file, readers need not wait; FULL: a commit returns when it is on the disk.
    execute(db, file, "PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL");
    Transaction all(db, journal->file_);
    make_tables(db, file);
    std::vector<std::string> files;
    for (const auto& [key, hash] : facts.files) files.push_back(key + " " + hash);
    FactTable table{{"case", facts.case_yaml},
                    {"case_dir", facts.case_dir.string()},
                    {"host", facts.host},
                    {"command", facts.is_fit ? "fit" : "run"},
                    {"meaning", std::to_string(facts.meaning)},
                    {"values", lines_of(facts.values)},
                    {"own", lines_of(facts.parameters)},
                    {"files", lines_of(files)}};
    table["hash"] = check_of(table);
    for (const auto& [name, value] : table) write_fact(db, file, name, value);
    Statement(db, file, "INSERT INTO limits VALUES (0, ?, ?)")
        .bind(static_cast<long long>(limits.evaluations))
        .bind(limits.seconds)
        .run();
    all.commit();
    journal->facts_ = facts;
    journal->limits_ = {{0, limits.evaluations, limits.seconds}};
    return journal;
}

void Journal::check_version() {
    const auto pragma = [&](const char* sql) {
        Statement row(db_, file_, sql);
        return row.step() ? row.integer(0) : 0;
    };
    if (pragma("SELECT count(*) FROM sqlite_master") == 0)
        throw InputError(text(file_.string(),
                              ": holds nothing: the run ended before its first entry, or the journal's log is lost"));
    if (pragma("PRAGMA application_id") != application)
        throw InputError(text(file_.string(), ": is no journal of Strake; nothing was changed"));
    if (const long long has = pragma("PRAGMA user_version"); has != version)
        throw InputError(text(file_.string(), ": is of version ", has, ", this program reads version ", version,
                              ": a newer program wrote it, or it is damaged; nothing was changed"));
}

void Journal::read_facts() {
    facts_.meaning = 1;  // of a journal that does not say it
    const FactTable table = fact_table(db_, file_);
    if (!is_sound(table))
        throw InputError(
            text(file_.string(),
                 ": the journal is damaged (a fact of the run is not what was written); nothing was changed"));
    for (const auto& [name, value] : table) set_fact(facts_, name, value);
    Statement limits(db_, file_, "SELECT after, evaluations, seconds FROM limits ORDER BY after");
    while (limits.step())
        limits_.push_back({static_cast<int>(limits.integer(0)), static_cast<int>(limits.integer(1)), limits.number(2)});
    if (limits_.empty() || limits_[0].after != 0 || facts_.case_yaml.empty())
        throw InputError(text(file_.string(), ": the journal is damaged (no facts of the run); nothing was changed"));
}

void Journal::read_evaluations() {
    Statement rows(db_, file_, select_evaluations);
    while (rows.step()) {
        evaluations_.push_back(evaluation_of(rows, file_));
        if (evaluations_.back().number != static_cast<int>(evaluations_.size()))
            throw InputError(text(file_.string(), ": the journal is damaged (evaluation ", evaluations_.size(),
                                  " is missing); nothing was changed"));
    }
}

void Journal::drop_final_failure() {
    if (evaluations_.empty() || !evaluations_.back().is_final_failure) return;
    Statement(db_, file_, "DELETE FROM evaluations WHERE number = ?")
        .bind(static_cast<long long>(evaluations_.back().number))
        .run();
    evaluations_.pop_back();
}

std::unique_ptr<Journal> Journal::open(const std::filesystem::path& file) {
    std::error_code why;
    if (!std::filesystem::is_regular_file(file, why))
        throw InputError(text(file.string(), ": ", why ? why.message() : "is no file"));
    std::unique_ptr<Journal> journal(new Journal(file, SQLITE_OPEN_READWRITE));
    journal->check_version();
    Statement check(journal->db_, file, "PRAGMA integrity_check(1)");
    if (check.step() && check.words(0) != "ok")
        throw InputError(text(file.string(), ": the journal is damaged (", check.words(0), "); nothing was changed"));
    execute(journal->db_, file, "PRAGMA synchronous = FULL");
    journal->read_facts();
    journal->read_evaluations();
    Statement calls(journal->db_, file, select_calls);
    while (calls.step()) call_of(calls, file);
    if (sqlite3_db_readonly(journal->db_, "main") == 1 && is_writable(file))
        throw InputError(
            text(file.string(), ": the journal is damaged (its header forbids writing); nothing was changed"));
    journal->drop_final_failure();
    return journal;
}

std::unique_ptr<Journal> Journal::look(const std::filesystem::path& file) {
    std::error_code why;
    if (!std::filesystem::is_regular_file(file, why))
        throw InputError(text(file.string(), ": ", why ? why.message() : "is no file"));
    const auto read = [&](const std::filesystem::path& name, int flags) {
        std::unique_ptr<Journal> journal(new Journal(name, flags));
        sqlite3_busy_timeout(journal->db_, 2000);  // a run holds its lock for moments only
        journal->file_ = file;
        journal->check_version();
        execute(journal->db_, journal->file_, "BEGIN");  // one moment
        journal->read_facts();
        journal->read_evaluations();
        execute(journal->db_, journal->file_, "COMMIT");
        return journal;
    };
    try {
        return read(file, SQLITE_OPEN_READONLY);
    } catch (const ReadOnly&) {
        // In a folder where nothing may be written: as the file is. One that is merely locked changes while we read.
        std::string name = "file:";
        for (const char c : std::filesystem::absolute(file).string()) {
            char escaped[4];
            std::snprintf(escaped, sizeof escaped, "%%%02x", static_cast<unsigned char>(c));
            name += escaped;
        }
        return read(name + "?immutable=1", SQLITE_OPEN_READONLY | SQLITE_OPEN_URI);
    }
}

const RunLimits& Journal::limits_after(int evaluations) const {
    std::size_t k = limits_.size() - 1;
    while (k > 0 && limits_[k].after > evaluations) --k;
    return limits_[k];
}

const JournalEvaluation* Journal::find(int number) const {
    return number >= 1 && number <= static_cast<int>(evaluations_.size()) ? &evaluations_[number - 1] : nullptr;
}

std::optional<JournalCall> Journal::find_call(int evaluation, const std::string& quantity) const {
    const std::lock_guard lock(busy_);
    Statement row(db_, file_, select_call);
    row.bind(static_cast<long long>(evaluation)).bind(quantity);
    if (!row.step()) return {};
    return call_of(row, file_);
}

void Journal::add(const JournalEvaluation& evaluation) {
    if (evaluation.number != static_cast<int>(evaluations_.size()) + 1)
        throw InvalidInput(text("journal: evaluation ", evaluation.number, " follows ", evaluations_.size()));
    const std::lock_guard lock(busy_);
    Transaction one(db_, file_);
    insert(db_, file_, evaluation);
    one.commit();
    evaluations_.push_back(evaluation);
}

void Journal::add(const JournalCall& call) {
    const std::lock_guard lock(busy_);
    Transaction one(db_, file_);
    insert(db_, file_, call);
    one.commit();
}

void Journal::drop_calls_from(int evaluation) {
    const std::lock_guard lock(busy_);
    const int first = std::max(evaluation, static_cast<int>(evaluations_.size()) + 1);
    Statement(db_, file_,
              text("DELETE FROM calls WHERE evaluation >= ? AND quantity NOT LIKE '", cheap_call, "%'").c_str())
        .bind(static_cast<long long>(first))
        .run();
}

std::vector<int> Journal::cached() const {
    Statement rows(
        db_, file_,
        text("SELECT DISTINCT evaluation FROM calls WHERE remarks LIKE '%is taken from the cache%' AND quantity NOT "
             "LIKE '",
             cheap_call, "%' ORDER BY evaluation")
            .c_str());
    std::vector<int> numbers;
    while (rows.step()) numbers.push_back(static_cast<int>(rows.integer(0)));
    return numbers;
}

std::vector<ProgramCost> Journal::program_costs() const {
    Statement rows(db_, file_,
                   "SELECT quantity, COUNT(*), SUM(failure <> ''), SUM(remarks LIKE '%is taken from the cache%'), "
                   "SUM(seconds) FROM calls GROUP BY quantity ORDER BY quantity");
    std::vector<ProgramCost> costs;
    while (rows.step())
        costs.push_back({rows.words(0), static_cast<int>(rows.integer(1)), static_cast<int>(rows.integer(2)),
                         static_cast<int>(rows.integer(3)), rows.number(4)});
    return costs;
}

void Journal::set_limits(int max_evaluations, double max_seconds) {
    if (limits().evaluations == max_evaluations && limits().seconds == max_seconds) return;
    add({std::max(static_cast<int>(evaluations_.size()), limits().after), max_evaluations, max_seconds});
}

void Journal::add(const RunLimits& next) {
    Statement(db_, file_, "INSERT OR REPLACE INTO limits VALUES (?, ?, ?)")
        .bind(static_cast<long long>(next.after))
        .bind(static_cast<long long>(next.evaluations))
        .bind(next.seconds)
        .run();
    if (limits_.back().after == next.after) limits_.pop_back();
    limits_.push_back(next);
}

void Journal::set_case(const std::string& yaml) {
    FactTable table = fact_table(db_, file_);
    table["case"] = yaml;
    Transaction both(db_, file_);
    write_fact(db_, file_, "case", yaml);
    write_fact(db_, file_, "hash", check_of(table));
    both.commit();
    facts_.case_yaml = yaml;
}

}  // namespace strake
