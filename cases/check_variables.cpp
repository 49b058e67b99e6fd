#include "cases/case_source.hpp"

#include <algorithm>
#include <array>
#include <set>

namespace strake {
namespace {

bool is_own_variable(const Case& c, const std::string& name) {
    return std::any_of(c.variables.begin(), c.variables.end(), [&](const auto& v) { return v.variable.name == name; });
}

constexpr const char* taken_by_history = ": this is a column of history.csv; choose another name";

bool is_column(const std::string& name) {
    constexpr std::array<const char*, 6> columns{"evaluation", "level",         "status",
                                                 "objective",  "max_violation", "accepted"};
    return std::find(columns.begin(), columns.end(), name) != columns.end();
}

bool is_angle(const Case& c, const std::string& name) {
    return std::any_of(c.variables.begin(), c.variables.end(),
                       [&](const auto& v) { return v.variable.name == name && v.variable.is_angle; });
}

}  // namespace

/// Nobody reads a variable in vain, and no name means two things in a history.
void check_own_variables(const Value& root, const Case& c, Diagnostics& errors) {
    const std::vector<std::string> values = known_values(c);
    for (const QuantityEntry& quantity : c.quantities)
        if (is_column(quantity.name)) errors.add(quantity.place, text("quantities.", quantity.name, taken_by_history));
    for (const OwnVariableEntry& entry : c.variables)
        if (is_column(entry.variable.name))
            errors.add(entry.place, text("variables.", entry.variable.name, taken_by_history));
    std::vector<std::string> names;
    for (const OwnVariableEntry& entry : c.variables) names.push_back(entry.variable.name);
    std::set<std::string> taken;
    for (const QuantityEntry& quantity : c.quantities) {
        const auto* external = std::get_if<ExternalEntry>(&quantity.what);
        const auto* made = std::get_if<MadeQuantity>(&quantity.what);
        if (external && !external->depends_on) taken.insert(names.begin(), names.end());
        if (const auto* formula = std::get_if<FormulaEntry>(&quantity.what))
            taken.insert(formula->of.begin(), formula->of.end());
        const std::vector<Reference> none;
        for (const Reference& name : external ? external->depends_on.value_or(none) : made ? made->variables : none) {
            taken.insert(name.name);
            if (is_own_variable(c, name.name)) {
                if (made && !is_angle(c, name.name))
                    errors.add(name.place, text("variable '", name.name, "' is a number, and quantities.",
                                                printable(quantity.name), " takes it for an angle; write it as one: ",
                                                "{start: 3deg, min: 0deg, max: 6deg}"));
                continue;
            }
            const std::string near = nearest(name.name, names);
            errors.add(name.place,
                       text("variable '", name.name, "' is not declared",
                            near.empty() ? "" : text("; did you mean '", near, "'?"),
                            names.empty() ? "; the case has no variables" : text("; variables: ", joined(names))));
        }
    }
    for (const OwnVariableEntry& entry : c.variables) {
        const std::string& name = entry.variable.name;
        if (std::find(values.begin(), values.end(), name) != values.end())
            errors.add(entry.place, text("variables.", name, ": a quantity is called the same"));
        else if (!c.objective.name.empty() && !taken.count(name))
            errors.add(entry.place,
                       text("variables.", name,
                            ": no quantity depends on it; programs (command), formulas and angles of quantities can"));
    }
    for (const Entry& own : root.entries)
        if (own.key == "variables" && !c.fit.empty())
            errors.add(own.key_place, "variables are not supported together with fit, which moves the shape alone");
    const Value* parameters = root.find("parameters");
    const Value* shape = parameters ? parameters->find("variables") : nullptr;
    const bool any = !c.parameters.given.empty() || (!c.variables.empty() && c.fit.empty());
    if (shape && shape->entries.empty() && !any)
        errors.add(shape->place,
                   "parameters.variables is empty: there is nothing to change (a case with parameters.given or with "
                   "variables beside the shape may do without)");
}

}  // namespace strake
