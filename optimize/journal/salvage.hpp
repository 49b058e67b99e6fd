#pragma once
#include "optimize/journal/journal_records.hpp"

#include <optional>
#include <vector>

namespace strake {

/// What can still be read of a damaged journal.
struct SalvagedJournal {
    std::optional<JournalFacts> facts;           ///< empty: some are missing
    std::vector<RunLimits> limits;               ///< in their order, the first after 0 evaluations; may be empty
    std::vector<JournalEvaluation> evaluations;  ///< from 1 without gaps
    std::vector<JournalCall> calls;              ///< of all evaluations
};

/// Reads it row by row. A row counts only if its check sum is right; the facts have none. Nothing is changed.
/// @param evaluations numbers up to this one are looked for. Never throws for what the file holds.
SalvagedJournal salvaged_journal(const std::filesystem::path& file, int evaluations);

}  // namespace strake
