#pragma once
#include "casefile/model/case_source.hpp"

namespace strake {

/// Fills the structs from the checked tree; refused values are skipped.
void read_case(const Value& root, const std::filesystem::path& case_dir, Case& the_case, Diagnostics& errors);

/// Parses the formulas and moves them behind all other quantities. Before `cross_check`.
void set_formulas(Case& the_case, Diagnostics& errors);

/// Makes quantities of the values of declared wings that objective, constraints and formulas name; a constraint on
/// thickness_grid becomes one on each of its places. Before `set_formulas`.
void set_planform_values(Case& the_case, Diagnostics& errors);

/// The name is that of an angle of a declared wing: "wing.twist@0.37".
bool is_wing_angle(const Case& the_case, const std::string& value);

}  // namespace strake
