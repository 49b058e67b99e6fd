#pragma once
#include "optimize/journal.hpp"

/// Rows of the journal as SQLite keeps them. Internal to the journal.
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
    sqlite3* db_;
    const std::filesystem::path& file_;
    sqlite3_stmt* statement_ = nullptr;
    int bound_ = 0;
};

/// Path, what SQLite says, and what to do. `code` of SQLite.
std::string sqlite_words(sqlite3* db, const std::filesystem::path& file, int code);
/// An OutputError where something could not be written, else an InputError.
[[noreturn]] void throw_sqlite(sqlite3* db, const std::filesystem::path& file, int code);

void make_tables(sqlite3* db, const std::filesystem::path& file);
void insert(sqlite3* db, const std::filesystem::path& file, const JournalEvaluation& evaluation);
void insert(sqlite3* db, const std::filesystem::path& file, const JournalCall& call);

/// @throws InputError naming the evaluation where a row is not what was written.
JournalEvaluation evaluation_of(const Statement& row, const std::filesystem::path& file);
JournalCall call_of(const Statement& row, const std::filesystem::path& file);
extern const char* const select_evaluations;  ///< in the order of their numbers
extern const char* const select_call;         ///< of an evaluation (1) and a quantity (2)
extern const char* const select_calls;        ///< all, to be checked

/// Gradients and derivatives of an answer: their number, then rows and entries of each.
std::string packed_all(const std::vector<Points>& all);
std::string packed_all(const std::vector<Eigen::VectorXd>& all);
/// @pre `bytes` are what packed_all gave.
std::vector<Points> unpacked_gradients(const std::string& bytes);
std::vector<Eigen::VectorXd> unpacked_derivatives(const std::string& bytes);
std::string packed(const std::vector<double>& values);
std::vector<double> unpacked(const std::string& bytes);
/// Names, which hold no line feed.
std::string lines_of(const std::vector<std::string>& names);
std::vector<std::string> names_in(const std::string& lines);

}  // namespace strake
