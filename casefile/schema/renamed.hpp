#pragma once
#include "casefile/schema/schema.hpp"

/// Keys and words that had another name before: read with a note until 1.0, written with the present name only.
namespace strake {

struct RenamedKey {
    std::string map;          ///< path of the map that holds it, "quantities.*"
    std::string before, now;  ///< names in that map
    std::string path() const { return map + "." + now; }
};
struct RenamedWord {
    std::string path;  ///< of the key or the list's entries that take it
    std::string before, now;
};
/// A key that is now stated once for the case. Both are rows of the table; the reader of the old one notes it.
struct MovedKey {
    std::string path, now;  ///< "quantities.*.forward", "axes.downstream"
};
const std::vector<RenamedKey>& renamed_keys();
const std::vector<MovedKey>& moved_keys();
const std::vector<RenamedWord>& renamed_words();

/// Gives every key and word its present name, with a note at its place. Both names in one map are an error at the
/// second. For `validate`, which knows the present names only.
void rename_old(Value& root, Diagnostics& errors);

}  // namespace strake
