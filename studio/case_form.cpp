#include "studio/case_form.hpp"

#include "casefile/schema/quantity_types.hpp"
#include "casefile/schema/schema_words.hpp"
#include "studio/case_edit.hpp"

#include <algorithm>
#include <array>

namespace strake {
namespace {

using Json = nlohmann::ordered_json;

/// The lines that decide what a run does.
constexpr std::array<const char*, 18> form_paths{"surface.units",
                                                 "symmetry",
                                                 "axes",
                                                 "hold",
                                                 "fixed",
                                                 "parameters.variables",
                                                 "parameters.levels",
                                                 "parameters.patches_per_level",
                                                 "parameters.fields",
                                                 "parameters.max_displacement",
                                                 "parameters.mirror",
                                                 "objective.maximize",
                                                 "objective.minimize",
                                                 "optimize.method",
                                                 "optimize.budget.evaluations",
                                                 "optimize.budget.time",
                                                 "optimize.finite_differences",
                                                 "optimize.seed"};

std::string without_quotes(std::string words) {
    std::erase(words, '`');
    return words;
}

std::string cut(const std::string& words, std::size_t most) {
    return words.size() > most ? words.substr(0, most) + " …" : words;
}

/// {doc, form, limits, default, words, is_flag, is_list} of rows with one path.
void describe(Json& row, const std::vector<const Key*>& keys) {
    Json words = Json::array();
    std::string doc, form, limits;
    for (const Key* key : keys) {
        for (const std::string& word : key->words) words.push_back(word);
        doc += (doc.empty() ? "" : " ") + key->doc;
        form += (form.empty() ? "" : "; ") + without_quotes(shape_of(*key));
        limits += limits_of(*key);
    }
    const Key& first = *keys.front();
    row["doc"] = without_quotes(doc);
    row["form"] = form;
    row["limits"] = limits;
    row["default"] = first.fallback;
    row["words"] = words;
    row["is_flag"] = first.type == Type::flag;
    row["is_list"] = first.type == Type::list && first.element == Type::word;
}

Json row_of(const std::string& yaml, const std::string& path) {
    Json row{{"path", path}, {"value", ""}, {"line", 0}, {"comment", ""}};
    if (const auto span = entry_span(yaml, path)) {
        row["value"] = span->words;
        row["line"] = span->line;
        row["comment"] = span->comment;
    }
    const auto found = schema_index().rows.find(path);
    if (found != schema_index().rows.end()) describe(row, found->second);
    return row;
}

/// Entries with a comment, down to the second level: what `init` proposes says why.
Json reasons_of(const std::string& yaml, const Value& root) {
    Json list = Json::array();
    const auto add = [&](const std::string& path) {
        const auto span = entry_span(yaml, path);
        if (span && !span->comment.empty())
            list.push_back({{"path", path},
                            {"value", cut(span->words, 80)},
                            {"line", span->line},
                            {"why", cut(span->comment, 600)}});
    };
    for (const Entry& entry : root.entries) {
        add(entry.key);
        if (entry.value.form != Value::Form::map) continue;
        for (const Entry& below : entry.value.entries) add(entry.key + "." + below.key);
    }
    return list;
}

std::string text_of(const Value& map, const std::string& key) {
    for (const Entry& entry : map.entries)
        if (entry.key == key) return entry.value.text;
    return "";
}

Json constraints_of(const Value& root) {
    Json list = Json::array();
    for (const Entry& block : root.entries) {
        if (block.key != "constraints") continue;
        for (const Entry& one : block.value.entries)
            list.push_back({{"name", one.key},
                            {"min", text_of(one.value, "min")},
                            {"max", text_of(one.value, "max")},
                            {"equals", text_of(one.value, "equals")},
                            {"relative", text_of(one.value, "relative") == "true"},
                            {"line", one.key_place.line}});
    }
    return list;
}

/// Of a type with several values: "lift_to_drag" of "drag, lift, ...; a half model ...".
std::vector<std::string> outputs_of(const QuantityType& type) {
    std::vector<std::string> names;
    std::string name;
    for (const char c : type.values.substr(0, type.values.find(';')) + ",") {
        if (c != ',') {
            name += c;
            continue;
        }
        const std::size_t first = name.find_first_not_of(' ');
        const std::string one = first == std::string::npos ? "" : name.substr(first);
        if (!one.empty() && one.find_first_of(" ./") == std::string::npos) names.push_back(one);
        name.clear();
    }
    return names;
}

const QuantityType* type_named(const std::string& word) {
    for (const QuantityType& type : quantity_types())
        if (type.word == word) return &type;
    return nullptr;
}

Json quantities_of(const Value& root) {
    Json list = Json::array();
    for (const char* name : {"volume", "area"}) list.push_back({{"name", name}, {"doc", type_named(name)->doc}});
    for (const Entry& block : root.entries) {
        if (block.key != "quantities") continue;
        for (const Entry& one : block.value.entries) {
            const QuantityType* type = type_named(text_of(one.value, "type"));
            const auto outputs = type ? outputs_of(*type) : std::vector<std::string>();
            if (outputs.empty()) list.push_back({{"name", one.key}, {"doc", type ? type->doc : "Of this case."}});
            for (const std::string& output : outputs)
                list.push_back({{"name", one.key + "." + output}, {"doc", type->doc}});
        }
    }
    return list;
}

}  // namespace

Json case_form(const std::string& yaml) {
    Json form{{"rows", Json::array()}};
    const bool is_blank = yaml.find_first_not_of(" \t\r\n") == std::string::npos;
    try {
        const Value root = case_map(yaml);
        for (const char* path : form_paths) form["rows"].push_back(row_of(is_blank ? "" : yaml, path));
        form["reasons"] = is_blank ? Json::array() : reasons_of(yaml, root);
        form["constraints"] = constraints_of(root);
        form["quantities"] = quantities_of(root);
    } catch (const CaseError& error) {
        return {{"broken", error.diagnostics.empty() ? error.what() : error.diagnostics.front().message},
                {"line", error.diagnostics.empty() ? 0 : error.diagnostics.front().place.line}};
    }
    form["types"] = Json::array();
    for (const QuantityType& type : quantity_types())
        if (type.word != "volume" && type.word != "area")
            form["types"].push_back({{"name", type.word}, {"doc", type.doc}});
    return form;
}

Json case_keys() {
    Json list = Json::array();
    for (const auto& [path, keys] : schema_index().rows) {
        Json row{{"path", path}};
        describe(row, keys);
        list.push_back(std::move(row));
    }
    return list;
}

}  // namespace strake
