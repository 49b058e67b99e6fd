#pragma once
#include "casefile/yaml/diagnostics.hpp"

#include <string>
#include <vector>

/// A parsed case file as a plain tree, without aliases, tags or other surprises of YAML.
namespace strake {

struct Key;
struct Entry;

struct Value {
    enum class Form { scalar, list, map };
    Form form = Form::scalar;
    std::string text;     ///< scalars
    bool quoted = false;  ///< written in quotes or as a block
    bool null = false;    ///< nothing, ~ or null
    Place place;
    std::vector<Entry> entries;  ///< of lists (without key) and maps, in the order of the file

    // Set by validate().
    const Key* accepted = nullptr;  ///< the row of the table; null: refused, and reported
    bool from_default = false;
    double number = 0;      ///< value of a scalar: surface unit, radians, seconds, 0 or 1
    bool relative = false;  ///< a length given as a percentage

    /// The accepted value of a map's key, or null.
    const Value* find(const std::string& key) const;
};

struct Entry {
    std::string key;
    Place key_place;
    Value value;
};

inline const Value* Value::find(const std::string& key) const {
    for (const Entry& entry : entries)
        if (entry.key == key && entry.value.accepted) return &entry.value;
    return nullptr;
}

/// Limits that keep the cost of a hostile file low.
constexpr std::size_t max_case_bytes = 1000000;
constexpr int max_case_depth = 64;
constexpr int max_case_values = 100000;  ///< after aliases have been expanded

/// Parses the text of a case file. A syntax error throws CaseError at once (nothing after it can be trusted).
/// @throws CaseError: not UTF-8, too large, too deep, too many values, aliases that contain themselves, merge keys,
/// explicit tags, a second document, keys that are not text, YAML syntax.
Value parse_yaml(const std::string& bytes, const std::string& shown_file);

/// Reads a regular file of at most max_case_bytes. @throws CaseError with the system's reason.
std::string read_case_file(const std::string& path);

std::vector<std::string> split_lines(const std::string& bytes);

}  // namespace strake
