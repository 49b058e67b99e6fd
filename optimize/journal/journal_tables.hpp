#pragma once
#include "optimize/journal/journal_records.hpp"

#include <map>
#include <string>

/// Rows of the journal as SQLite keeps them. Internal to the journal.
struct sqlite3;
struct sqlite3_stmt;

namespace strake {

/// A statement of SQLite with its parameters, numbered from 1, and its present row, columns from 0.
class Statement {
public:
    /// @throws OutputError or InputError, as `Fault` says, with path and SQLite's words.
    Statement(sqlite3* db, const std::filesystem::path& file, const char* sql);
    ~Statement();
    Statement(const Statement&) = delete;
    Statement& operator=(const Statement&) = delete;

    /// @throws OutputError where SQLite does not take the value, for example one that is too large.
    Statement& bind(long long value);
    Statement& bind(double value);  ///< NaN: null
    Statement& bind(const std::string& words);
    Statement& blob(const std::string& bytes);
    bool step();  ///< true: there is a row
    void run() {
        while (step()) {
        }
    }

    long long integer(int column) const;
    double number(int column) const;  ///< null: NaN
    std::string words(int column) const;
    std::string bytes(int column) const;

private:
    Statement& checked(int code, std::size_t size);
    sqlite3* db_;
    const std::filesystem::path& file_;
    sqlite3_stmt* statement_ = nullptr;
    int bound_ = 0;
};

/// The file, or its folder, may be read but not written.
struct ReadOnly : OutputError {
    using OutputError::OutputError;
};
/// Path, what SQLite says, and what to do. `code` of SQLite.
std::string sqlite_words(sqlite3* db, const std::filesystem::path& file, int code);
/// An InputError where the file is damaged, ReadOnly where it may not be written, else an OutputError.
[[noreturn]] void throw_sqlite(sqlite3* db, const std::filesystem::path& file, int code);

/// Facts of a run as their table holds them, by name.
using FactTable = std::map<std::string, std::string>;
/// The sum that is kept among them as "hash"; journals of before have none.
std::string check_of(const FactTable& facts);
/// False: some fact is not what was written.
bool is_sound(const FactTable& facts);
/// @throws as `Statement`.
FactTable fact_table(sqlite3* db, const std::filesystem::path& file);
/// A row of the table of facts, of which there are at least `num_facts`.
void set_fact(JournalFacts& facts, const std::string& name, const std::string& value);
inline constexpr int num_facts = 7;

void make_tables(sqlite3* db, const std::filesystem::path& file);
void insert(sqlite3* db, const std::filesystem::path& file, const JournalEvaluation& evaluation);
void insert(sqlite3* db, const std::filesystem::path& file, const JournalCall& call);

/// @throws InputError naming the evaluation where a row is not what was written.
JournalEvaluation evaluation_of(const Statement& row, const std::filesystem::path& file);
JournalCall call_of(const Statement& row, const std::filesystem::path& file);
extern const char* const select_evaluations;  ///< in the order of their numbers
extern const char* const select_evaluation;   ///< of a number
extern const char* const select_calls_of;     ///< of an evaluation
extern const char* const select_call;         ///< of an evaluation (1) and a quantity (2)
extern const char* const select_calls;        ///< all, to be checked

}  // namespace strake
