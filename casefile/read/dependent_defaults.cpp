#include "casefile/read/dependent_defaults.hpp"

#include "casefile/schema/scalars.hpp"
#include "optimize/run/method_choice.hpp"

#include <algorithm>
#include <cctype>
#include <cstdlib>

namespace strake {
namespace {

Value* child(Value& map, const std::string& key) {
    for (Entry& entry : map.entries)
        if (entry.key == key) return &entry.value;
    return nullptr;
}

void add_default(Value& map, const std::string& key, const std::string& yaml) {
    Entry entry{key, map.place, parse_yaml(yaml, "default of " + key)};
    entry.value.place = map.place;
    entry.value.from_default = true;
    map.entries.push_back(std::move(entry));
}

/// The map `parameters`, made where there is none; none where something else stands in its place.
Value* parameters_of(Value& root) {
    if (!child(root, "parameters")) add_default(root, "parameters", "{}");
    Value* parameters = child(root, "parameters");
    return parameters->form == Value::Form::map ? parameters : nullptr;
}

/// Without a shell other defaults hold: no variables of patches, all displacement fields.
void set_defaults_without_shell(Value& root) {
    const Value* shell = root.form == Value::Form::map ? child(root, "shell") : nullptr;
    if (!shell || shell->form != Value::Form::scalar || shell->text != "none") return;
    Value* parameters = parameters_of(root);
    if (!parameters) return;
    if (!child(*parameters, "variables")) add_default(*parameters, "variables", "[]");
    const bool has_planform = child(*parameters, "planform") != nullptr;  // what is not listed stays
    if (!child(*parameters, "fields")) add_default(*parameters, "fields", has_planform ? "none" : "auto");
}

/// Unless the case says anything of its variables, it has displacement fields in front of the patches. What a run began
/// with is stated in its own case; one of before that had none goes on so.
/// @return whether it has them by this
bool set_automatic_fields(Value& root, const std::string& fields = "auto") {
    Value* parameters = parameters_of(root);
    if (!parameters) return false;
    for (const char* stated : {"fields", "variables", "given", "planform"})
        if (child(*parameters, stated)) return false;
    add_default(*parameters, "fields", fields);
    return true;
}

/// Nothing that a shell could stand on is named: no region and no spring.
bool holds_nothing(Value& root) {
    for (const char* holds : {"hold", "fixed", "strains", "loads"})
        if (child(root, holds)) return false;
    Value* shell = child(root, "shell");
    return !shell || (shell->form == Value::Form::map && !child(*shell, "spring"));
}

/// Loads hardly taper, widen or flatten a body.
void set_defaults_of_fit(Value& root) {
    if (root.form == Value::Form::map && child(root, "fit")) set_automatic_fields(root);
}

bool is_scalar(const Value* value, std::string_view text) {
    return value && value->form == Value::Form::scalar && value->text == text;
}

bool is_of_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; }

/// The quantities whose values a formula, or the name of a value, holds. As in `Expression`, which needs the names of
/// all values and these are known only once the case has been read, the longest name counts where names contain '-'.
std::vector<std::string> quantities_in(std::string_view formula, const std::vector<std::string>& names) {
    std::vector<std::string> held;
    for (std::size_t at = 0; at < formula.size();) {
        std::string longest;
        for (const std::string& name : names) {
            const std::size_t end = at + name.size();
            if (name.size() > longest.size() && formula.substr(at).starts_with(name) &&
                (end == formula.size() || !is_of_word(formula[end])))
                longest = name;
        }
        if (!longest.empty()) held.push_back(longest);
        at += std::max<std::size_t>(longest.size(), 1);
        // The rest of a word, and the value that is named behind a quantity.
        while (at < formula.size() && (is_of_word(formula[at]) || formula[at] == '.') &&
               (is_of_word(formula[at - 1]) || formula[at - 1] == '.'))
            ++at;
    }
    return held;
}

bool share_any(const std::vector<std::string>& some, const std::vector<std::string>& others) {
    return std::ranges::any_of(some, [&](const std::string& one) { return std::ranges::count(others, one) > 0; });
}

std::vector<std::string> names_of_quantities(Value& root) {
    std::vector<std::string> names;
    if (Value* quantities = child(root, "quantities"); quantities && quantities->form == Value::Form::map)
        for (const Entry& quantity : quantities->entries) names.push_back(quantity.key);
    return names;
}

/// Programs that say that they have no gradients, and formulas of their values.
std::vector<std::string> quantities_without_gradients(Value& root) {
    std::vector<std::string> names;
    Value* quantities = child(root, "quantities");
    if (!quantities || quantities->form != Value::Form::map) return names;
    std::vector<std::pair<std::string, std::string>> formulas;
    for (Entry& quantity : quantities->entries) {
        if (quantity.value.form != Value::Form::map) continue;
        if (is_scalar(child(quantity.value, "gradients"), "false")) names.push_back(quantity.key);
        if (const Value* formula = child(quantity.value, "expression"))
            formulas.emplace_back(quantity.key, formula->text);
    }
    const std::vector<std::string> known = names_of_quantities(root);
    for (const auto& [name, formula] : formulas)  // of those above them, too
        if (share_any(quantities_in(formula, known), names)) names.push_back(name);
    return names;
}

/// For the objective or a constraint.
bool need_any_of(Value& root, const std::vector<std::string>& quantities) {
    std::vector<std::string> needed;
    if (Value* objective = child(root, "objective"); objective && objective->form == Value::Form::map)
        for (const Entry& entry : objective->entries) needed.push_back(entry.value.text);
    if (Value* constraints = child(root, "constraints"); constraints && constraints->form == Value::Form::map)
        for (const Entry& entry : constraints->entries) needed.push_back(entry.key);
    const std::vector<std::string> known = names_of_quantities(root);
    return std::ranges::any_of(
        needed, [&](const std::string& value) { return share_any(quantities_in(value, known), quantities); });
}

bool is_more_than(Value* budget, double limit) {
    const Value* evaluations = budget && budget->form == Value::Form::map ? child(*budget, "evaluations") : nullptr;
    return evaluations && evaluations->form == Value::Form::scalar &&
           std::strtod(evaluations->text.c_str(), nullptr) > limit;
}

/// With a cheap model the search is by sqp.
bool has_cheap_model(Value& root) {
    const auto is_stated = [](Entry& quantity) {
        return quantity.value.form == Value::Form::map && child(quantity.value, "low_fidelity");
    };
    return std::ranges::any_of(child(root, "quantities")->entries, is_stated);
}

/// Nor does a run by values alone that says nothing of its variables nor of its method, and that models search: few
/// evaluations are best spent on smooth motions of the whole, and those along the surface are fields' work: patches
/// move by what changes the shape. One that holds nothing is held by a point.
void set_defaults_by_values(Value& root) {
    if (root.form != Value::Form::map || child(root, "fit")) return;
    const std::vector<std::string> blind = quantities_without_gradients(root);
    if (blind.empty() || has_cheap_model(root) || !need_any_of(root, blind)) return;
    if (Value* optimize = child(root, "optimize"); optimize && optimize->form == Value::Form::map) {
        Value* method = child(*optimize, "method");
        const std::string word = method ? algorithm_word(method->text) : "auto";
        if (word != "auto" && word != "model") return;
        for (const char* stated : {"finite_differences", "start_from"})
            if (child(*optimize, stated)) return;
        if (is_more_than(child(*optimize, "budget"), max_evaluations_by_models)) return;
    }
    if (!set_automatic_fields(root)) return;
    Value& parameters = *parameters_of(root);
    if (!child(parameters, "directions")) add_default(parameters, "variables", "[normal]");  // which are those of loads
    if (holds_nothing(root)) add_default(root, "hold", "point");
}

/// What a search by gradients may state and still say nothing of its variables, patches among them.
bool states_limits_alone(Value& root) {
    const Value* parameters = child(root, "parameters");
    if (!parameters) return true;
    const auto is_limit = [](const Entry& entry) {
        return entry.key == "max_displacement" || entry.key == "mirror" || entry.key == "keep";
    };
    return parameters->form == Value::Form::map && std::ranges::all_of(parameters->entries, is_limit);
}

/// A search by gradients begins with displacement fields where the case says nothing of variables nor of patches. Where
/// nothing is constrained it leaves to the gradient what becomes finer: under constraints a gradient promises what no
/// allowed step has, and a run ends higher where each level first does what it can.
void set_defaults_by_gradients(Value& root) {
    if (root.form != Value::Form::map || child(root, "fit") || !child(root, "objective") || child(root, "sample"))
        return;
    if (is_scalar(child(root, "hold"), "none")) return;  // which loads on patches cannot be beside
    if (!states_limits_alone(root) || need_any_of(root, quantities_without_gradients(root))) return;
    if (Value* optimize = child(root, "optimize"); optimize && optimize->form == Value::Form::map) {
        const Value* method = child(*optimize, "method");
        const std::string word = method ? algorithm_word(method->text) : "auto";
        if ((word != "auto" && word != "sqp") || child(*optimize, "start_from")) return;
    }
    const Value* constraints = child(root, "constraints");
    const bool is_free = !constraints || constraints->entries.empty();
    if (set_automatic_fields(root) && is_free) add_default(*parameters_of(root), "split", "sensitivity");
}

const Value* fields_of(Value& root) {
    Value* parameters = root.form == Value::Form::map ? child(root, "parameters") : nullptr;
    const Value* fields = parameters && parameters->form == Value::Form::map ? child(*parameters, "fields") : nullptr;
    return fields && fields->form == Value::Form::scalar ? fields : nullptr;
}

/// Unless the case says anything of its variables, it has the fields of a run, and of its patches the rule of splits
/// and the kind that a case has by default; releases and budgets differ in them. Other kinds were stated.
/// @param there the case of the run @return whether it has them by this
bool set_variables_of(Value& root, Value& there) {
    const Value* fields = fields_of(there);
    if (!fields || !set_automatic_fields(root, fields->text)) return false;
    const Value* kinds = child(*child(there, "parameters"), "variables");
    Value& parameters = *parameters_of(root);
    const Value* split = child(*child(there, "parameters"), "split");
    if (split && split->form == Value::Form::scalar && !child(parameters, "split"))
        add_default(parameters, "split", split->text);
    const bool are_normal = kinds && kinds->form == Value::Form::list && kinds->entries.size() == 1 &&
                            is_scalar(&kinds->entries[0].value, "normal");
    if (are_normal && !child(parameters, "directions")) add_default(parameters, "variables", "[normal]");
    return true;
}

/// A run that begins at a design of displacement fields has them, too, if it says nothing of its variables: without
/// them that shape could not be kept. Where the folder's case cannot be read, the design itself is refused.
void set_fields_of_start(Value& root, const std::filesystem::path& dir) {
    Value* optimize = root.form == Value::Form::map ? child(root, "optimize") : nullptr;
    const Value* folder = optimize && optimize->form == Value::Form::map ? child(*optimize, "start_from") : nullptr;
    if (!folder || folder->form != Value::Form::scalar) return;
    const std::filesystem::path file = dir / folder->text / "case.yaml";
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(file, ignored)) return;
    try {
        Value there = parse_yaml(read_case_file(file.string()), file.string());
        const Value* fields = fields_of(there);
        if (fields && fields->text != "none") set_variables_of(root, there);
    } catch (const CaseError&) {
    }
}

}  // namespace

void set_dependent_defaults(Value& root, const std::filesystem::path& dir, bool is_new) {
    set_defaults_without_shell(root);
    if (!is_new) return;
    set_defaults_of_fit(root);
    set_defaults_by_values(root);
    set_defaults_by_gradients(root);
    set_fields_of_start(root, dir);
}

void set_fields_of_run(Value& root, const std::string& begun) {
    Value there = parse_yaml(begun, "case.yaml");
    const Value* hold = there.form == Value::Form::map ? child(there, "hold") : nullptr;
    if (!set_variables_of(root, there)) return;
    if (is_scalar(hold, "point") && holds_nothing(root)) add_default(root, "hold", "point");
}

}  // namespace strake
