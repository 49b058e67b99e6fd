#pragma once
#include "optimize/run/level_budget.hpp"

/// In which order a long run by values alone searches its groups of variables. Internal.
///
/// The first fields, then few patches alone to see what these gain. Where each evaluation of theirs gains `min_ratio`
/// of what each one before did, patches lead: the finest ones, then finer fields, one step after another, then the
/// patches again. Else finer fields by themselves, those after them beside the few patches, and the finest patches at
/// the end; where nothing has kept the limits yet, fields and patches together from the beginning. Patches rest while
/// fields go on alone, and fields while patches do, both with what they have done: models learn one group from fewer
/// points than both. Where the finest patches alone have come to rest with evaluations left, the first fields come back
/// beside them, then more: what each group does, the other one may have to follow. The order follows from what the run
/// has seen, so that a resumed one takes it again.
namespace strake {

class LevelOrder {
public:
    LevelOrder(RunState& state, const LevelBudget& budget) : state_(state), budget_(budget) {}

    /// Goes on to the level after the present one, which has ended. Empty: this run has no such order, its levels are
    /// those of the tree.
    std::optional<LevelSet> advance();
    /// Finer patches or fields may come below the present level, not only coarser fields again.
    bool has_finer_below() const;
    /// Of the present level. Nothing: by `LevelBudget::by_models`.
    std::optional<int> evaluations() const;
    /// `MinimizeOptions::limit_while_gaining` of the present level: half of what is left. 0: no more than its limit, on
    /// the first level, in a trial, and where the run is not a long one by models.
    int limit_while_gaining() const;

private:
    enum class Stage { first, trial, patches, fields, both, together, as_the_tree };

    bool has_order() const;
    /// Number of variables of the tree's patches at this level, were all of them free; 0: other than loads.
    int patch_variables(int level) const;
    /// The finest level of the tree with at most so many variables of patches; 0: there is none.
    int finest_with(int variables) const;
    /// Of the objective, from there to the best design of the level; not finite: it has none.
    double gain_from(double objective) const;
    bool patches_gain_more() const;
    /// Of a level with the next step of them; 0: all have been offered.
    int num_next_fields() const;
    /// So many evaluations are left for each of these variables.
    bool can_afford(int variables, double for_each) const;
    /// @param tree_level of the patches @param has_fields finer ones than those of the present level
    LevelSet enter(Stage stage, int tree_level, bool has_fields, int levels_below);

    /// The finest patches beside the first fields, then beside more of these. Empty: there are no more, or too few
    /// evaluations; the present level is the last one.
    std::optional<LevelSet> enter_together();
    /// Of the tree's level `finest`. @param fields of the next step; 0: there are no finer ones
    std::optional<LevelSet> after_patches(int finest, int fields);

    RunState& state_;
    const LevelBudget& budget_;
    Stage stage_ = Stage::first;
    FieldSet together_;               ///< that have come back
    bool leaves_out_fields_ = false;  ///< finer ones, which too few evaluations were left for
    bool patches_lead_ = false, was_feasible_ = false;
    double gain_before_ = 0;  ///< of the run, when the trial began
    int evaluations_before_ = 0;
};

}  // namespace strake
