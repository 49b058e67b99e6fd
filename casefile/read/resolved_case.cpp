#include "casefile/read/resolved_case.hpp"

#include <algorithm>

#include "casefile/model/case_source.hpp"
#include "casefile/schema/schema.hpp"

namespace strake {
namespace {

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
    Emitter(const Case& the_case, const std::filesystem::path& folder, std::string wrap)
        : case_(the_case), folder_(folder), wrap_(std::move(wrap)) {}

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
            if (entry.key == "wrap" && !wrap_.empty() && entry.value.form == Value::Form::scalar) {
                out += "wrap: " + wrap_ + "\n";
                continue;
            }
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
    std::string wrap_;

    /// Keys that a fit or a run does not use are refused: their defaults are not written.
    bool skipped(const std::string& path, const Value& value) const {
        if (value.from_default && path == "parameters.max_displacement" && case_.parameters.is_planform_alone())
            return true;  // would read as stated, and has no effect
        if (value.from_default && path == "parameters.patches_per_level" && !case_.has_shell) return true;  // likewise
        if (case_.fit.empty())
            return value.from_default && (path == "optimize.loss" || path == "optimize.icp_iterations");
        if (value.from_default && path == "parameters.max_displacement") return true;  // a fit has none by default
        return value.from_default && (path == "optimize.method" || path == "optimize.tolerances.constraint" ||
                                      path == "optimize.finite_differences" || path == "optimize.difference_step" ||
                                      path == "optimize.batch" || path == "optimize.starts" || path == "optimize.seed");
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

    /// Absolute for the folder itself: "." would mean another folder wherever the file is copied.
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

}  // namespace

std::string stated_wrap(const std::string& resolved) {
    const std::string key = "\nwrap: {";
    const std::size_t at = resolved.find(key);
    if (at == std::string::npos) return "";
    const std::size_t begin = at + key.size() - 1;
    return resolved.substr(begin, resolved.find('\n', begin) - begin);
}

std::string resolved_case(const Case& the_case, const std::filesystem::path& folder, const std::string& wrap) {
    return Emitter(the_case, folder, wrap).block(the_case.source->root);
}

}  // namespace strake
