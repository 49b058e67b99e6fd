#include "casefile/schema/renamed.hpp"
#include "casefile/schema/scalars.hpp"
#include "casefile/schema/schema_words.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace strake {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* number_text = R"([+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?)";

Json pattern(const std::string& expression) { return {{"type", "string"}, {"pattern", "^" + expression + "$"}}; }

/// A number within the limits. Those of angles and times are not in their number's unit, those of percentages are not
/// visible in the text: only plain numbers have them here.
Json plain_number(const char* type, const Limits& limits) {
    Json j{{"type", type}};
    if (std::isfinite(limits.min)) j[limits.min_open ? "exclusiveMinimum" : "minimum"] = limits.min;
    if (std::isfinite(limits.max)) j[limits.max_open ? "exclusiveMaximum" : "maximum"] = limits.max;
    return j;
}

Json any_of(std::vector<Json> forms) {
    if (forms.size() == 1) return forms.front();
    return {{"anyOf", forms}};
}

/// Words that differ only in case, '-' and NLopt's prefixes are the same.
std::string loose_pattern(const std::vector<std::string>& words) {
    std::string all;
    for (const std::string& word : words) {
        all += all.empty() ? "" : "|";
        for (const char c : algorithm_word(word)) {
            const char upper = c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
            all += upper == c ? std::string(1, c) : std::string("[") + c + upper + "]";
            all += "-*";
        }
    }
    return "([nN][lL][oO][pP][tT]_)?([lLgG][dDnN]_|[gG]_)?(" + all + ")";
}

/// Words of earlier versions are valid, too, and marked.
Json words_schema(const Key& key) {
    Json exact{{"enum", key.words}};
    std::vector<std::string> before;
    for (const RenamedWord& word : renamed_words())
        if (word.path == key.path + (key.type == Type::list ? "[]" : "")) before.push_back(word.before);
    if (!key.loose_word && before.empty()) return exact;
    if (!key.loose_word) return any_of({exact, {{"enum", before}, {"deprecated", true}}});
    std::vector<std::string> all = key.words;
    all.insert(all.end(), key.aliases.begin(), key.aliases.end());
    return any_of({exact, pattern(loose_pattern(all))});
}

std::string units_pattern() { return "( *(" + joined(length_units(), "|") + "))?"; }

Json scalar_schema(Type type, const Key& key) {
    const std::string number = number_text;
    switch (type) {
        case Type::text:
        case Type::path:
        case Type::file:
            return {{"type", {"string", "number"}}, {"minLength", 1}};
        case Type::name:
            return {{"type", {"string", "number"}}, {"pattern", "^[A-Za-z0-9_-]{1,100}$"}};
        case Type::word:
            return words_schema(key);
        case Type::flag:
            return {{"type", "boolean"}};
        case Type::integer:
            return plain_number("integer", key.limits);
        case Type::number:
            return plain_number("number", key.limits);
        case Type::fraction:
            return any_of({plain_number("number", key.limits), pattern(number + " *%")});
        case Type::length:
            return any_of({plain_number("number", key.limits), pattern(number + "( *%|" + units_pattern() + ")")});
        case Type::coordinate:
            return any_of({plain_number("number", key.limits), pattern(number + units_pattern())});
        case Type::angle:
            return any_of({Json{{"const", 0}}, pattern(number + " *(deg|rad)")});
        case Type::number_or_angle:
            return any_of({plain_number("number", key.limits), pattern(number + " *(deg|rad)")});
        case Type::duration:
            return pattern(number + " *(s|min|h)");
        case Type::map:
        case Type::list:
            break;
    }
    return Json::object();
}

/// A default as an editor would insert it.
Json default_json(const Value& value) {
    double number = 0;
    if (value.form == Value::Form::scalar && !value.quoted && read_number(value.text, number).empty())
        return number == std::floor(number) && std::abs(number) < 1e9 ? Json(static_cast<long>(number)) : Json(number);
    if (value.form == Value::Form::scalar && (value.text == "true" || value.text == "false"))
        return value.text == "true";
    if (value.form == Value::Form::scalar) return value.text;
    Json j = value.form == Value::Form::list ? Json::array() : Json::object();
    for (const Entry& entry : value.entries)
        if (value.form == Value::Form::list)
            j.push_back(default_json(entry.value));
        else
            j[entry.key] = default_json(entry.value);
    return j;
}

class Writer {
public:
    Json node(const std::string& path) const {
        std::vector<Json> forms;
        for (const Key* key : schema_index().rows.at(path)) forms.push_back(form(*key));
        return any_of(forms);
    }

    /// The keys of the map at `path`; "" is the whole case.
    Json keys(const std::string& path) const {
        Json j{{"type", "object"}};
        const auto found = schema_index().children.find(path);
        if (found == schema_index().children.end()) return j;
        Json properties = Json::object(), required = Json::array(), dependent = Json::object(), rules = Json::array();
        Json others = false;
        for (const std::string& name : found->second) {
            const std::string below = child_path(path, name);
            if (name == "*") {
                others = node(below);
                continue;
            }
            properties[name] = node(below);
            const Key& row = *schema_index().rows.at(below).front();
            if (row.required && row.when.empty()) required.push_back(name);
            if (row.when.empty()) continue;
            const Json beside = condition(path, row.when);
            dependent[name] = beside;
            const std::string needed = row.required ? row.when : row.required_when;
            if (!needed.empty())
                rules.push_back({{"if", stated(condition(path, needed), needed)}, {"then", {{"required", {name}}}}});
        }
        add_renamed(path, properties, dependent);
        j["properties"] = std::move(properties);
        j["additionalProperties"] = std::move(others);
        if (!required.empty()) j["required"] = std::move(required);
        if (!dependent.empty()) j["dependentSchemas"] = std::move(dependent);
        if (!rules.empty()) j["allOf"] = std::move(rules);
        return j;
    }

private:
    static std::string child_path(const std::string& path, const std::string& name) {
        return path.empty() ? name : path + "." + name;
    }

    /// Keys under the names they had before, marked.
    void add_renamed(const std::string& path, Json& properties, Json& dependent) const {
        for (const RenamedKey& renamed : renamed_keys()) {
            if (renamed.map != path) continue;
            Json old = node(renamed.path());
            old["deprecated"] = true;
            old["description"] = text("Now called '", renamed.now, "'.");
            properties[renamed.before] = std::move(old);
            const Key& row = *schema_index().rows.at(renamed.path()).front();
            if (!row.when.empty()) dependent[renamed.before] = condition(path, row.when);
        }
    }

    Json form(const Key& key) const {
        Json j = key.type == Type::map    ? keys(key.path)
                 : key.type == Type::list ? list(key)
                                          : scalar_schema(key.type, key);
        if (key.type != Type::word && !key.words.empty() && key.type != Type::list)
            j = any_of({Json{{"enum", key.words}}, j});
        j["description"] = key.doc + condition_of(key);
        if (!key.fallback.empty() && key.fallback != "{}" && key.fallback.find('{') == std::string::npos)
            j["default"] = default_json(parse_yaml(key.fallback, "default"));
        return j;
    }

    Json list(const Key& key) const {
        Json j{{"type", "array"}};
        const bool has_rows = schema_index().rows.count(key.path + "[]") > 0;
        j["items"] = has_rows ? node(key.path + "[]") : scalar_schema(key.element, key);
        if (key.count > 0) j["minItems"] = key.count, j["maxItems"] = key.count;
        if (key.count == 0 && !key.may_be_empty) j["minItems"] = 1;
        return j;
    }

    static Json word_of(const Condition& c) {
        if (c.kind == Condition::Kind::is_list) return {{"type", "array"}};
        if (c.kind == Condition::Kind::is_word) return {{"enum", c.words}};
        return {{"contains", {{"enum", c.words}}}};
    }

    /// What Key::when asks of the map at `path`; a key that is not written has its default.
    static Json condition(const std::string& path, const std::string& when) {
        const Condition c = parse_condition(when);
        if (c.kind == Condition::Kind::present) {
            std::vector<Json> any;
            for (const std::string& key : c.words) any.push_back({{"required", {key}}});
            return any_of(any);
        }
        Json j{{"properties", {{c.key, word_of(c)}}}};
        if (!default_holds(path, c)) j["required"] = {c.key};
        return j;
    }

    static bool default_holds(const std::string& path, const Condition& c) {
        const auto rows = schema_index().rows.find(path.empty() ? c.key : path + "." + c.key);
        if (rows == schema_index().rows.end() || c.kind == Condition::Kind::is_list) return false;
        for (const Key* key : rows->second)
            for (const std::string& word : c.words)
                if (key->fallback == word || key->fallback == "[" + word + "]") return true;
        return false;
    }

    /// The same for "if": only where it is written.
    static Json stated(Json condition, const std::string& when) {
        const Condition c = parse_condition(when);
        if (c.kind != Condition::Kind::present) condition["required"] = {c.key};
        return condition;
    }
};

}  // namespace

std::string schema_json() {
    Json j{{"$schema", "https://json-schema.org/draft/2020-12/schema"},
           {"title", "Strake case file"},
           {"description", "Case file of strake run, fit, deform, sweep and check."}};
    const Json top = Writer().keys("");
    for (const auto& [key, value] : top.items()) j[key] = value;
    return j.dump(2) + "\n";
}

}  // namespace strake
