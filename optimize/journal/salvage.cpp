#include "optimize/journal/salvage.hpp"

#include "optimize/journal/journal_tables.hpp"

#include <sqlite3.h>
#include <functional>

namespace strake {
namespace {

struct Database {
    sqlite3* db = nullptr;
    explicit Database(const std::filesystem::path& file) {
        if (sqlite3_open_v2(file.c_str(), &db, SQLITE_OPEN_READONLY, nullptr) == SQLITE_OK) return;
        sqlite3_close(db);
        db = nullptr;
    }
    Database(const Database&) = delete;
    Database& operator=(const Database&) = delete;
    ~Database() { sqlite3_close(db); }
};

/// Gives each row of a query to `take`. A page or a row that is damaged ends this query only.
void each_row(sqlite3* db, const std::filesystem::path& file, const char* sql, int key,
              const std::function<void(const Statement&)>& take) {
    try {
        Statement rows(db, file, sql);
        if (key > 0) rows.bind(static_cast<long long>(key));
        while (rows.step()) try {
                take(rows);
            } catch (const std::exception&) {  // this one is not what was written
            }
    } catch (const std::exception&) {
    }
}

}  // namespace

SalvagedJournal salvaged_journal(const std::filesystem::path& file, int evaluations) {
    SalvagedJournal found;
    const Database opened(file);
    if (!opened.db) return found;
    JournalFacts facts;
    facts.meaning = 1;  // of a journal that does not say it
    FactTable table;
    each_row(opened.db, file, "SELECT name, value FROM facts", 0,
             [&](const Statement& row) { table[row.words(0)] = row.words(1); });
    for (const auto& [name, value] : table) set_fact(facts, name, value);
    if (static_cast<int>(table.size()) >= num_facts && is_sound(table) && !facts.case_yaml.empty()) found.facts = facts;
    each_row(
        opened.db, file, "SELECT after, evaluations, seconds FROM limits ORDER BY after", 0, [&](const Statement& row) {
            const RunLimits limits{static_cast<int>(row.integer(0)), static_cast<int>(row.integer(1)), row.number(2)};
            if (limits.evaluations > 0) found.limits.push_back(limits);
        });
    if (!found.limits.empty() && found.limits[0].after != 0) found.limits.clear();
    for (int number = 1; number <= evaluations; ++number) {
        if (static_cast<int>(found.evaluations.size()) == number - 1)
            each_row(opened.db, file, select_evaluation, number, [&](const Statement& row) {
                const JournalEvaluation evaluation = evaluation_of(row, file);
                if (evaluation.number == number && !evaluation.is_final_failure)
                    found.evaluations.push_back(evaluation);
            });
        each_row(opened.db, file, select_calls_of, number,
                 [&](const Statement& row) { found.calls.push_back(call_of(row, file)); });
    }
    return found;
}

}  // namespace strake
