#pragma once
#include "optimize/journal.hpp"
#include "optimize/run_records.hpp"
#include "report/run_lock.hpp"

/// How far a run has come, from its folder alone, also while it goes on.
namespace strake {

struct RunStatus {
    std::string status;  ///< running | killed (it can be resumed) | as in RunResult
    std::string reason;
    int level = 0, evaluations = 0;
    double objective = std::numeric_limits<double>::quiet_NaN();  ///< of the best design; NaN: none
    double max_violation = std::numeric_limits<double>::quiet_NaN();
    int best_evaluation = 0;
    int max_evaluations = 0;
    double seconds = 0;                                                ///< of the run, in all its starts
    double max_seconds = 0;                                            ///< 0: no limit
    double last_objective = std::numeric_limits<double>::quiet_NaN();  ///< of the last evaluation that has one
    double seconds_each = std::numeric_limits<double>::quiet_NaN();    ///< of the last ten; NaN: fewer than three
    std::vector<std::string> files;                                    ///< that are there, with the folder's path
    std::optional<LockHolder> holder;
};

/// @throws InputError where the folder holds no run: whether there is a folder at all, and runs below it.
void need_run(const std::filesystem::path& folder);
/// @throws InputError: the folder holds no run, or its journal cannot be read.
/// @param is_over whoever holds the lock has come to the end of its run, and says so.
RunStatus run_status(const std::filesystem::path& folder, bool is_over = false);
/// {status, reason, level, evaluations, objective, best, max_violation, files, ...} as `run_json`.
std::string status_json(const RunStatus& status);

/// What history.csv has of an evaluation.
EvaluationRecord record_of(const JournalEvaluation& evaluation);

}  // namespace strake
