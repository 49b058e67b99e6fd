#pragma once
#include "core/error.hpp"
#include "objectives/quantity/quantity.hpp"

#include <filesystem>
#include <map>

/// What a journal holds, row by row.
namespace strake {

/// Names of answers that cheap models gave for designs that are not evaluated begin with this; they have numbers of
/// their own.
inline constexpr const char* cheap_call = "low_fidelity ";

/// A run asks for something else than what its journal says that it did; the text says where, and why that may be.
struct ReplayMismatch : InvalidInput {
    using InvalidInput::InvalidInput;
};

/// The limits of a run, in force once `after` evaluations have been made.
struct RunLimits {
    int after = 0, evaluations = 0;
    double seconds = 0;  ///< 0: no limit
};

/// Of runs that begin now; the first is 1.
constexpr int latest_meaning = 32;
inline int meaning_of(const std::string& written) {
    for (int meaning = 1; meaning < latest_meaning; ++meaning)
        if (written == std::to_string(meaning)) return meaning;
    return latest_meaning;
}

struct JournalFacts {
    std::string case_yaml;           ///< as in case.yaml of the folder
    std::filesystem::path case_dir;  ///< of the file that the run was started with, absolute
    std::string host;                ///< machine on which the run began
    bool is_fit = false;
    /// 1: `max_displacement` bounds variables (`Parameters::limits_variables`); 2: shapes,
    /// `objective_tolerance` is a share of the gain (`OptimizeOptions::is_relative_to_objective`), and a budget is
    /// shared among the levels that it can move (`OptimizeOptions::shares_with_all_levels`); 3: what moves a wing keeps
    /// its edges (`Parameters::kept_sections`); 4: ranges of variables widen (`OptimizeOptions::keeps_ranges`); 5: what
    /// sections that are kept take out of fields counts (`Parameters::counts_kept_motion_alone`); 6: edges of sections
    /// are kept by `KeptRules::coarse_noses_move`, and ranges are as wide as the motion limit lets variables be
    /// together (`OptimizeOptions::begins_with_narrow_ranges`); 7: with a shell, too
    /// (`begins_with_narrow_shell_ranges`), and what long steps leave open of a gradient is asked again
    /// (`MinimizeOptions::trusts_long_steps`), and searches keep a shell's edges from folding
    /// (`Parameters::lets_edges_fold`); 8: large bodies follow their wraps by sums in another order
    /// (`RadialSums::by_centers`), fields are products in one (`FieldOptions`), edges of sections are kept
    /// by `KeptRules::latest`, stations of a wing are `StationCorners::level`, and wings are measured by
    /// `WingRules::sliding`; 9: by `WingRules::latest`; 10: bodies of many vertices follow their wraps by sums over
    /// boxes (`RadialSums::by_boxes`); 11: models of `method: model` have a curvature that all directions share
    /// (`OptimizeOptions::learns_as_before`), and fields are those of a wing where it keeps its planform and a program
    /// gives values only (`FieldsEntry::Kind`); 12: levels have to move before they are left for finer ones, and coarse
    /// ones by differences begin by `model` in order (`OptimizeOptions::descends_as_before`); wraps that carry badly
    /// get more centres (`WrapBindingOptions::max_centers`); 13: searches by models know the slopes of limits that are
    /// known exactly (`MinimizeOptions::limits_by_models`); 14: long runs by values alone that begin with fields are
    /// searched by models (`OptimizeOptions::long_runs_by_differences`); 15: searches by models meet limits that are
    /// known exactly and the motion limit together, and propose designs that have a shape
    /// (`MinimizeOptions::limits_by_turns`); 16: long runs that begin in order by models begin with half a batch, have
    /// a shorter first level, and levels of patches alone (`OptimizeOptions::begins_slowly`); 17: minima of models are
    /// looked for in the directions that their points tell of (`MinimizeOptions::minima_in_variables`); 18: models of
    /// patches alone have a second curvature (`OptimizeOptions::one_curvature`), and long runs by models try patches
    /// before finer fields (`OptimizeOptions::patches_last`); 19: searches by models begin with wide ranges, too
    /// (`OptimizeOptions::models_begin_with_narrow_ranges`), lead back to equations (`leaves_equations`), and do not
    /// pay for designs that have no valid shape (`pays_without_shape`); 20: long ones search symmetric designs alone
    /// where values are the same for mirror images (`ignores_symmetry`); 21: models of
    /// fields have a second curvature (`fields_have_one_curvature`), patches lead sooner, and fields come back after
    /// the finest of them (`fields_lead`); 22: by exact gradients a refinement is offered all fields
    /// (`Parameters::offers_fields_by_steps`), steps of sqp that lead to no valid shape cost no evaluation
    /// (`steps_pay_without_shape`), and searches by models lead back to limits that are known exactly
    /// (`leaves_limits`); 23: a border of what is held that is kept smooth limits every design
    /// (`Parameters::lets_border_turn`); 24: bodies as wide as long have the axis of fields in their plane of symmetry
    /// (`FieldOptions::axis_by_extent_alone`); 25: the first level of long runs by models that begin with fields asks
    /// half batches (`OptimizeOptions::begins_with_whole_batches`); 26: by gradients elastic energies beside fields
    /// count a share (`energy_share`), and refinement looks at parts of parts (`OptimizeOptions::sees_parts_alone`); of
    /// triangles as near to the middle `hold: point` takes one, whatever rounding says; 27: by gradients single patches
    /// have variables beside fields (`OptimizeOptions::refines_whole_fronts`); 28: runs with fields look for waves of
    /// many minima, go back to the first fields, and begin there once more (`OptimizeOptions::ignores_waves`); 29:
    /// levels of long runs by models go on while they gain (`OptimizeOptions::levels_end_at_limits`); 30: searches by
    /// models look along what they know nothing of, whatever they are sure of (`stays_where_models_are_sure`), and
    /// do not take images of patches for exact (`images_are_exact`); 31: waves shorter than the spacing of points are
    /// noise to models (`follows_short_waves`); 32: levels of long runs by models go on where their last quarter gains
    /// 15 % of all, not a quarter (`levels_gain_a_quarter`).
    int meaning = latest_meaning;
    std::vector<std::string> values, parameters;  ///< names of the values and of the parameters
    std::map<std::string, std::string> files;     ///< hash of each file that the case names
};

struct JournalEvaluation {
    int number = 0;  ///< from 1, without gaps
    int level = 0;
    std::string status, reason;  ///< as in EvaluationRecord
    Eigen::VectorXd x;           ///< the whole design, exact
    std::vector<double> values, parameters;
    double objective = 0, max_violation = 0;  ///< NaN: none
    double max_displacement = 0;
    bool accepted = false, is_taken_over = false;
    /// A failure that ends the run is no answer: the next start asks again.
    bool is_final_failure = false;
    std::string surface;  ///< hash of the deformed surface; empty: none
    double seconds = 0;   ///< of this evaluation
    double elapsed = 0;   ///< of the run up to its end, in all starts together
};

/// What a program gave in an evaluation.
struct JournalCall {
    int evaluation = 0;
    std::string quantity;          ///< the name of its first value
    std::string program, surface;  ///< hashes of what was run and of what it was given
    QuantityResult result;
    double seconds = 0;
};

/// What calls of a program cost, all together.
struct ProgramCost {
    std::string quantity;  ///< as in JournalCall
    int calls = 0, failed = 0, cached = 0;
    double seconds = 0;
};

}  // namespace strake
