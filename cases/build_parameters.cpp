#include "cases/problem_builder.hpp"
#include "optimize/mirror.hpp"

namespace strake {

void ProblemBuilder::set_parameters() {
    const ParameterEntry& entry = case_.parameters;
    Parameters& p = out_.problem.parameters;
    p.kinds = entry.variables;
    p.strain_rotates = entry.strain_rotates;
    p.strain_translates = entry.strain_translates;
    p.load_directions = entry.directions;
    p.core = entry.core;
    p.max_displacement = entry.max_displacement.is_relative_to_diagonal
                             ? entry.max_displacement.value
                             : entry.max_displacement.value / start_.diagonal;
    if (entry.split.kind == SplitEntry::Kind::sensitivity) p.split = SplitRule::sensitivity;
    if (entry.split.kind == SplitEntry::Kind::gradient) p.split = SplitRule::gradient;
    p.split_share = entry.split_share;
    p.growth = entry.growth;
    p.mirror = entry.mirror;
    if (purpose_ == Purpose::deform) return;
    p.on = marked("parameters.on", entry.on);
    if (!out_.problem.attached.empty()) {  // variables have nothing to move there
        if (p.on.empty()) p.on.assign(start_.mesh.num_triangles(), 1);
        for (const AttachedPart& part : out_.problem.attached)
            for (const int t : part.triangles) p.on[t] = 0;
    }
    p.frozen = marked("parameters.freeze", entry.freeze);
    for (const std::vector<Reference>& group : entry.groups) p.groups.push_back(marked("parameters.groups", group));
    set_given();
    const bool is_search = !case_.objective.name.empty() || !case_.fit.empty();
    if (is_search && p.mirror && !plane_of_symmetry(start_.mesh))
        errors_.add(entry.mirror_place,
                    "parameters.mirror: the surface has no plane of symmetry (to 1e-3 of the diagonal)");
    if (is_search && errors_.empty() && !p.kinds.empty()) check_freedom();
}

void ProblemBuilder::check_freedom() {
    const Parameters& p = out_.problem.parameters;
    if (!p.given.empty() || !twists_.empty()) return;
    std::vector<char> held(start_.mesh.num_triangles(), 0);
    for (const int t : out_.problem.fixed) held[t] = 1;
    for (const GivenStrain& strain : out_.problem.strains)
        for (const int t : strain.triangles) held[t] = 1;
    for (int t = 0; t < start_.mesh.num_triangles(); ++t)
        if (!held[t] && (p.on.empty() || p.on[t]) && (p.frozen.empty() || !p.frozen[t])) return;
    errors_.add(case_.parameters_place, text("parameters: no triangle is left for design variables; ",
                                             p.on.empty() ? "all" : "all of parameters.on", " are under fixed",
                                             p.frozen.empty() ? " or strains" : ", strains or parameters.freeze"));
}

std::vector<char> ProblemBuilder::marked(const std::string& key, const std::vector<Reference>& names) {
    if (names.empty()) return {};
    std::vector<char> marks(start_.mesh.num_triangles(), 0);
    for (const Reference& name : names)
        for (const int t : region_or_patch(key, name)) marks[t] = 1;
    return marks;
}

std::vector<int> ProblemBuilder::region_or_patch(const std::string& key, const Reference& reference) {
    if (const auto found = region_index_.find(reference.name); found != region_index_.end())
        return out_.regions[found->second].triangles;
    try {
        const PatchPlace place = find_patch(out_.problem.tree, reference.name);
        return out_.problem.tree.levels[place.level].patches[place.id].triangles;
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
