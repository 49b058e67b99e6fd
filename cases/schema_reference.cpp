#include "cases/schema.hpp"

#include <map>

namespace strake {
namespace {

std::string code(const std::string& text) { return "`" + text + "`"; }

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

std::string words_of(const Key& key) {
    std::string out;
    for (const std::string& word : key.words) out += (out.empty() ? "" : ", ") + code(word);
    return out;
}

std::string shape_of(const Key& key) {
    if (key.type == Type::word) return words_of(key);
    if (key.type != Type::list) return type_name(key.type);
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

const char* introduction = R"(# Case file reference

This page is made from the tables in `cases/schema_*.cpp`; a test compares the two.

A case is one YAML document in UTF-8. Paths are relative to the case file. In the table `*` is a name of your own
and `[]` an entry of a list; several rows of one key are its alternative forms. Unknown keys, keys given twice and wrong
values are errors, all told at once as `file:line:column: message`.

- **length**: a plain number is in the surface's unit; `5 mm` (m, cm, mm, um, in, ft) is converted to it and needs
  `surface.units`; `5%` is of the diagonal of the start surface's bounding box. A **coordinate** takes no percentage.
- **angle**: every number carries `deg` or `rad`; a plain 0 is accepted. **time**: `s`, `min` or `h`.
- **number**: decimal point, no thousands separators, no leading zeros, finite; text in quotes is not a number.
- **name**: letters, digits, `_` and `-`. Aliases (`&`, `*`) work; merge keys (`<<`), tags and a second document do not.

| key | form | limits | default | meaning |
|---|---|---|---|---|
)";

}  // namespace

std::string schema_reference() {
    std::string out = introduction;
    for (const Key& key : schema())
        out += text("| ", code(key.path), " | ", shape_of(key), " | ", limits_of(key), " | ", default_of(key), " | ",
                    key.doc, condition_of(key), " |\n");
    return out;
}

}  // namespace strake
