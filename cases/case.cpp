#include "cases/case.hpp"

#include "cases/case_source.hpp"
#include "cases/schema.hpp"

#include <algorithm>

namespace strake {
namespace {

/// Built-in quantities that are used without an entry get one.
void add_built_in(Case& c) {
    const auto used = [&](const std::string& name) {
        const auto holds = [&](const QuantityEntry& quantity) {
            const auto* formula = std::get_if<FormulaEntry>(&quantity.what);
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

std::string quoted(const std::string& text) {
    std::string out = "\"";
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (c == '"' || c == '\\')
            out += {'\\', c};
        else if (byte < 0x20 || byte == 0x7F)
            out += "\\x" + printable(std::string(1, c)).substr(2);
        else
            out += c;
    }
    return out + "\"";
}

/// `path` as seen from `folder`: relative where it lies below it, else absolute.
std::string rebased(const std::filesystem::path& path, const std::filesystem::path& folder) {
    const auto whole = [](const std::filesystem::path& p) {
        return std::filesystem::absolute(p.empty() ? "." : p).lexically_normal();
    };
    const std::filesystem::path relative = whole(path).lexically_relative(whole(folder));
    const bool inside = !relative.empty() && *relative.begin() != "..";
    return (inside ? relative : whole(path)).string();
}

/// Writes the checked tree as YAML; every scalar as it was written, except for paths.
class Emitter {
public:
    Emitter(const Case& the_case, const std::filesystem::path& folder) : case_(the_case), folder_(folder) {}

    std::string flow(const Value& value, const std::string& path) const {
        if (value.form == Value::Form::scalar) return scalar(value, path);
        const bool is_map = value.form == Value::Form::map;
        std::string out = is_map ? "{" : "[";
        bool first = true;
        for (const Entry& entry : value.entries) {
            const std::string below = is_map ? path + "." + entry.key : path + "[]";
            if (skipped(below, entry.value)) continue;
            out += first ? "" : ", ";
            first = false;
            if (is_map) out += key(entry.key) + ": ";
            out += flow(entry.value, below);
        }
        return out + (is_map ? "}" : "]");
    }

    std::string block(const Value& root) const {
        std::string out;
        for (const Entry& entry : root.entries) {
            const bool is_named_map = entry.key == "regions" || entry.key == "quantities" || entry.key == "variables" ||
                                      entry.key == "constraints" || entry.key == "optimize" ||
                                      entry.key == "parameters";
            if (!is_named_map || entry.value.entries.empty()) {
                out += key(entry.key) + ": " + flow(entry.value, entry.key) + "\n";
                continue;
            }
            out += key(entry.key) + ":\n";
            for (const Entry& child : entry.value.entries) {
                const std::string below = entry.key + "." + child.key;
                if (!skipped(below, child.value)) out += "  " + key(child.key) + ": " + flow(child.value, below) + "\n";
            }
        }
        return out;
    }

private:
    const Case& case_;
    const std::filesystem::path& folder_;

    /// What a fit or a run does not use is refused, so these defaults are not written.
    bool skipped(const std::string& path, const Value& value) const {
        if (case_.fit.empty())
            return value.from_default && (path == "optimize.loss" || path == "optimize.associations");
        return value.from_default && (path == "optimize.method" || path == "optimize.tolerances.constraint" ||
                                      path == "optimize.finite_differences" || path == "optimize.difference_step" ||
                                      path == "optimize.starts" || path == "optimize.seed");
    }

    static std::string key(const std::string& name) {
        const bool plain = !name.empty() && name.find_first_not_of("abcdefghijklmnopqrstuvwxyz_") == std::string::npos;
        return plain && name != "null" && name != "true" && name != "false" ? name : quoted(name);
    }

    std::string scalar(const Value& value, const std::string& path) const {
        if (path == "output.dir") return quoted(output_dir());
        const Type type = value.accepted->type == Type::list ? value.accepted->element : value.accepted->type;
        const std::filesystem::path here = case_.dir();
        if (type == Type::file || path == "optimize.start_from") return quoted(rebased(here / value.text, folder_));
        if (path.ends_with(".command[]") && is_program(value))
            return quoted(std::filesystem::absolute(here / value.text).lexically_normal().string());
        if (type == Type::text || type == Type::name || type == Type::path) return key(value.text);
        return value.text;
    }

    /// The folder itself has no name below itself: "." would mean another one wherever the file is copied to.
    std::string output_dir() const {
        const std::string relative = rebased(case_.output.dir, folder_);
        return relative == "." ? std::filesystem::absolute(case_.output.dir).lexically_normal().string() : relative;
    }

    /// The first argument of a command, where it is a path.
    bool is_program(const Value& value) const {
        if (value.text.find('/') == std::string::npos || value.text.starts_with('{')) return false;
        const Value* quantities = case_.source->root.find("quantities");
        for (const Entry& quantity : quantities->entries)
            if (const Value* command = quantity.value.find("command"))
                if (&command->entries[0].value == &value) return true;
        return false;
    }
};

/// A case without a name is called as its file.
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

}  // namespace

Case load_case(const std::filesystem::path& file, Purpose purpose) { return load_case(file, purpose, {}); }

Case load_case(const std::filesystem::path& file, Purpose purpose, const std::filesystem::path& command_dir) {
    const std::string bytes = read_case_file(file.string());
    auto source = std::make_shared<Case::Source>();
    source->root = parse_yaml(bytes, file.string());
    source->lines = split_lines(bytes);
    Diagnostics errors(file.string(), source->lines);
    Case the_case;
    the_case.file = file;
    the_case.command_dir = command_dir;
    name_after_file(source->root, file);
    validate(source->root, file.parent_path(), errors);
    read_case(source->root, file.parent_path(), the_case, errors);
    set_formulas(the_case, errors);
    cross_check(source->root, purpose, the_case, errors);
    errors.throw_if_any();
    add_built_in(the_case);
    the_case.source = std::move(source);
    return the_case;
}

std::string resolved_case(const Case& the_case, const std::filesystem::path& folder) {
    return Emitter(the_case, folder).block(the_case.source->root);
}

Diagnostics diagnostics_of(const Case& the_case) { return {the_case.file.string(), the_case.source->lines}; }

}  // namespace strake
