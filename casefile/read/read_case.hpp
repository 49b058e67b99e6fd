#pragma once
#include "casefile/model/case_source.hpp"

namespace strake {

/// Fills the structs from the checked tree; refused values are skipped.
void read_case(const Value& root, const std::filesystem::path& case_dir, Case& the_case, Diagnostics& errors);

/// Parses the formulas and moves them behind all other quantities. Before `cross_check`.
void set_formulas(Case& the_case, Diagnostics& errors);

}  // namespace strake
