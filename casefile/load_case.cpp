#include "casefile/load_case.hpp"

#include <algorithm>

#include "casefile/check/cross_check.hpp"
#include "casefile/read/dependent_defaults.hpp"
#include "casefile/read/read_case.hpp"
#include "casefile/read/settings.hpp"
#include "casefile/schema/renamed.hpp"
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
    if (begun.empty())
        set_dependent_defaults(source->root, file.parent_path(), command_dir.empty());
    else
        set_defaults_of_run(source->root, begun);
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
