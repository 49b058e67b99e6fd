#include "cli/continuation.hpp"

#include "casefile/read/resolved_case.hpp"
#include "core/error.hpp"
#include "core/planform/kept_sections.hpp"
#include "optimize/run/known_designs.hpp"
#include "report/recorded_run.hpp"

#include <fstream>

namespace strake::cli {
namespace {

/// Refuses a case that differs from the one the run started with, and names what changed.
void check_same_case(const Case& the_case, const JournalFacts& facts, const std::string& yaml) {
    std::vector<std::string> changed;
    for (const std::string& key : changed_keys(facts.case_yaml, yaml))
        if (!may_change(key)) changed.push_back(key);
    if (!changed.empty())
        throw InvalidInput(text(
            the_case.file.string(), ": ", joined(changed), changed.size() > 1 ? " have" : " has",
            " changed since the run started; only budget, output, timeouts, parallel, scheduler and cache may change. "
            "Undo the change, or start another run (optimize.start_from starts at a design of this one)"));
    const std::map<std::string, std::string> files = file_hashes(the_case);
    if (facts.files.contains(known_designs_key) && !files.contains(known_designs_key))
        throw InvalidInput(text(the_case.file.string(), ": ", known_designs_key,
                                ": they are no longer there, and the search has learned from them. Restore that folder "
                                "(journal.sqlite, levels), or start another run"));
    for (const auto& [key, hash] : files)
        if (const auto then = facts.files.find(key); then != facts.files.end() && then->second != hash)
            throw InvalidInput(text(the_case.file.string(), ": ", key,
                                    ": the file has changed since the run started. "
                                    "Restore it, or start another run"));
}

/// Number of the best design so far; 0: none.
int last_accepted(const Journal& journal) {
    int best = 0;
    for (const JournalEvaluation& e : journal.evaluations())
        if (e.accepted) best = e.number;
    return best;
}

}  // namespace

void keep_meaning(Case& the_case, int meaning) {
    constexpr int since_shapes_are_limited = 2, since_outlines_are_kept = 3, since_ranges_widen = 4,
                  since_held_motion_counts = 5, since_polynomials_keep_edges = 6, since_ranges_begin_wide = 6,
                  since_shell_ranges_begin_wide = 7, since_long_steps_are_asked = 7, since_edges_are_kept = 7,
                  since_large_bodies_are_quick = 8, since_coarse_noses_stay = 8, since_stations_are_level = 8,
                  since_noses_are_corners_later = 8, since_winglets_are_followed = 9, since_boxes_sum = 10,
                  since_curvature_is_shared = 11, since_wings_have_fields = 11, since_binding_is_tried = 12,
                  since_levels_must_move = 12, since_exact_limits_have_slopes = 13, since_long_runs_have_models = 14,
                  since_limits_are_met_together = 15, since_long_runs_begin_quickly = 16,
                  since_minima_have_directions = 17, since_normals_are_curved = 18, since_patches_are_tried = 18,
                  since_models_have_wide_ranges = 19, since_equations_are_restored = 19, since_shapes_are_free = 19,
                  since_symmetry_is_seen = 20, since_rough_fields_are_curved = 21, since_patches_lead_sooner = 21,
                  since_all_fields_are_offered = 22, since_steps_are_free = 22, since_limits_are_restored = 22,
                  since_borders_are_kept = 23, since_wide_bodies_have_noses = 24, since_first_fields_ask_less = 25,
                  since_energy_is_shared = 26, since_parts_of_parts_are_seen = 26, since_ties_are_broken = 26,
                  since_patches_are_single = 27, since_waves_are_seen = 28, since_levels_go_on = 29,
                  since_all_is_tried = 30, since_short_waves_are_noise = 31, since_levels_may_slow_down = 32;
    for (WingEntry& wing : the_case.planform) {
        wing.keeps_outline = wing.keeps_outline && meaning >= since_outlines_are_kept;
        wing.rules = meaning < since_noses_are_corners_later ? WingRules::earlier
                     : meaning < since_winglets_are_followed ? WingRules::sliding
                                                             : WingRules::latest;
    }
    the_case.hold.rounding_breaks_ties = meaning < since_ties_are_broken;
    the_case.parameters.limits_variables = meaning < since_shapes_are_limited;
    the_case.optimize.is_relative_to_objective = meaning < since_shapes_are_limited;
    the_case.optimize.shares_with_all_levels = meaning < since_shapes_are_limited;
    the_case.parameters.counts_kept_motion_alone = meaning < since_held_motion_counts;
    the_case.parameters.lets_edges_fold = meaning < since_edges_are_kept;
    the_case.parameters.lets_border_turn = meaning < since_borders_are_kept;
    if (the_case.wrap && meaning < since_binding_is_tried) the_case.wrap->max_centers = WrapBindingOptions().centers;
    if (the_case.wrap)
        the_case.wrap->sums = meaning < since_large_bodies_are_quick ? RadialSums::by_products
                              : meaning < since_boxes_sum            ? RadialSums::by_centers
                                                                     : RadialSums::by_boxes;
    the_case.parameters.fields.axis_by_extent_alone = meaning < since_wide_bodies_have_noses;
    the_case.parameters.fields.products_as_before = meaning < since_large_bodies_are_quick;
    the_case.parameters.fields.are_offered_by_steps = meaning < since_all_fields_are_offered;
    the_case.parameters.fields.are_sections_by_default = meaning < since_wings_have_fields;
    the_case.parameters.kept_rules = meaning < since_polynomials_keep_edges ? KeptRules::earlier
                                     : meaning < since_coarse_noses_stay    ? KeptRules::coarse_noses_move
                                                                            : KeptRules::latest;
    the_case.parameters.station_corners =
        meaning < since_stations_are_level ? StationCorners::kinked : StationCorners::level;
    the_case.optimize.keeps_ranges = meaning < since_ranges_widen;
    the_case.optimize.begins_with_narrow_ranges = meaning < since_ranges_begin_wide;
    the_case.optimize.begins_with_narrow_shell_ranges = meaning < since_shell_ranges_begin_wide;
    the_case.optimize.models_begin_with_narrow_ranges = meaning < since_models_have_wide_ranges;
    the_case.optimize.trusts_long_steps = meaning < since_long_steps_are_asked;
    the_case.optimize.learns_as_before = meaning < since_curvature_is_shared;
    the_case.optimize.descends_as_before = meaning < since_levels_must_move;
    the_case.optimize.limits_by_models = meaning < since_exact_limits_have_slopes;
    the_case.optimize.limits_by_turns = meaning < since_limits_are_met_together;
    the_case.optimize.minima_in_variables = meaning < since_minima_have_directions;
    the_case.optimize.leaves_equations = meaning < since_equations_are_restored;
    the_case.optimize.leaves_limits = meaning < since_limits_are_restored;
    the_case.optimize.pays_without_shape = meaning < since_shapes_are_free;
    the_case.optimize.steps_pay_without_shape = meaning < since_steps_are_free;
    the_case.optimize.ignores_symmetry |= meaning < since_symmetry_is_seen;
    the_case.optimize.one_curvature = meaning < since_normals_are_curved;
    the_case.optimize.fields_have_one_curvature = meaning < since_rough_fields_are_curved;
    the_case.optimize.fields_lead = meaning < since_patches_lead_sooner;
    the_case.optimize.patches_last = meaning < since_patches_are_tried;
    the_case.optimize.long_runs_by_differences = meaning < since_long_runs_have_models;
    the_case.optimize.begins_slowly = meaning < since_long_runs_begin_quickly;
    the_case.optimize.begins_with_whole_batches = meaning < since_first_fields_ask_less;
    the_case.optimize.counts_whole_energy = meaning < since_energy_is_shared;
    the_case.optimize.sees_parts_alone = meaning < since_parts_of_parts_are_seen;
    the_case.optimize.refines_whole_fronts = meaning < since_patches_are_single;
    the_case.optimize.ignores_waves |= meaning < since_waves_are_seen;
    the_case.optimize.levels_end_at_limits = meaning < since_levels_go_on;
    the_case.optimize.levels_gain_a_quarter = meaning < since_levels_may_slow_down;
    the_case.optimize.stays_where_models_are_sure = meaning < since_all_is_tried;
    the_case.optimize.images_are_exact = meaning < since_all_is_tried;
    the_case.optimize.follows_short_waves = meaning < since_short_waves_are_noise;
}

int written_meaning(const std::filesystem::path& dir) {
    std::ifstream yaml(dir / "case.yaml");
    std::string line;
    for (int k = 0; k < 2 && std::getline(yaml, line); ++k)
        if (line.starts_with(meaning_note)) return meaning_of(line.substr(std::string(meaning_note).size()));
    return 0;
}

Continuation continuation(const Case& the_case, const JournalFacts& facts, const std::filesystem::path& dir) {
    Continuation now;
    now.yaml = resolved_case(the_case, dir, stated_wrap(facts.case_yaml));
    check_same_case(the_case, facts, now.yaml);
    for (const std::string& key : changed_keys(facts.case_yaml, now.yaml)) {
        now.is_changed = true;
        now.has_new_budget |= key.starts_with("optimize.budget");
    }
    return now;
}

void begin_again(RunRequest& request, const Continuation& now, const RunLimits& limits) {
    Journal& journal = *request.journal;
    const RunLimits before = journal.limits();
    const auto unlimited = [](double seconds) {
        return seconds > 0 ? seconds : std::numeric_limits<double>::infinity();
    };
    if (limits.evaluations < before.evaluations || unlimited(limits.seconds) < unlimited(before.seconds))
        throw InvalidInput(text("the budget of a run can only be raised: it is ", before.evaluations, " evaluations",
                                before.seconds > 0 ? text(" and ", before.seconds, " s") : "",
                                "; to end the run sooner, interrupt it"));
    journal.set_limits(limits.evaluations, limits.seconds);
    if (now.is_changed) journal.set_case(now.yaml);
    request.folder->begin_best_at(last_accepted(journal));
}

}  // namespace strake::cli
