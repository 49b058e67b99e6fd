#pragma once
#include "optimize/run/run_records.hpp"

/// How a fit ended, in words. Internal to `fit`.
namespace strake {

enum class FitEnd {
    recovered,      ///< nothing is left but round-off
    converged,      ///< by a tolerance
    slackened,      ///< iterations remove too little
    budget,         ///< evaluations or time
    no_valid_step,  ///< next to the best design every shape is refused
    roundoff,       ///< no better step
    failed,         ///< a quantity gave no residuals
    no_design       ///< the level's first shape is refused
};

/// Fills what a fit tells of a level: `stop`, `explained`, `converged`. @param objective the best of the level;
/// `refused` why the last refused shape was.
void describe_level(LevelSummary& level, double objective, FitEnd end, const std::string& refused);

/// Fills `status` and `reason`: the verdict, what each level reached, whether finer ones are expected to help, and what
/// to try next.
/// @param is_shape_refused the last refusal was of the shape, not of a quantity on it
void conclude_fit(RunResult& result, FitEnd end, const std::string& refused, int last_level, bool is_shape_refused);

}  // namespace strake
