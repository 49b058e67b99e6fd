#include "casefile/load_case.hpp"

#include <algorithm>
#include <cctype>
#include <cstdlib>

#include "casefile/check/cross_check.hpp"
#include "casefile/read/read_case.hpp"
#include "casefile/read/settings.hpp"
#include "casefile/schema/renamed.hpp"
#include "casefile/schema/scalars.hpp"
#include "casefile/schema/schema.hpp"
#include "core/formats/io.hpp"
#include "core/text/shell_word.hpp"

namespace strake {
namespace {

/// Built-in quantities that are used without an entry get one.
void add_built_in(Case& c) {
    const auto used = [&](const std::string& name) {
        const auto holds = [&](const QuantityEntry& quantity) {
            const auto* formula = std::get_if<FormulaEntry>(&quantity.what);
            if (const auto* program = std::get_if<ExternalEntry>(&quantity.what))
                for (const auto& [output, low] : program->low_fidelity)
                    if (low.name == name) return true;
            return formula && std::find(formula->of.begin(), formula->of.end(), name) != formula->of.end();
        };
        return c.objective.name == name || std::any_of(c.quantities.begin(), c.quantities.end(), holds) ||
               std::any_of(c.constraints.begin(), c.constraints.end(),
                           [&](const auto& entry) { return entry.constraint.quantity == name; });
    };
    const auto declared = [&](const std::string& name) {
        return std::any_of(c.quantities.begin(), c.quantities.end(), [&](const auto& q) { return q.name == name; });
    };
    const auto place = [&](const std::string& name) {
        for (const ConstraintEntry& entry : c.constraints)
            if (entry.constraint.quantity == name) return entry.place;
        return c.objective.place;
    };
    // Before the formulas, which may hold them.
    const auto add = [&](const std::string& name, auto entry) {
        if (!used(name) || declared(name)) return;
        const auto formula = std::find_if(c.quantities.begin(), c.quantities.end(), [](const QuantityEntry& quantity) {
            return std::holds_alternative<FormulaEntry>(quantity.what);
        });
        c.quantities.insert(formula, {name, place(name), entry});
    };
    add("volume", VolumeEntry{});
    add("area", AreaEntry{});
}

/// A case without a name is named after its file.
void name_after_file(Value& root, const std::filesystem::path& file) {
    const auto is_name = [](const Entry& entry) { return entry.key == "case"; };
    if (root.form != Value::Form::map || std::any_of(root.entries.begin(), root.entries.end(), is_name)) return;
    std::string name = file.stem().string().substr(0, 100);
    const auto is_legal = [](char c) {
        return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '-';
    };
    for (char& c : name)
        if (!is_legal(c)) c = '_';
    Entry entry{"case", root.place, {}};
    entry.value.text = name;
    entry.value.place = root.place;
    entry.value.from_default = true;
    root.entries.insert(root.entries.begin(), std::move(entry));
}

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
void set_automatic_fields(Value& root, const std::string& fields = "auto") {
    Value* parameters = parameters_of(root);
    if (!parameters) return;
    for (const char* stated : {"fields", "variables", "given", "planform"})
        if (child(*parameters, stated)) return;
    add_default(*parameters, "fields", fields);
}

/// Loads hardly taper, widen or flatten a body.
void set_defaults_of_fit(Value& root) {
    if (root.form == Value::Form::map && child(root, "fit")) set_automatic_fields(root);
}

bool is_scalar(const Value* value, std::string_view text) {
    return value && value->form == Value::Form::scalar && value->text == text;
}

bool is_of_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; }

/// The quantities whose values a formula, or the name of a value, holds. As in formulas, the longest name counts where
/// names contain '-'.
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

/// More evaluations than this without a gradient: not measured against patches.
constexpr double most_evaluations_by_fields = 200;

bool is_more_than(Value* budget, double most) {
    const Value* evaluations = budget && budget->form == Value::Form::map ? child(*budget, "evaluations") : nullptr;
    return evaluations && evaluations->form == Value::Form::scalar &&
           std::strtod(evaluations->text.c_str(), nullptr) > most;
}

/// With a cheap model the search is by sqp.
bool has_cheap_model(Value& root) {
    const auto is_stated = [](Entry& quantity) {
        return quantity.value.form == Value::Form::map && child(quantity.value, "low_fidelity");
    };
    return std::ranges::any_of(child(root, "quantities")->entries, is_stated);
}

/// Nor does a short run by values alone that says nothing of its variables nor of its method: few evaluations are best
/// spent on smooth motions of the whole.
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
        if (is_more_than(child(*optimize, "budget"), most_evaluations_by_fields)) return;
    }
    set_automatic_fields(root);
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
        Value* parameters = there.form == Value::Form::map ? child(there, "parameters") : nullptr;
        const Value* fields =
            parameters && parameters->form == Value::Form::map ? child(*parameters, "fields") : nullptr;
        if (fields && fields->form == Value::Form::scalar && fields->text != "none")
            set_automatic_fields(root, fields->text);
    } catch (const CaseError&) {
    }
}

/// Of a run that has begun: its own fields, or that it has none.
void set_fields_of_run(Value& root, const std::string& begun) {
    Value there = parse_yaml(begun, "case.yaml");
    Value* parameters = there.form == Value::Form::map ? child(there, "parameters") : nullptr;
    const Value* fields = parameters && parameters->form == Value::Form::map ? child(*parameters, "fields") : nullptr;
    if (fields && fields->form == Value::Form::scalar) set_automatic_fields(root, fields->text);
}

/// @param command_dir see Case::command_dir; not empty: the case of a run that continues.
/// @param begun the case that a run began with; empty: none has
Case loaded(const std::string& bytes, const std::filesystem::path& file, Purpose purpose,
            const std::filesystem::path& command_dir, const std::vector<std::string>& settings,
            const std::string& begun = {}) {
    auto source = std::make_shared<Case::Source>();
    source->root = parse_yaml(bytes, file.string());
    source->lines = split_lines(bytes);
    source->settings = settings;
    Diagnostics errors(file.string(), source->lines, settings);
    Case the_case;
    the_case.file = file;
    the_case.command_dir = command_dir;
    if (!settings.empty()) {
        rename_old(source->root, errors);  // a setting of the present name replaces the old one
        apply_settings(source->root, settings, errors);
    }
    name_after_file(source->root, file);
    rename_old(source->root, errors);
    set_defaults_without_shell(source->root);
    if (!begun.empty()) {
        set_fields_of_run(source->root, begun);
    } else if (command_dir.empty()) {
        set_defaults_of_fit(source->root);
        set_defaults_by_values(source->root);
        set_fields_of_start(source->root, file.parent_path());
    }
    validate(source->root, file.parent_path(), errors);
    read_case(source->root, file.parent_path(), the_case, errors);
    set_planform_values(the_case, errors);
    set_formulas(the_case, errors);
    cross_check(source->root, purpose, the_case, errors);
    errors.throw_if_any();
    add_built_in(the_case);
    if (command_dir.empty()) the_case.notes = errors.notes();
    the_case.source = std::move(source);
    return the_case;
}

/// Packed ones (.stl.gz) too.
bool has_surface_extension(std::filesystem::path file) {
    if (file.extension() == ".gz") file.replace_extension();
    try {
        format_of(file);
    } catch (const InvalidInput&) {
        return false;
    }
    return true;
}

bool is_map(const std::filesystem::path& file) {
    try {
        return parse_yaml(read_case_file(file.string()), file.string()).form == Value::Form::map;
    } catch (const CaseError&) {
        return false;
    }
}

/// A surface that was given in place of a case fails as one in many ways, none of which says so.
Case loaded_file(const std::filesystem::path& file, Purpose purpose, const std::filesystem::path& command_dir,
                 const std::vector<std::string>& settings, const std::string& begun = {}) {
    try {
        return loaded(read_case_file(file.string()), file, purpose, command_dir, settings, begun);
    } catch (const CaseError&) {
        std::error_code ignored;
        if (!std::filesystem::is_regular_file(file, ignored) || !has_surface_extension(file) || is_map(file)) throw;
        Diagnostics errors(file.string(), {});
        errors.add({0, 0}, text("is a surface, not a case; `strake init ", shell_word(file.string()),
                                "` writes a case for it"));
        errors.throw_if_any();
        throw;
    }
}

}  // namespace

Case load_case(const std::filesystem::path& file, Purpose purpose, const std::filesystem::path& command_dir) {
    return loaded_file(file, purpose, command_dir, {});
}

Case load_case(const std::filesystem::path& file, Purpose purpose, const std::vector<std::string>& settings) {
    return loaded_file(file, purpose, "", settings);
}

Case load_case(const std::filesystem::path& file, Purpose purpose, const std::vector<std::string>& settings,
               const std::string& begun) {
    return loaded_file(file, purpose, "", settings, begun);
}

Case load_case(const std::filesystem::path& file, Purpose purpose) { return loaded_file(file, purpose, "", {}); }

Case load_case_text(const std::string& yaml, const std::filesystem::path& file, Purpose purpose) {
    return loaded(yaml, file, purpose, "", {});
}

}  // namespace strake
