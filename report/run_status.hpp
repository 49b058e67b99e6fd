#pragma once
#include "optimize/journal/journal.hpp"
#include "optimize/run/run_records.hpp"
#include "report/run_lock.hpp"

/// The progress of a run, from its folder alone, also while it is running.
namespace strake {

struct RunStatus {
    std::string status;  ///< running | killed (it can be resumed) | a status of RunResult
    std::string reason;
    int level = 0, evaluations = 0;
    double objective = std::numeric_limits<double>::quiet_NaN();  ///< of the best design; NaN: none
    double max_violation = std::numeric_limits<double>::quiet_NaN();
    int best_evaluation = 0;
    int max_evaluations = 0;
    double seconds = 0;                                                ///< of the run, over all its starts
    double max_seconds = 0;                                            ///< 0: no limit
    double last_objective = std::numeric_limits<double>::quiet_NaN();  ///< of the last evaluation with a value
    double seconds_each = std::numeric_limits<double>::quiet_NaN();    ///< mean of the last ten; NaN: fewer than three
    std::vector<std::string> files;                                    ///< existing files, with the folder's path
    std::optional<LockHolder> holder;
};

/// @throws InputError if this is not a run folder: says whether the folder exists, and lists runs below it.
void need_run(const std::filesystem::path& folder);
/// @throws InputError: not a run folder, or its journal cannot be read.
/// @param is_over called by the holder of the lock at the end of its run.
RunStatus run_status(const std::filesystem::path& folder, bool is_over = false);
/// {status, reason, level, evaluations, objective, best, max_violation, files, ...} as `run_json`.
std::string status_json(const RunStatus& status);

/// The row of an evaluation in history.csv.
EvaluationRecord record_of(const JournalEvaluation& evaluation);

}  // namespace strake
