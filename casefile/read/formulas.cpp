#include "casefile/read/read_case.hpp"
#include "objectives/formula/expression.hpp"

#include <algorithm>

/// Formulas of other values: `quantities.NAME.expression`, and of objectives that are not a single value.
namespace strake {
namespace {

constexpr const char* name_of_goal = "goal";

/// The objective's formula becomes a quantity, to be logged like the others.
void take_objective(Case& c, Diagnostics& errors) {
    const std::string& written = c.objective.name;
    const std::vector<std::string> known = known_values(c);
    if (std::find(known.begin(), known.end(), written) != known.end()) return;
    if (written.find_first_of("+-*/^() \t\n,") == std::string::npos) return;
    if (std::find(known.begin(), known.end(), name_of_goal) != known.end()) {
        errors.add(c.objective.place, text("the value of the formula is named '", name_of_goal,
                                           "', like a quantity; rename the quantity"));
        return;
    }
    c.quantities.push_back({name_of_goal, c.objective.place, FormulaEntry{{written, c.objective.place}, {}, {}}});
    c.objective.name = name_of_goal;
}

/// A formula may use the formulas above it and all other quantities, which come first.
void parse(Case& c, QuantityEntry& entry, FormulaEntry& formula, const std::vector<std::string>& known,
           Diagnostics& errors) {
    std::vector<std::string> names = known;
    for (const ProgramParameterEntry& own : c.variables) names.push_back(own.variable.name);
    try {
        const Expression expression(formula.text.name, names);
        formula.of = expression.names();
        const auto is_value = [&](const std::string& name) {
            return std::find(known.begin(), known.end(), name) != known.end();
        };
        if (std::none_of(formula.of.begin(), formula.of.end(), is_value))
            errors.add(formula.text.place, "a formula must contain at least one value of a quantity");
        formula.value = [expression](const Eigen::VectorXd& at, Eigen::VectorXd* gradient) {
            return expression.value(at, gradient);
        };
    } catch (const InvalidInput& error) {
        const std::string shown = entry.name == name_of_goal ? "" : text("quantities.", printable(entry.name), ": ");
        errors.add(formula.text.place, shown + error.what());
    }
}

}  // namespace

void set_formulas(Case& c, Diagnostics& errors) {
    take_objective(c, errors);
    const auto is_formula = [](const QuantityEntry& q) { return std::holds_alternative<FormulaEntry>(q.what); };
    std::stable_partition(c.quantities.begin(), c.quantities.end(), [&](auto& q) { return !is_formula(q); });
    // Formulas may also use the built-in ones without an entry.
    std::vector<std::string> known;
    for (const QuantityEntry& quantity : c.quantities)
        if (!is_formula(quantity))
            for (const std::string& name : quantity.value_names()) known.push_back(name);
    const auto is_taken = [&](const char* name) {
        return std::any_of(c.quantities.begin(), c.quantities.end(), [&](const auto& q) { return q.name == name; });
    };
    for (const char* built_in : {"volume", "area"})
        if (!is_taken(built_in)) known.push_back(built_in);
    for (QuantityEntry& quantity : c.quantities) {
        auto* formula = std::get_if<FormulaEntry>(&quantity.what);
        if (!formula) continue;
        parse(c, quantity, *formula, known, errors);
        known.push_back(quantity.name);
    }
}

}  // namespace strake
