#include "cases/problem_builder.hpp"

namespace strake {

void ProblemBuilder::set_parameters() {
    const ParameterEntry& entry = case_.parameters;
    Parameters& p = out_.problem.parameters;
    p.kinds = entry.variables;
    p.max_displacement = entry.max_displacement.is_relative_to_diagonal
                             ? entry.max_displacement.value
                             : entry.max_displacement.value / start_.diagonal;
    if (purpose_ == Purpose::deform) return;
    if (!entry.on.empty()) p.on.assign(start_.mesh.num_triangles(), 0);
    for (const Reference& place : entry.on)
        for (const int t : region_or_patch(place)) p.on[t] = 1;
    const bool is_search = !case_.objective.name.empty() || !case_.fit.empty();
    if (!is_search || !errors_.empty()) return;
    std::vector<char> held(start_.mesh.num_triangles(), 0);
    for (const int t : out_.problem.fixed) held[t] = 1;
    for (const GivenStrain& strain : out_.problem.strains)
        for (const int t : strain.triangles) held[t] = 1;
    for (int t = 0; t < start_.mesh.num_triangles(); ++t)
        if (!held[t] && (p.on.empty() || p.on[t])) return;
    errors_.add(case_.parameters_place,
                text("parameters: no triangle is left for design variables; ",
                     entry.on.empty() ? "all" : "all of parameters.on", " are under fixed or strains"));
}

std::vector<int> ProblemBuilder::region_or_patch(const Reference& reference) {
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
                    text("parameters.on: '", printable(reference.name), "' is not a declared region",
                         near.empty() ? "" : text(" (did you mean '", near, "'?)"), ", and ", e.what()));
    }
    return {};
}

}  // namespace strake
