#include "optimize/space/field_conditions.hpp"

#include "core/mesh/geometry.hpp"
#include "optimize/space/mirror.hpp"

namespace strake {

FieldConditions field_conditions(const Problem& problem, const TriMesh& surface, const std::vector<char>& on) {
    const Parameters& p = problem.parameters;
    const auto m = static_cast<std::size_t>(surface.num_triangles());
    std::vector<char> held(m, 0);
    for (std::size_t t = 0; t < on.size(); ++t) held.at(t) |= on[t] == 0;
    for (const AttachedPart& part : problem.attached)
        for (const int t : part.triangles) held[static_cast<std::size_t>(t)] = 0;
    const auto hold = [&](const std::vector<int>& triangles) {
        for (const int t : triangles) held[static_cast<std::size_t>(t)] = 1;
    };
    hold(problem.fixed);
    hold(problem.still);
    if (!problem.wrap) {
        for (const PrescribedStrain& strain : problem.strains) hold(strain.triangles);
        for (const UserVariable& v : p.user_variables)
            if (v.traction.rows() == 0) hold(v.triangles);
        for (std::size_t t = 0; t < p.frozen.size(); ++t) held[t] |= p.frozen[t];
    }
    FieldConditions conditions;
    for (std::size_t t = 0; t < m; ++t)
        if (held[t]) conditions.held.push_back(static_cast<int>(t));
    conditions.cut = problem.symmetry;
    if (p.mirror && !problem.symmetry) conditions.mirror = plane_of_symmetry(surface);
    conditions.smooth_border = p.keeps_smooth_border;
    if (p.invariance) conditions.kind = p.invariance->kind();
    return conditions;
}

FieldConditions field_conditions(const Problem& problem) {
    return field_conditions(problem, problem.surface,
                            problem.wrap ? std::vector<char>{} : problem.parameters.variables_on);
}

}  // namespace strake
