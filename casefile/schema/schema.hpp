#pragma once
#include "casefile/yaml/value.hpp"

#include <filesystem>
#include <limits>
#include <map>
#include <string>
#include <vector>

/// The keys of a case file: one table for the checks, the suggestions, docs/cases.md and the resolved case.
namespace strake {

enum class Type {
    map,
    list,
    text,             ///< any text
    name,             ///< letters, digits, '_' and '-'
    word,             ///< one of Key::words
    flag,             ///< true or false
    integer,          ///< fits an int
    number,           ///< finite
    fraction,         ///< a number, or a percentage
    length,           ///< number in the surface's unit, number with a unit, or percentage of the diagonal
    coordinate,       ///< length without percentages
    angle,            ///< number with deg or rad, or 0
    number_or_angle,  ///< number, or number with deg or rad
    duration,         ///< number with s, min or h
    file,             ///< existing regular file, relative to the case file
    path              ///< any path, relative to the case file
};

/// Limits in the unit that the message shows: degrees for angles, seconds for times, fractions.
struct Limits {
    double min = -std::numeric_limits<double>::infinity(), max = std::numeric_limits<double>::infinity();
    bool min_open = false, max_open = false;
};

struct Key {
    std::string path;  ///< "loads[].traction", "regions.*.box"; several rows with one path: alternative forms
    Type type = Type::map;
    std::string doc = "";       ///< one sentence
    std::string fallback = "";  ///< default as it would be written; empty: none
    bool required = false;
    std::string required_when = "";  ///< where only one of the keys in `when` needs it: that key
    Limits limits = {};
    std::vector<std::string> words = {};    ///< legal ones; of other types than word: accepted in place of a value
    std::vector<std::string> aliases = {};  ///< other spellings: one per word, in the same order, or none
    Type element = Type::map;               ///< of lists of scalars
    int count = 0;                          ///< of lists: exact length; 0: any, at least one
    /// Only beside such a key: "plane", "command|plugin" (either), "type=target_shape", "split=sensitivity|gradient",
    /// "levels=[]" (a list), "variables[]=load" (a list that holds the word).
    std::string when = "";
    bool loose_word = false;    ///< upper case, NLopt prefixes and '-' have no effect
    bool may_be_empty = false;  ///< lists and maps of names
};

/// Key::when, parsed.
struct Condition {
    std::string key;
    enum class Kind { present, is_list, is_word, holds_word } kind = Kind::present;
    std::vector<std::string> words;  ///< of present, is_word and holds_word: any of these
};
Condition parse_condition(const std::string& when);

const std::vector<Key>& schema();

/// The table by path, and the names below each path in the table's order ("*" among them; "" is the top).
struct SchemaIndex {
    std::map<std::string, std::vector<const Key*>> rows;
    std::map<std::string, std::vector<std::string>> children;
};
const SchemaIndex& schema_index();

/// Checks `root` against the table, converts every scalar, and adds the defaults to the tree. Refused values keep
/// `accepted == nullptr`. `case_dir`: for files.
void validate(Value& root, const std::filesystem::path& case_dir, Diagnostics& errors);

/// The text of docs/cases.md.
std::string schema_reference();

/// The table as a JSON Schema (draft 2020-12), for editors to complete and check case files. Everything that the
/// loader accepts is valid; checks that need the loader (files, names, "exactly one of") are not part of it.
std::string schema_json();

}  // namespace strake
