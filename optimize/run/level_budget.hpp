#pragma once
#include "optimize/run/level_program.hpp"

/// What a level may spend, and which search begins it. Internal.
namespace strake {

/// Fewer evaluations move no level: it begins with the shape that it inherits, steps too far and comes back.
inline constexpr int min_evaluations = 4;

/// The present level of a run. Functions give numbers of evaluations, at least 1.
class LevelBudget {
public:
    LevelBudget(const RunState& state, const LevelProgram& program) : state_(state), program_(program) {}

    /// Of the directions that tell what to choose (`next_by_values`).
    bool can_pay_trial() const;
    /// What is left, in equal parts for the levels to come: for no more of them than it can move.
    int by_differences() const;
    /// Of a level that is searched by models and not the last one: half of what is left, and no more points than two
    /// for each variable, one and a half of fields alone in runs that are long with them; all where finer variables
    /// could not be learned from the rest.
    int by_models() const;
    /// What is left tells so many variables apart: models of it gain more than models of fewer.
    bool can_learn(int variables) const;
    /// Where trials of values choose what comes next, few variables are searched by models: differences would pay for
    /// one gradient what brings these near their best. Equalities are met by chance only where models tell them.
    bool begins_by_models() const;

private:
    const RunState& state_;
    const LevelProgram& program_;
};

}  // namespace strake
