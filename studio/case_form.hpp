#pragma once
#include <nlohmann/json.hpp>
#include <string>

/// The main keys of a case as a form beside its text.
namespace strake {

/// {rows: [{path, value, line, comment, doc, form, limits, default, words, required}],
///  reasons: [{path, value, line, why}], quantities: [{name, doc}], types: [{name, doc}],
///  constraints: [{name, min, max, equals, relative, line}]}
/// A row's `value` is what the text has, "" where it is silent; `reasons` are entries that have a comment; `quantities`
/// may be objectives as they are, `types` need an entry under `quantities`. {broken: message, line}: it is no YAML.
nlohmann::ordered_json case_form(const std::string& yaml);

/// [{path, doc, form, limits, default, words, is_flag, is_list}] of every key of the schema, "regions.*.box".
nlohmann::ordered_json case_keys();

}  // namespace strake
