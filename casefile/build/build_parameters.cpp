#include "casefile/build/problem_builder.hpp"
#include "core/planform/kept_sections.hpp"
#include "optimize/problem/place_user_variables.hpp"
#include "optimize/space/mirror.hpp"
#include "optimize/space/motion_limit.hpp"

namespace strake {
namespace {

constexpr double beyond_reason = 0.5;  ///< diagonals
constexpr double no_limit_yet = std::numeric_limits<double>::infinity();

}  // namespace

void ProblemBuilder::set_parameters() {
    const ParameterEntry& entry = case_.parameters;
    Parameters& p = out_.problem.parameters;
    p.kinds = entry.variables;
    p.strain_rotates = entry.strain_rotates;
    p.strain_translates = entry.strain_translates;
    p.load_directions = entry.directions;
    p.free_border = entry.free_border;
    set_motion_limits();
    if (entry.split.kind == SplitEntry::Kind::sensitivity) p.split = SplitRule::sensitivity;
    if (entry.split.kind == SplitEntry::Kind::gradient) p.split = SplitRule::gradient;
    p.marking_fraction = entry.marking_fraction;
    // Where gradients grow with fineness, as of the drag of a wave, all finer splines always promise more.
    p.offers_fields_by_steps = entry.fields.are_offered_by_steps || entry.fields.along == AlongAxis::splines;
    p.max_variable_ratio = entry.max_variable_ratio;
    p.mirror = entry.mirror;
    p.keeps_smooth_border = entry.keeps_smooth_border;
    p.lets_border_turn = entry.lets_border_turn;
    if (purpose_ == Purpose::deform && case_.has_shell) return;
    p.variables_on = marked("parameters.variables_on", entry.variables_on);
    if (!out_.problem.attached.empty()) {  // variables have nothing to move there
        if (p.variables_on.empty()) p.variables_on.assign(start_.mesh.num_triangles(), 1);
        for (const AttachedPart& part : out_.problem.attached)
            for (const int t : part.triangles) p.variables_on[t] = 0;
    }
    p.frozen = marked("parameters.frozen", entry.frozen);
    leave_frozen();
    for (const std::vector<Reference>& group : entry.groups) p.groups.push_back(marked("parameters.groups", group));
    set_user_values();
    if (!case_.parameters.planform.empty() && errors_.empty()) set_planform();
    if (case_.parameters.fields.is_wanted && errors_.empty()) set_fields();
    if (purpose_ == Purpose::deform) return;
    if (errors_.empty()) set_kept_sections();
    const bool is_search = !case_.objective.name.empty() || !case_.fit.empty();
    if (is_search && p.mirror && !start_plane())
        errors_.add(entry.mirror_place,
                    "parameters.mirror: the surface has no plane of symmetry (to 1e-3 of the diagonal)");
    if (is_search && errors_.empty() && !p.kinds.empty()) check_dof();
}

void ProblemBuilder::set_motion_limits() {
    const ParameterEntry& entry = case_.parameters;
    Parameters& p = out_.problem.parameters;
    const auto share = [&](const Length& length) {
        return length.is_relative_to_diagonal ? length.value : length.value / start_.diagonal;
    };
    p.max_displacement = share(entry.max_displacement);
    p.is_limit_stated = entry.is_limit_stated;
    p.limits_variables = entry.limits_variables;
    p.counts_kept_motion_alone = entry.counts_kept_motion_alone;
    p.lets_edges_fold = entry.lets_edges_fold;
    if (entry.variable_scale) p.variable_scale = share(*entry.variable_scale);
    if (entry.is_limit_stated && entry.is_planform_alone())
        out_.warnings.emplace_back(
            "parameters.max_displacement has no effect: only planform variables move the surface here, and the motion "
            "limit is about what moves it beside them; their `range` limits them");
    if (purpose_ == Purpose::deform) return;
    if (!entry.max_displacement_by_region.empty())
        p.max_outward = p.max_inward = Eigen::VectorXd::Constant(start_.mesh.num_vertices(), no_limit_yet);
    for (const MotionLimitEntry& limit : entry.max_displacement_by_region) {
        const double outward = limit.outward ? share(*limit.outward) : p.max_displacement;
        const double inward = limit.inward ? share(*limit.inward) : p.max_displacement;
        for (const int t : triangles(limit.region))
            for (int k = 0; k < 3; ++k) {
                const int v = start_.mesh.triangles(t, k);
                p.max_outward[v] = std::min(p.max_outward[v], outward);
                p.max_inward[v] = std::min(p.max_inward[v], inward);
            }
    }
    for (Eigen::VectorXd* limits : {&p.max_outward, &p.max_inward})
        for (double& limit : *limits)
            if (limit == no_limit_yet) limit = p.max_displacement;
    if (const double largest = largest_limit(p); !p.limits_variables && largest > beyond_reason)
        out_.warnings.push_back(text("parameters.max_displacement = ", largest * start_.diagonal, " is ",
                                     std::round(100 * largest), " % of the diagonal of the surface (", start_.diagonal,
                                     "): that limits next to nothing; 5% is the default"));
}

void ProblemBuilder::set_planform() {
    const std::vector<PlanformRangeEntry>& entries = case_.parameters.planform;
    std::vector<std::shared_ptr<const Wing>> wings;
    std::vector<std::shared_ptr<const Fuselage>> bodies;
    std::vector<std::string> names;  // of wings, then of bodies
    for (const bool is_body : {false, true})
        for (const PlanformRangeEntry& entry : entries) {
            if (bodies_.contains(entry.wing) != is_body) continue;
            if (std::find(names.begin(), names.end(), entry.wing) != names.end()) continue;
            names.push_back(entry.wing);
            if (is_body)
                bodies.push_back(bodies_.at(entry.wing));
            else
                wings.push_back(wings_.at(entry.wing));
        }
    std::shared_ptr<PlanformMotion> planform;
    const std::string path = "parameters.planform: ";
    at(entries.front().place, path, [&] {
        planform = std::make_shared<PlanformMotion>(start_.mesh, wings, std::vector<PlanformRange>(), bodies,
                                                    case_.parameters.station_corners);
    });
    // One after the other, so that what is refused is said where it stands.
    for (const PlanformRangeEntry& entry : entries) {
        if (!errors_.empty()) return;
        PlanformRange range = entry.range;
        range.wing = static_cast<int>(std::find(names.begin(), names.end(), entry.wing) - names.begin());
        at(entry.place, path, [&] { planform->add(start_.mesh, range); });
    }
    if (!errors_.empty()) return;
    at(entries.front().place, path, [&] { refuse_held(*planform, start_.mesh, out_.problem.fixed, "fixed"); });
    add_planform(out_.problem.parameters, planform);
}

/// Wings whose edges stay where loads, strains and fields would move them. Fits go where their data are; attached
/// parts and kinds of shape have rules of their own.
bool ProblemBuilder::keeps_edges() const {
    const Parameters& p = out_.problem.parameters;
    const bool is_motion_listed = !twists_.empty() || std::ranges::any_of(p.user_variables, [](const UserVariable& v) {
        return v.field < 0 && v.planform < 0 && v.traction.rows() == 0;
    });
    return !is_motion_listed && case_.fit.empty() && !p.invariance && out_.problem.attached.empty();
}

void ProblemBuilder::set_kept_sections() {
    Parameters& p = out_.problem.parameters;
    const bool moves = !p.kinds.empty() || p.fields || !case_.parameters.user_variables.empty();
    if (!moves || !keeps_edges()) return;
    std::vector<std::shared_ptr<const Wing>> wings;
    for (const WingEntry& entry : case_.planform)
        if (entry.keeps_outline) {
            wings.push_back(wings_.at(entry.name));
            at(entry.place, text("planform.", entry.name, ": keep: none lets its edges go; "), [&] {
                p.kept_sections = std::make_shared<const KeptSections>(start_.mesh, wings, out_.problem.fixed,
                                                                       case_.parameters.kept_rules);
            });
        }
}

void ProblemBuilder::check_dof() {
    const Parameters& p = out_.problem.parameters;
    if (!p.user_variables.empty() || !twists_.empty()) return;
    const int m = elastic().mesh.num_triangles();
    std::vector<char> held(m, 0);
    for (const int t : held_triangles()) held[t] = 1;
    for (const PrescribedStrain& strain : out_.problem.strains)
        for (const int t : strain.triangles) held[t] = 1;
    for (int t = 0; t < m; ++t)
        if (!held[t] && (p.variables_on.empty() || p.variables_on[t]) && (p.frozen.empty() || !p.frozen[t])) return;
    errors_.add(case_.parameters_place,
                text("parameters: no triangle is left for design variables; ",
                     p.variables_on.empty() ? "all" : "all of parameters.variables_on", " are under fixed",
                     p.frozen.empty() ? " or strains" : ", strains or parameters.frozen"));
}

std::vector<char> ProblemBuilder::marked(const std::string& key, const std::vector<Reference>& names) {
    if (names.empty()) return {};
    std::vector<char> marks(elastic().mesh.num_triangles(), 0);
    for (const Reference& name : names)
        for (const int t : region_or_patch(key, name)) marks[t] = 1;
    return marks;
}

std::vector<char> ProblemBuilder::marked_on_surface(const std::string& key, const std::vector<Reference>& names) {
    if (names.empty()) return {};
    std::vector<char> marks(start_.mesh.num_triangles(), 0);
    for (const Reference& name : names)
        for (const int t : region_or_patch_on_surface(key, name)) marks[t] = 1;
    return marks;
}

std::vector<int> ProblemBuilder::region_or_patch(const std::string& key, const Reference& reference) {
    if (!wrap_) return region_or_patch_on_surface(key, reference);
    if (region_index_.contains(reference.name)) return elastic_triangles(reference);
    try {
        const PatchPlace place = find_patch(out_.problem.tree, reference.name);
        return out_.problem.tree.levels[place.level].patches[place.id].triangles;
    } catch (const InvalidInput&) {
        return region_or_patch_on_surface(key, reference);  // says what is wrong
    }
}

std::vector<int> ProblemBuilder::region_or_patch_on_surface(const std::string& key, const Reference& reference) {
    if (const auto found = region_index_.find(reference.name); found != region_index_.end())
        return out_.regions[found->second].triangles;
    try {
        const PatchPlace place = find_patch(tree_on_surface(), reference.name);
        return tree_on_surface().levels[place.level].patches[place.id].triangles;
    } catch (const InvalidInput& e) {
        std::vector<std::string> names;
        for (const RegionTriangles& region : out_.regions) names.push_back(region.name);
        const std::string near = nearest(reference.name, names);
        errors_.add(reference.place,
                    text(key, ": '", printable(reference.name), "' is not a declared region",
                         near.empty() ? "" : text(" (did you mean '", near, "'?)"), ", and ", e.what()));
    }
    return {};
}

}  // namespace strake
