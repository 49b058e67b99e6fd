#include "optimize/journal/journal_tables.hpp"

#include "core/error.hpp"
#include "optimize/journal/content_hash.hpp"
#include "optimize/journal/packed_arrays.hpp"

#include <sqlite3.h>
#include <cerrno>
#include <cmath>
#include <cstdint>

namespace strake {
namespace {

void add_to_sum(std::string& bytes, std::int64_t value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}
void add_to_sum(std::string& bytes, const std::string& words) {
    add_to_sum(bytes, static_cast<std::int64_t>(words.size()));
    bytes += words;
}

std::string packed_vector(const Eigen::VectorXd& v) {
    return {reinterpret_cast<const char*>(v.data()), sizeof(double) * static_cast<std::size_t>(v.size())};
}

std::string check_of(const JournalEvaluation& e) {
    std::string bytes;
    for (const std::int64_t value : {std::int64_t{e.number}, std::int64_t{e.level}, std::int64_t{e.accepted},
                                     std::int64_t{e.is_taken_over}, std::int64_t{e.is_final_failure}})
        add_to_sum(bytes, value);
    for (const std::string& words :
         {e.status, e.reason, packed_vector(e.x), packed(e.values), packed(e.parameters), e.surface})
        add_to_sum(bytes, words);
    for (const double value : {e.objective, e.max_violation, e.max_displacement, e.seconds, e.elapsed})
        bytes += packed(std::vector<double>{std::isfinite(value) ? value : std::numeric_limits<double>::quiet_NaN()});
    return content_hash(bytes);
}

std::string check_of(const JournalCall& c, const std::string& gradients, const std::string& down) {
    std::string bytes;
    add_to_sum(bytes, c.evaluation);
    const Failure none, &failure = c.result.failure ? *c.result.failure : none;
    for (const std::string& words : {c.quantity, c.program, c.surface, packed(c.result.values), gradients, down,
                                     failure.kind, failure.message, lines_of(c.result.remarks)})
        add_to_sum(bytes, words);
    return content_hash(bytes);
}

constexpr const char* tables = R"(
CREATE TABLE facts (name TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE limits (after INTEGER PRIMARY KEY, evaluations INTEGER NOT NULL, seconds REAL NOT NULL);
CREATE TABLE evaluations (number INTEGER PRIMARY KEY, level INTEGER NOT NULL, status TEXT NOT NULL,
  reason TEXT NOT NULL, x BLOB NOT NULL, vals BLOB NOT NULL, own BLOB NOT NULL, objective REAL, max_violation REAL,
  max_displacement REAL, accepted INTEGER NOT NULL, is_taken_over INTEGER NOT NULL, is_final_failure INTEGER NOT NULL,
  surface TEXT NOT NULL, seconds REAL NOT NULL, elapsed REAL NOT NULL, hash TEXT NOT NULL);
CREATE TABLE calls (evaluation INTEGER NOT NULL, quantity TEXT NOT NULL, program TEXT NOT NULL, surface TEXT NOT NULL,
  vals BLOB NOT NULL, gradients BLOB NOT NULL, derivatives BLOB NOT NULL, failure TEXT NOT NULL, message TEXT NOT NULL,
  remarks TEXT NOT NULL, seconds REAL NOT NULL, hash TEXT NOT NULL, PRIMARY KEY (evaluation, quantity));
PRAGMA application_id = 1400140139;
PRAGMA user_version = 1;
)";

}  // namespace

#define COLUMNS_OF_EVALUATIONS                                                                                   \
    "SELECT number, level, status, reason, x, vals, own, objective, max_violation, max_displacement, accepted, " \
    "is_taken_over, is_final_failure, surface, seconds, elapsed, hash FROM evaluations "
#define COLUMNS_OF_CALLS                                                                                       \
    "SELECT evaluation, quantity, program, surface, vals, gradients, derivatives, failure, message, remarks, " \
    "seconds, "                                                                                                \
    "hash FROM calls "
const char* const select_evaluations = COLUMNS_OF_EVALUATIONS "ORDER BY number";
const char* const select_evaluation = COLUMNS_OF_EVALUATIONS "WHERE number = ?";
const char* const select_calls = COLUMNS_OF_CALLS;
const char* const select_calls_of = COLUMNS_OF_CALLS "WHERE evaluation = ?";
const char* const select_call = COLUMNS_OF_CALLS "WHERE evaluation = ? AND quantity = ?";

void set_fact(JournalFacts& facts, const std::string& name, const std::string& value) {
    if (name == "case") facts.case_yaml = value;
    if (name == "case_dir") facts.case_dir = value;
    if (name == "host") facts.host = value;
    if (name == "command") facts.is_fit = value == "fit";
    if (name == "meaning") facts.meaning = meaning_of(value);
    if (name == "values") facts.values = names_in(value);
    if (name == "own") facts.parameters = names_in(value);
    if (name != "files") return;
    for (const std::string& line : names_in(value)) {
        const std::size_t blank = line.rfind(' ');
        if (blank != std::string::npos) facts.files[line.substr(0, blank)] = line.substr(blank + 1);
    }
}

std::string check_of(const FactTable& facts) {
    std::string bytes;
    for (const auto& [name, value] : facts)
        if (name != "hash") {
            add_to_sum(bytes, name);
            add_to_sum(bytes, value);
        }
    return content_hash(bytes);
}

bool is_sound(const FactTable& facts) {
    const auto hash = facts.find("hash");
    return hash == facts.end() || hash->second == check_of(facts);
}

FactTable fact_table(sqlite3* db, const std::filesystem::path& file) {
    FactTable facts;
    Statement row(db, file, "SELECT name, value FROM facts");
    while (row.step()) facts[row.words(0)] = row.words(1);
    return facts;
}

/// SQLite says "disk I/O error" where the log ahead of the file cannot grow.
bool is_disk_full(sqlite3* db, const std::filesystem::path& file, int code) {
    if ((code & 0xff) == SQLITE_FULL) return true;
    if ((code & 0xff) != SQLITE_IOERR) return false;
    const int error = db != nullptr ? sqlite3_system_errno(db) : 0;
    if (error == ENOSPC || error == EDQUOT) return true;
    std::error_code why;
    const auto space = std::filesystem::space(file.has_parent_path() ? file.parent_path() : ".", why);
    constexpr std::uintmax_t a_few_pages = 128 * 1024;
    return !why && space.available < a_few_pages;
}

std::string sqlite_words(sqlite3* db, const std::filesystem::path& file, int code) {
    const std::string why = db != nullptr ? sqlite3_errmsg(db) : sqlite3_errstr(code);
    if (is_disk_full(db, file, code))
        return text(file.string(), ": cannot write: the disk is full; all evaluations before are kept");
    switch (code & 0xff) {
        case SQLITE_CORRUPT:
        case SQLITE_NOTADB:
        case SQLITE_ERROR:
            return text(file.string(), ": the journal is damaged (", why, "); nothing was changed");
        case SQLITE_READONLY:
        case SQLITE_CANTOPEN:
        case SQLITE_PERM:
            return text(file.string(), ": cannot write: ", why);
        case SQLITE_BUSY:
        case SQLITE_LOCKED:
            return text(file.string(), ": another program holds it locked; try again once that has ended");
        default:
            return text(file.string(), ": ", why, " (SQLite ", code, ")");
    }
}

void throw_sqlite(sqlite3* db, const std::filesystem::path& file, int code) {
    const int kind = code & 0xff;
    // SQLITE_ERROR: our statements do not fit the tables, whose names or columns are not what was written.
    if (kind == SQLITE_CORRUPT || kind == SQLITE_NOTADB || kind == SQLITE_ERROR)
        throw InputError(sqlite_words(db, file, code));
    if (kind == SQLITE_READONLY || kind == SQLITE_CANTOPEN || kind == SQLITE_PERM)
        throw ReadOnly(sqlite_words(db, file, code));
    throw OutputError(sqlite_words(db, file, code));
}

Statement::Statement(sqlite3* db, const std::filesystem::path& file, const char* sql) : db_(db), file_(file) {
    if (const int code = sqlite3_prepare_v2(db, sql, -1, &statement_, nullptr); code != SQLITE_OK)
        throw_sqlite(db, file, code);
}
Statement::~Statement() { sqlite3_finalize(statement_); }

Statement& Statement::checked(int code, std::size_t size) {
    if (code == SQLITE_OK) return *this;
    if ((code & 0xff) != SQLITE_TOOBIG) throw_sqlite(db_, file_, code);
    throw OutputError(text(file_.string(), ": cannot keep a value of ", size, " bytes, the limit is ",
                           sqlite3_limit(db_, SQLITE_LIMIT_LENGTH, -1),
                           "; ask for fewer values with gradients at once, or for gradients on fewer vertices"));
}
Statement& Statement::bind(long long value) {
    return checked(sqlite3_bind_int64(statement_, ++bound_, value), sizeof value);
}
Statement& Statement::bind(double value) {
    ++bound_;
    if (!std::isfinite(value)) return checked(sqlite3_bind_null(statement_, bound_), 0);
    return checked(sqlite3_bind_double(statement_, bound_, value), sizeof value);
}
Statement& Statement::bind(const std::string& words) {
    return checked(sqlite3_bind_text64(statement_, ++bound_, words.data(), words.size(), SQLITE_TRANSIENT, SQLITE_UTF8),
                   words.size());
}
Statement& Statement::blob(const std::string& bytes) {
    return checked(sqlite3_bind_blob64(statement_, ++bound_, bytes.data(), bytes.size(), SQLITE_TRANSIENT),
                   bytes.size());
}

bool Statement::step() {
    const int code = sqlite3_step(statement_);
    if (code == SQLITE_ROW) return true;
    if (code != SQLITE_DONE) throw_sqlite(db_, file_, code);
    return false;
}

long long Statement::integer(int column) const { return sqlite3_column_int64(statement_, column); }
double Statement::number(int column) const {
    if (sqlite3_column_type(statement_, column) == SQLITE_NULL) return std::numeric_limits<double>::quiet_NaN();
    return sqlite3_column_double(statement_, column);
}
std::string Statement::words(int column) const { return bytes(column); }
std::string Statement::bytes(int column) const {
    const void* data = sqlite3_column_blob(statement_, column);
    const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement_, column));
    return size > 0 ? std::string(static_cast<const char*>(data), size) : std::string();
}

void make_tables(sqlite3* db, const std::filesystem::path& file) {
    if (const int code = sqlite3_exec(db, tables, nullptr, nullptr, nullptr); code != SQLITE_OK)
        throw_sqlite(db, file, code);
}

void insert(sqlite3* db, const std::filesystem::path& file, const JournalEvaluation& e) {
    Statement row(db, file, "INSERT INTO evaluations VALUES (?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?)");
    row.bind(static_cast<long long>(e.number)).bind(static_cast<long long>(e.level)).bind(e.status).bind(e.reason);
    row.blob(packed_vector(e.x)).blob(packed(e.values)).blob(packed(e.parameters));
    row.bind(e.objective).bind(e.max_violation).bind(e.max_displacement);
    for (const bool flag : {e.accepted, e.is_taken_over, e.is_final_failure}) row.bind(static_cast<long long>(flag));
    row.bind(e.surface).bind(e.seconds).bind(e.elapsed).bind(check_of(e)).run();
}

void insert(sqlite3* db, const std::filesystem::path& file, const JournalCall& c) {
    Statement row(db, file, "INSERT INTO calls VALUES (?,?,?,?,?,?,?,?,?,?,?,?)");
    const std::string gradients = packed_all(c.result.dJ_dv), down = packed_all(c.result.dJ_dp);
    const Failure none, &failure = c.result.failure ? *c.result.failure : none;
    row.bind(static_cast<long long>(c.evaluation)).bind(c.quantity).bind(c.program).bind(c.surface);
    row.blob(packed(c.result.values)).blob(gradients).blob(down).bind(failure.kind).bind(failure.message);
    row.bind(lines_of(c.result.remarks)).bind(c.seconds).bind(check_of(c, gradients, down)).run();
}

JournalEvaluation evaluation_of(const Statement& row, const std::filesystem::path& file) {
    JournalEvaluation e;
    e.number = static_cast<int>(row.integer(0));
    e.level = static_cast<int>(row.integer(1));
    e.status = row.words(2);
    e.reason = row.words(3);
    const std::vector<double> x = unpacked(row.bytes(4));
    e.x = Eigen::VectorXd::Map(x.data(), static_cast<Eigen::Index>(x.size()));
    e.values = unpacked(row.bytes(5));
    e.parameters = unpacked(row.bytes(6));
    e.objective = row.number(7);
    e.max_violation = row.number(8);
    e.max_displacement = row.number(9);
    e.accepted = row.integer(10) != 0;
    e.is_taken_over = row.integer(11) != 0;
    e.is_final_failure = row.integer(12) != 0;
    e.surface = row.words(13);
    e.seconds = row.number(14);
    e.elapsed = row.number(15);
    if (check_of(e) != row.words(16))
        throw InputError(text(file.string(), ": the journal is damaged (evaluation ", e.number,
                              " is not what was written); nothing was changed"));
    return e;
}

JournalCall call_of(const Statement& row, const std::filesystem::path& file) {
    JournalCall c;
    c.evaluation = static_cast<int>(row.integer(0));
    c.quantity = row.words(1);
    c.program = row.words(2);
    c.surface = row.words(3);
    c.result.values = unpacked(row.bytes(4));
    const std::string gradients = row.bytes(5), down = row.bytes(6);
    if (!row.words(7).empty()) c.result.failure = Failure{row.words(7), row.words(8)};
    c.result.remarks = names_in(row.words(9));
    c.seconds = row.number(10);
    if (check_of(c, gradients, down) != row.words(11))
        throw InputError(text(file.string(), ": the journal is damaged (what ", c.quantity, " gave in evaluation ",
                              c.evaluation, " is not what was written); nothing was changed"));
    c.result.dJ_dv = unpacked_gradients(gradients);
    c.result.dJ_dp = unpacked_derivatives(down);
    return c;
}

}  // namespace strake
