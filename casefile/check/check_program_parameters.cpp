#include "casefile/check/cross_check.hpp"
#include "optimize/run/history.hpp"

#include <algorithm>
#include <set>

namespace strake {
namespace {

using Names = std::vector<std::string>;

bool holds(const Names& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
}

constexpr const char* taken_by_history = ": this is a column of history.csv; choose another name";

bool is_angle(const Case& c, const std::string& name) {
    return std::any_of(c.variables.begin(), c.variables.end(),
                       [&](const auto& v) { return v.variable.name == name && v.variable.is_angle; });
}

/// No name means two things in a history.
void check_columns(const Case& c, Diagnostics& errors) {
    for (const QuantityEntry& quantity : c.quantities)
        if (is_history_column(quantity.name))
            errors.add(quantity.place, text("quantities.", quantity.name, taken_by_history));
    for (const ProgramParameterEntry& entry : c.variables)
        if (is_history_column(entry.variable.name))
            errors.add(entry.place, text("variables.", entry.variable.name, taken_by_history));
}

/// A parameter that a quantity names: it exists, and an angle is one.
void check_reference(const Case& c, const QuantityEntry& quantity, const Reference& name, const Names& declared,
                     Diagnostics& errors) {
    if (holds(declared, name.name)) {
        if (std::holds_alternative<BuiltInEntry>(quantity.what) && !is_angle(c, name.name))
            errors.add(name.place,
                       text("variable '", name.name, "' is a number, but quantities.", printable(quantity.name),
                            " needs an angle; write it as one: ", "{start: 3deg, min: 0deg, max: 6deg}"));
        return;
    }
    const std::string near = nearest(name.name, declared);
    errors.add(
        name.place,
        text("variable '", name.name, "' is not declared", near.empty() ? "" : text("; did you mean '", near, "'?"),
             declared.empty() ? "; the case has no variables" : text("; variables: ", joined(declared))));
}

/// The parameters that some quantity depends on.
std::set<std::string> used_parameters(const Case& c, const Names& declared, Diagnostics& errors) {
    std::set<std::string> used;
    for (const QuantityEntry& quantity : c.quantities) {
        const auto* external = std::get_if<ExternalEntry>(&quantity.what);
        const auto* built_in = std::get_if<BuiltInEntry>(&quantity.what);
        if (external && !external->depends_on) used.insert(declared.begin(), declared.end());
        if (const auto* formula = std::get_if<FormulaEntry>(&quantity.what))
            used.insert(formula->of.begin(), formula->of.end());
        std::vector<Reference> named;
        if (external) named = external->depends_on.value_or(named);
        if (built_in) named = built_in->variables;
        for (const Reference& name : named) {
            used.insert(name.name);
            check_reference(c, quantity, name, declared, errors);
        }
    }
    return used;
}

void check_anything_changes(const Value& root, const Case& c, Diagnostics& errors) {
    const Value* parameters = root.find("parameters");
    const Value* shape = parameters ? parameters->find("variables") : nullptr;
    const bool any = !c.parameters.user_variables.empty() || c.parameters.fields.is_wanted ||
                     !c.parameters.planform.empty() || (!c.variables.empty() && c.fit.empty());
    if (shape && shape->entries.empty() && !any)
        errors.add(
            shape->place,
            "parameters.variables is empty: nothing can change (it may be empty if the case has parameters.fields, "
            "parameters.planform, parameters.given or variables)");
}

}  // namespace

void check_program_parameters(const Value& root, const Case& c, Diagnostics& errors) {
    check_columns(c, errors);
    Names declared;
    for (const ProgramParameterEntry& entry : c.variables) declared.push_back(entry.variable.name);
    const std::set<std::string> used = used_parameters(c, declared, errors);
    const Names values = known_values(c);
    for (const ProgramParameterEntry& entry : c.variables) {
        const std::string& name = entry.variable.name;
        if (holds(values, name))
            errors.add(entry.place, text("variables.", name, ": a quantity has the same name"));
        else if (!c.objective.name.empty() && !used.count(name))
            errors.add(entry.place, text("variables.", name,
                                         ": no quantity depends on it; programs (command), formulas and angles of "
                                         "quantities can"));
    }
    for (const Entry& entry : root.entries)
        if (entry.key == "variables" && !c.fit.empty())
            errors.add(entry.key_place, "variables are not supported together with fit, which moves the shape alone");
    check_anything_changes(root, c, errors);
}

}  // namespace strake
