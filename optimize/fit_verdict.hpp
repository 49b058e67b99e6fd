#pragma once
#include "optimize/run_records.hpp"

/// How a fit ended, in words. Internal to `fit`.
namespace strake {

enum class FitEnd {
    recovered,  ///< nothing is left but round-off
    converged,  ///< by a tolerance
    slackened,  ///< iterations remove too little
    budget,     ///< evaluations or time
    blocked,    ///< next to the best design every shape is refused
    roundoff,   ///< no better step
    failed,     ///< a quantity gave no residuals
    no_design   ///< the level's first shape is refused
};

/// Fills what a fit tells of a level: `stop`, `explained`, `converged`. @param objective the best of the level;
/// `refused` why the last refused shape was.
void describe_level(LevelSummary& level, double objective, FitEnd end, const std::string& refused);

/// Fills `status` and `reason`: the verdict, what each level reached, whether finer ones promise anything, and what to
/// try next.
void conclude_fit(RunResult& result, FitEnd end, const std::string& refused, int last_level);

}  // namespace strake
