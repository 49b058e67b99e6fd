#pragma once
#include "casefile/yaml/value.hpp"

#include <optional>
#include <string>

/// Changes of single keys of a case file as text, which keep its comments, its order and its style.
namespace strake {

/// Where an entry of a case stands in its text, in bytes.
struct EntrySpan {
    std::size_t key = 0, value = 0, end = 0;  ///< first of the key and of the value; behind the value
    bool in_flow = false;                     ///< inside of braces or brackets
    std::string words;                        ///< the value as it is written
    std::string comment;                      ///< behind it or directly above it, without #, joined to one line
    int line = 0;                             ///< of the key, 1-based
};

/// As `parse_yaml`, and a map without entries of an empty text.
Value case_map(const std::string& yaml);

/// The entry at a path of names, "optimize.budget.evaluations"; nothing: the case does not state it.
/// @throws CaseError: no YAML.
std::optional<EntrySpan> entry_span(const std::string& yaml, const std::string& path);

/// With this value (YAML of one line) at a path of names; keys above it are added as needed. An empty value removes
/// the entry, the comment directly above it, and keys above it that hold nothing else. The rest of the case means what
/// it meant before.
/// @throws InvalidInput: the value is no YAML of one line, or the case is written in a way that cannot be changed key
/// by key.
std::string with_value(const std::string& yaml, const std::string& path, const std::string& value);

}  // namespace strake
