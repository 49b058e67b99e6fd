#include "casefile/schema/schema_words.hpp"

#include "core/error.hpp"

namespace strake {
namespace {

std::string code(const std::string& text) { return "`" + text + "`"; }

std::string words_of(const Key& key) {
    std::string out;
    for (const std::string& word : key.words) out += (out.empty() ? "" : ", ") + code(word);
    return out;
}

}  // namespace

std::string type_name(Type type) {
    switch (type) {
        case Type::map:
            return "map";
        case Type::list:
            return "list";
        case Type::text:
            return "text";
        case Type::name:
            return "name";
        case Type::word:
            return "word";
        case Type::flag:
            return "true or false";
        case Type::integer:
            return "integer";
        case Type::number:
            return "number";
        case Type::fraction:
            return "number or %";
        case Type::length:
            return "length";
        case Type::coordinate:
            return "coordinate";
        case Type::angle:
            return "angle";
        case Type::number_or_angle:
            return "number or angle";
        case Type::duration:
            return "time";
        case Type::file:
            return "file";
        case Type::path:
            return "path";
    }
    return "";
}

std::string shape_of(const Key& key) {
    if (key.type == Type::word) return words_of(key);
    if (key.type != Type::list) return type_name(key.type) + (key.words.empty() ? "" : " or " + words_of(key));
    const std::string element = key.element == Type::word ? words_of(key) : type_name(key.element);
    const std::string count = key.count ? text(key.count, " x ") : "";
    return "list: " + count + element;
}

std::string limits_of(const Key& key) {
    const Limits& limit = key.limits;
    const Type type = key.type == Type::list ? key.element : key.type;
    const std::string unit = type == Type::angle ? "deg" : "";
    const auto shown = [&](double v) { return type == Type::fraction ? text(v * 100, "%") : text(v, unit); };
    const bool has_max = limit.max < std::numeric_limits<double>::infinity();
    const bool has_min = limit.min > -std::numeric_limits<double>::infinity();
    if (has_max)
        return text(limit.min_open ? "(" : "[", shown(limit.min), ", ", shown(limit.max), limit.max_open ? ")" : "]");
    return has_min ? text(limit.min_open ? "> " : ">= ", shown(limit.min)) : "";
}

std::string default_of(const Key& key) {
    if (key.required) return "required";
    return key.fallback.empty() || key.fallback == "{}" ? "" : code(key.fallback);
}

std::string condition_of(const Key& key) {
    if (key.when.empty()) return "";
    const Condition condition = parse_condition(key.when);
    if (condition.kind == Condition::Kind::present) {
        std::string keys;
        for (const std::string& key : condition.words) keys += (keys.empty() ? "" : " or ") + code(key);
        return text(" Only with ", keys, ".");
    }
    if (condition.kind == Condition::Kind::is_list) return text(" Only with a list of ", code(condition.key), ".");
    const bool in_list = condition.kind == Condition::Kind::holds_word;
    std::string forms;
    for (const std::string& word : condition.words)
        forms += (forms.empty() ? "" : " or ") + code(condition.key + ": " + (in_list ? "[" + word + "]" : word));
    return text(" Only with ", forms, ".");
}

}  // namespace strake
