#include "casefile/check/cross_check.hpp"

#include <algorithm>
#include <set>

namespace strake {
namespace {

bool names(const std::vector<Reference>& list, const std::string& name) {
    return std::any_of(list.begin(), list.end(), [&](const Reference& r) { return r.name == name; });
}

/// The key whose use of the region conflicts with the variable; empty: none.
std::string rival_of(const Case& c, const UserVariableEntry& given) {
    const std::string& region = given.region->name;
    if (names(c.fixed, region)) return "fixed";
    for (const StrainEntry& strain : c.strains)
        if (strain.region.name == region) return "strains";
    if (names(c.parameters.frozen, region)) return "parameters.frozen";
    if (!given.is_motion()) return "";
    for (const LoadEntry& load : c.loads)
        if (load.region.name == region) return "loads";
    if (names(c.parameters.variables_on, region)) return "parameters.variables_on";
    for (const UserVariableEntry& other : c.parameters.user_variables)
        if (!other.is_motion() && other.region && other.region->name == region)
            return text("parameters.given '", other.name, "' as a load");
    return "";
}

/// Nothing else has the name of the variable that a range makes.
void check_planform_name(const Case& c, const PlanformRangeEntry& entry, Diagnostics& errors) {
    const std::string variable =
        text(entry.wing, ".delta_", planform_changes()[static_cast<std::size_t>(entry.range.change)]);
    const auto clashes = [&](const std::string& other) {
        return other == variable || other.starts_with(variable + "@");
    };
    const auto refuse = [&](const char* what) {
        errors.add(entry.place, text("parameters.planform: ", what, " is called '", variable,
                                     "', as the variable of this change would be; rename it"));
    };
    const std::vector<std::string> values = known_values(c);
    if (std::any_of(values.begin(), values.end(), clashes)) refuse("a quantity");
    for (const ProgramParameterEntry& own : c.variables)
        if (clashes(own.variable.name)) refuse("one of variables");
    for (const UserVariableEntry& given : c.parameters.user_variables)
        if (clashes(given.name)) refuse("one of parameters.given");
}

void check_planform_ranges(const Case& c, Diagnostics& errors) {
    std::vector<std::string> wings;
    for (const WingEntry& wing : c.planform) wings.push_back(wing.name);
    for (const FuselageEntry& body : c.bodies) wings.push_back(body.name);
    for (const PlanformRangeEntry& entry : c.parameters.planform) {
        if (std::find(wings.begin(), wings.end(), entry.wing) == wings.end()) {
            const std::string near = nearest(entry.wing, wings);
            errors.add(entry.place,
                       text("parameters.planform: no wing or body '", printable(entry.wing),
                            "' is declared under planform", near.empty() ? "" : text("; did you mean '", near, "'?"),
                            wings.empty() ? "" : text("; declared: ", joined(wings))));
        }
        check_planform_name(c, entry, errors);
        if (!c.fit.empty()) errors.add(entry.place, "parameters.planform is not supported together with fit");
    }
}

}  // namespace

void check_user_variables(const Case& c, Diagnostics& errors) {
    check_planform_ranges(c, errors);
    std::set<std::string> seen;
    for (const UserVariableEntry& given : c.parameters.user_variables) {
        if (!seen.insert(given.name).second)
            errors.add(given.place, text("parameters.given names '", given.name, "' twice"));
        for (const ProgramParameterEntry& own : c.variables)
            if (own.variable.name == given.name)
                errors.add(given.place,
                           text("parameters.given: '", given.name, "' is already the name of one of variables"));
        const auto& kinds = c.parameters.variables;
        const bool strains = std::find(kinds.begin(), kinds.end(), VariableKind::strain) != kinds.end();
        if (given.kind == UserVariableEntry::Kind::twist && strains)
            errors.add(given.place,
                       text("parameters.given: '", given.name,
                            "' is a twist by loads, but the strains of parameters.variables pin the shell; "
                            "use load or normal there"));
        if (!given.region) continue;
        const std::string rival = rival_of(c, given);
        if (!rival.empty())
            errors.add(given.region->place, text("parameters.given: '", printable(given.region->name), "' is ",
                                                 given.is_motion() ? "moved" : "loaded", " by '", given.name,
                                                 "' and also under ", rival, "; choose one"));
    }
}

}  // namespace strake
