#pragma once
#include <string_view>

namespace strake {

/// Levenshtein distance, for "did you mean": insertions, deletions and replacements of one byte that turn `a` into `b`.
int edit_distance(std::string_view a, std::string_view b);

}  // namespace strake
