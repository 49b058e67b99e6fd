#pragma once
#include "optimize/run/level_program.hpp"

/// What a level may spend, which search begins it, and which variables the rest pays for. Internal.
namespace strake {

/// Fewer evaluations move no level: it begins with the shape that it inherits, steps too far and comes back.
inline constexpr int min_evaluations = 4;

/// The present level of a run. Functions give numbers of evaluations, at least 1.
class LevelBudget {
public:
    LevelBudget(const RunState& state, const LevelProgram& program) : state_(state), program_(program) {}

    /// What a search by models learns of the present level, and of so many variables next to it.
    int directions() const;
    int directions_of(int variables) const;

    /// Of the directions that tell what to choose (`next_by_values`).
    bool can_pay_trial() const;
    /// What is left, in equal parts for the levels to come: for no more of them than it can move.
    int by_differences() const;
    /// Of a level that is searched by models and not the last one: half of what is left, and no more points than two
    /// for each variable, one and a half of fields alone in runs that are long with them; all where finer variables
    /// could not be learned from the rest.
    int by_models() const;
    /// Where trials of values choose what comes next, few variables are searched by models: differences would pay for
    /// one gradient what brings these near their best. Equalities are met by chance only where models tell them.
    bool begins_by_models() const;
    /// A run that is long with fields, without variables of programs: it tries them in order, with few at first, and
    /// leaves them soon. Not with the meaning of earlier runs.
    bool begins_quickly() const;
    /// Where such a run by models has no new fields for the next level, and what is left does not pay for all of its
    /// variables, the fields rest: the level with its patches alone. Nothing: as the tree has it.
    std::optional<LevelSet> patches_alone() const;

private:
    /// What is left tells so many variables apart.
    bool can_learn(int variables) const;

    const RunState& state_;
    const LevelProgram& program_;
};

}  // namespace strake
