#include "casefile/build/problem_builder.hpp"
#include "core/fields/displacement_fields.hpp"
#include "optimize/space/mirror.hpp"

namespace strake {
namespace {

/// Sections moved, turned, scaled and sheared up to degree two along the axis; then to higher ones.
constexpr std::array automatic_steps{27, 60, 192};

}  // namespace

/// Per triangle: held by anything, or not to be moved by the fields.
std::vector<char> ProblemBuilder::held_by_fields() {
    const FieldsEntry& entry = case_.parameters.fields;
    const Problem& problem = out_.problem;
    const Parameters& p = problem.parameters;
    std::vector<char> held(static_cast<std::size_t>(start_.mesh.num_triangles()), 0);
    const auto hold = [&](const std::vector<int>& triangles) {
        for (const int t : triangles) held[static_cast<std::size_t>(t)] = 1;
    };
    const auto hold_marked = [&](const std::vector<char>& marks, bool what) {
        for (std::size_t t = 0; t < marks.size(); ++t) held[t] |= (marks[t] != 0) == what;
    };
    hold(problem.fixed);
    for (const PrescribedStrain& strain : problem.strains) hold(strain.triangles);
    for (const UserVariable& v : p.user_variables)
        if (v.traction.rows() == 0) hold(v.triangles);
    hold_marked(p.frozen, true);
    if (entry.on)
        hold_marked(marked("parameters.fields.on", {*entry.on}), false);
    else
        hold_marked(p.variables_on, false);
    return held;
}

void ProblemBuilder::set_fields() {
    const FieldsEntry& entry = case_.parameters.fields;
    Parameters& p = out_.problem.parameters;
    if (!out_.problem.attached.empty()) {
        errors_.add(entry.place,
                    "parameters.fields move everything alike and cannot be combined with attach; remove one of them");
        return;
    }
    const std::vector<char> held = held_by_fields();
    if (!errors_.empty()) return;
    FieldConditions conditions;
    for (int t = 0; t < start_.mesh.num_triangles(); ++t)
        if (held[static_cast<std::size_t>(t)]) conditions.held.push_back(t);
    conditions.cut = case_.symmetry;
    if (p.mirror && !case_.symmetry) conditions.mirror = plane_of_symmetry(start_.mesh);
    FieldOptions options;
    options.number = entry.number > 0 ? entry.number : automatic_steps.back();
    options.axis = entry.axis;
    at(entry.place, "parameters.fields: ", [&] {
        const auto fields = std::make_shared<const DisplacementFields>(start_.mesh, conditions, options);
        if (entry.number == 0)
            for (const int step : automatic_steps)
                if (p.field_steps.empty() || p.field_steps.back() < fields->size())
                    p.field_steps.push_back(std::min(step, fields->size()));
        add_fields(p, fields);
    });
}

}  // namespace strake
