#include "cases/case_source.hpp"

#include <algorithm>
#include <set>

namespace strake {
namespace {

bool names(const std::vector<Reference>& list, const std::string& name) {
    return std::any_of(list.begin(), list.end(), [&](const Reference& r) { return r.name == name; });
}

/// The key under which the region is asked for something that the variable excludes; empty: none.
std::string rival_of(const Case& c, const GivenEntry& given) {
    const std::string& region = given.region->name;
    if (names(c.fixed, region)) return "fixed";
    for (const StrainEntry& strain : c.strains)
        if (strain.region.name == region) return "strains";
    if (names(c.parameters.freeze, region)) return "parameters.freeze";
    if (!given.is_motion()) return "";
    for (const LoadEntry& load : c.loads)
        if (load.region.name == region) return "loads";
    if (names(c.parameters.on, region)) return "parameters.on";
    for (const GivenEntry& other : c.parameters.given)
        if (!other.is_motion() && other.region && other.region->name == region)
            return text("parameters.given '", other.name, "' as a load");
    return "";
}

}  // namespace

void check_given(const Case& c, Diagnostics& errors) {
    std::set<std::string> seen;
    for (const GivenEntry& given : c.parameters.given) {
        if (!seen.insert(given.name).second)
            errors.add(given.place, text("parameters.given names '", given.name, "' twice"));
        for (const OwnVariableEntry& own : c.variables)
            if (own.variable.name == given.name)
                errors.add(given.place,
                           text("parameters.given: '", given.name, "' is the name of one of variables already"));
        const auto& kinds = c.parameters.variables;
        const bool strains = std::find(kinds.begin(), kinds.end(), VariableKind::strain) != kinds.end();
        if (given.kind == GivenEntry::Kind::twist && strains)
            errors.add(given.place, text("parameters.given: '", given.name,
                                         "' twists by loads, but the strains of parameters.variables pin the skin; "
                                         "use load or load_normal there"));
        if (!given.region) continue;
        const std::string rival = rival_of(c, given);
        if (!rival.empty())
            errors.add(given.region->place, text("parameters.given: '", printable(given.region->name), "' is ",
                                                 given.is_motion() ? "moved" : "loaded", " by '", given.name,
                                                 "' and also under ", rival, "; it can only be one"));
    }
}

}  // namespace strake
