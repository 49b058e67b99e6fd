#pragma once
#include "casefile/model/case_source.hpp"

#include <optional>

namespace strake {

/// Fills the structs from the checked tree; refused values are skipped.
void read_case(const Value& root, const std::filesystem::path& case_dir, Case& the_case, Diagnostics& errors);

/// Parses the formulas and moves them behind all other quantities. Before `cross_check`.
void set_formulas(Case& the_case, Diagnostics& errors);

/// Makes quantities of the values of declared wings that objective, constraints and formulas name; a constraint on
/// thickness_grid becomes one on each of its places. Before `set_formulas`.
void set_planform_values(Case& the_case, Diagnostics& errors);

/// A value of a declared wing or body, "wing.twist@0.37", legal or not: `set_planform_values` reports what is not.
bool is_wing_value(const Case& the_case, const std::string& name);

/// Whether a value is an angle of a declared wing; nothing: it is refused elsewhere, and cannot be said.
std::optional<bool> is_wing_angle(const Case& the_case, const std::string& name);

}  // namespace strake
