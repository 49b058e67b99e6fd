#pragma once
#include "optimize/constraints.hpp"
#include "optimize/run_records.hpp"

/// How a run ended, in a word and in words, with the next thing to try. Internal.
namespace strake {

struct RunEnd {
    const MinimizeResult& level;  ///< of the last level
    const ConstraintRows& rows;
    bool quantity_failed = false;
    bool last_failed_in_quantity = false;  ///< what blocks the run is no fault of the surface
    bool is_feasible = false;              ///< there is a feasible design
    bool can_refine = false;               ///< there are finer patches
    bool refining_is_idle = false;         ///< they promise nothing
};

/// Fills status, reason and the names of conflicting constraints. @pre the other fields of the result are final.
void conclude_run(RunResult& result, const RunEnd& end);

/// The run was stopped by the user.
void conclude_interrupted(RunResult& result);
/// It waits for answers from outside.
void conclude_waiting(RunResult& result);

/// Why a level ended.
std::string level_words(const MinimizeResult& level);

}  // namespace strake
