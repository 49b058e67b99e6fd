#include "casefile/model/case_source.hpp"
#include "casefile/read/resolved_case.hpp"
#include "casefile/schema/renamed.hpp"

#include <algorithm>
#include <map>

/// The files of a case and the differences between two cases, for runs that continue.
namespace strake {
namespace {

void collect(const Value& value, const std::string& path, const std::filesystem::path& dir,
             std::vector<std::pair<std::string, std::filesystem::path>>& files) {
    if (value.form != Value::Form::scalar) {
        for (const Entry& entry : value.entries)
            collect(entry.value, value.form == Value::Form::map ? path + "." + entry.key : path + "[]", dir, files);
        return;
    }
    if (value.accepted && value.accepted->type == Type::file) files.emplace_back(path.substr(1), dir / value.text);
}

/// Every scalar, and every empty list or map, by the path of its key.
void flatten(const Value& value, const std::string& path, std::map<std::string, std::string>& flat) {
    if (value.form == Value::Form::scalar) {
        flat[path.substr(1)] = value.text;
        return;
    }
    if (value.entries.empty() && !path.empty()) flat[path.substr(1)] = "";
    for (std::size_t k = 0; k < value.entries.size(); ++k) {
        const Entry& entry = value.entries[k];
        const bool is_map = value.form == Value::Form::map;
        flatten(entry.value, is_map ? path + "." + entry.key : path + "[" + std::to_string(k) + "]", flat);
    }
}

/// A key at its default that a run of before did not know: cases of runs hold all defaults.
bool is_new_default(const std::string& key, const std::string& value) {
    const auto is_default = [&](const std::string& pattern) {
        const auto rows = schema_index().rows.find(pattern);
        return rows != schema_index().rows.end() && !rows->second.front()->fallback.empty() &&
               rows->second.front()->fallback == value;
    };
    if (is_default(key)) return true;
    // One of its names is the user's: planform.wing.keep is planform.*.keep.
    for (std::size_t from = 0, dot = key.find('.'); dot != std::string::npos;
         from = dot + 1, dot = key.find('.', from)) {
        const std::string pattern = key.substr(0, from) + "*" + key.substr(dot);
        if (is_default(pattern)) return true;
    }
    return false;
}

}  // namespace

std::vector<std::pair<std::string, std::filesystem::path>> files_of(const Case& the_case) {
    std::vector<std::pair<std::string, std::filesystem::path>> files;
    collect(the_case.source->root, "", the_case.dir(), files);
    if (the_case.start_from) files.emplace_back("optimize.start_from", *the_case.start_from / "levels/best.design");
    return files;
}

bool may_change(const std::string& key) {
    return key.starts_with("optimize.budget") || key.starts_with("output.") ||
           (key.starts_with("quantities.") &&
            (key.ends_with(".timeout") || key.ends_with(".gradient_timeout") || key.ends_with(".parallel") ||
             key.ends_with(".cache") || key.find(".scheduler") != std::string::npos));
}

std::vector<std::string> changed_keys(const std::string& before, const std::string& now) {
    std::map<std::string, std::string> was, is;
    for (const auto& [yaml, flat] : {std::pair(&before, &was), std::pair(&now, &is)}) {
        Value root = parse_yaml(*yaml, "case.yaml");
        Diagnostics ignored("case.yaml", {});
        rename_old(root, ignored);  // the same keys, whatever they were called when the run began
        flatten(root, "", *flat);
        // Where both can be run with the same other keys, they are the same search.
        if (const auto method = flat->find("optimize.method"); method != flat->end() && method->second == "auto")
            method->second = "sqp";
    }
    std::vector<std::string> keys;
    for (const auto& [key, value] : was)
        if (const auto found = is.find(key); found == is.end() || found->second != value) keys.push_back(key);
    for (const auto& [key, value] : is)
        if (!was.contains(key) && !is_new_default(key, value)) keys.push_back(key);
    std::sort(keys.begin(), keys.end());
    return keys;
}

}  // namespace strake
