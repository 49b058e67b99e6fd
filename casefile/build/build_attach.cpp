#include "casefile/build/problem_builder.hpp"

#include <algorithm>
#include <charconv>

/// `attach`: from names to triangles, and the conflicts of attached parts with other keys.
namespace strake {
namespace {

std::vector<std::string> part_names(const TriMesh& mesh) {
    std::vector<std::string> names;
    for (const std::string& name : mesh.group_names)
        if (!mesh.group.empty() && std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    return names;
}

std::string listed(const char* what, const std::vector<std::string>& names) {
    constexpr std::size_t max_names = 20;
    if (names.empty()) return "";
    std::vector<std::string> shown;
    for (std::size_t k = 0; k < names.size() && k < max_names; ++k) shown.push_back(printable(names[k], 40));
    return text("; ", what, ": ", joined(shown), names.size() > max_names ? text(", ... (", names.size(), ")") : "");
}

}  // namespace

/// A region of that name, else a part named in the file, else the component of that number.
std::vector<int> ProblemBuilder::part_triangles(const Reference& reference) {
    if (const auto found = region_index_.find(reference.name); found != region_index_.end())
        return out_.regions[found->second].triangles;
    const TriMesh& mesh = start_.mesh;
    std::vector<int> found;
    if (!mesh.group.empty())
        for (int t = 0; t < mesh.num_triangles(); ++t)
            if (mesh.group_names[mesh.group[t]] == reference.name) found.push_back(t);
    if (!found.empty()) return found;
    const std::vector<int> component = edge_components(mesh, start_.adjacent);
    const int last = *std::max_element(component.begin(), component.end());
    int number = -1;
    const char* end = reference.name.data() + reference.name.size();
    if (std::from_chars(reference.name.data(), end, number).ptr != end) number = -1;
    for (int t = 0; t < mesh.num_triangles(); ++t)
        if (component[t] == number) found.push_back(t);
    if (!found.empty()) return found;
    std::vector<std::string> regions;
    for (const RegionTriangles& region : out_.regions) regions.push_back(region.name);
    std::vector<std::string> known = regions, parts = part_names(mesh);
    known.insert(known.end(), parts.begin(), parts.end());
    const std::string near = nearest(reference.name, known);
    errors_.add(reference.place,
                text("attach: there is no part '", printable(reference.name), "'",
                     near.empty() ? "" : text("; did you mean '", printable(near), "'?"), listed("regions", regions),
                     listed("parts of the surface file", parts), "; connected components: 0 to ", last));
    return {};
}

void ProblemBuilder::set_attached() {
    if (case_.attach.empty()) return;
    std::vector<const char*> rival(start_.mesh.num_triangles(), nullptr);
    for (const int t : out_.problem.fixed) rival[t] = "fixed";
    for (const PrescribedStrain& strain : out_.problem.strains)
        for (const int t : strain.triangles) rival[t] = "strains";
    std::vector<int> entry_of(start_.mesh.num_triangles(), -1);
    for (int e = 0; e < static_cast<int>(case_.attach.size()); ++e) {
        const AttachEntry& entry = case_.attach[e];
        AttachedPart part{printable(entry.part.name), part_triangles(entry.part), part_triangles(entry.to), entry.how};
        if (part.triangles.empty() || part.host.empty()) continue;
        const auto held = std::find_if(part.triangles.begin(), part.triangles.end(), [&](int t) { return rival[t]; });
        if (held != part.triangles.end())
            errors_.add(entry.part.place, text("attach: triangle ", *held, " of '", part.name, "' is also under ",
                                               rival[*held], "; an attached part moves with its host only"));
        const auto taken =
            std::find_if(part.triangles.begin(), part.triangles.end(), [&](int t) { return entry_of[t] >= 0; });
        if (taken != part.triangles.end())
            errors_.add(entry.part.place,
                        text("attach: '", part.name, "' is already attached at ",
                             line_words(case_.attach[entry_of[*taken]].part.place), " (triangle ", *taken, " of '",
                             printable(case_.attach[entry_of[*taken]].part.name), "'); a part has only one host"));
        for (const int t : part.triangles) entry_of[t] = e;
        const auto own = std::count_if(part.host.begin(), part.host.end(), [&](int t) { return entry_of[t] == e; });
        if (own > 0)
            errors_.add(entry.to.place, text("attach: part '", part.name, "' is attached to itself (", own,
                                             " of its triangles also belong to its host)"));
        out_.problem.attached.push_back(std::move(part));
    }
    if (!errors_.empty()) return;
    at(case_.attach[0].part.place, "",
       [&] { const Attachments made(start_.mesh, out_.problem.attached, case_.symmetry); });
    check_loaded();
}

/// Loads act on the shell, which attached parts do not belong to.
void ProblemBuilder::check_loaded() {
    std::vector<char> is_attached(start_.mesh.num_triangles(), 0);
    for (const AttachedPart& part : out_.problem.attached)
        for (const int t : part.triangles) is_attached[t] = 1;
    const auto check = [&](const std::string& key, const Reference& region) {
        const std::vector<int>& all = triangles(region);
        const auto count = std::count_if(all.begin(), all.end(), [&](int t) { return is_attached[t]; });
        const std::string shown = text(key, ": ", count, " of ", all.size(), " triangles of region '", region.name,
                                       "' belong to attached parts");
        if (count == static_cast<long>(all.size()))
            errors_.add(region.place, shown + " and take no load; load the host");
        else if (count > 0)
            out_.warnings.push_back(shown + " and take no load");
    };
    for (const LoadEntry& load : case_.loads) check("loads", load.region);
    for (const UserVariableEntry& given : case_.parameters.user_variables)
        if (given.region && region_index_.contains(given.region->name)) check("parameters.given", *given.region);
}

}  // namespace strake
