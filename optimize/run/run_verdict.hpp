#pragma once
#include "optimize/evaluate/constraints.hpp"
#include "optimize/nlp/program/minimize_options.hpp"
#include "optimize/run/run_records.hpp"
#include "optimize/space/motion_limit.hpp"

/// How a run ended, in a word and in words, with the next thing to try. Internal.
namespace strake {

struct RunEnd {
    const MinimizeResult& level;  ///< of the last level
    const ConstraintRows& rows;
    bool quantity_failed = false;
    bool last_failed_in_quantity = false;  ///< what blocks the run is no fault of the surface
    bool is_feasible = false;              ///< there is a feasible design
    bool can_refine = false;               ///< there are finer patches
    bool refining_is_idle = false;         ///< they are not expected to gain anything
    std::string objective;                 ///< its name
    bool is_maximized = false;
    int max_evaluations = 0;  ///< of the run
    int level_best = 0;       ///< number of the evaluation that is the best of the last level
};

/// Fills status, reason and the names of conflicting constraints. @pre the other fields of the result are final.
void conclude_run(RunResult& result, const RunEnd& end);

/// The run was stopped by the user.
void conclude_interrupted(RunResult& result);
/// It waits for answers from outside.
void conclude_waiting(RunResult& result);

/// What is known of the motion limit at the best design without gradients. @param slack share of the limits that the
/// search keeps
MotionAtEnd motion_of(const RunResult& result, const MotionLimit& limit, double slack);
/// Name of the patch that the vertex belongs to.
std::string patch_at(const DesignSpace& space, int vertex);
/// Variables of the best design that lie at a bound of their own, which no max_displacement moves: "alpha at its max".
std::vector<std::string> own_bounds(const RunResult& result);
/// "; the motion limit is active on wing.upper, at vertex 12 (...)"; empty where it is not.
std::string motion_note(const RunResult& result);

/// Why a level ended.
std::string level_words(const MinimizeResult& level);

}  // namespace strake
