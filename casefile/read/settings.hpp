#pragma once
#include "casefile/yaml/value.hpp"

/// Keys of a case that the command line sets: `--set KEY=VALUE`.
namespace strake {

/// Puts VALUE, as YAML, at KEY of the tree, one setting after the other; maps on the way that are missing are made.
/// KEY is a path: "optimize.budget.evaluations", "loads[0].traction" (one past the end appends),
/// "constraints.aero.lift" (names that hold dots are found; a new one is written in double quotes). Every value gets
/// the place `place_of_setting(k)`, under which `Diagnostics` quote the setting. What cannot be set becomes an error
/// there.
void apply_settings(Value& root, const std::vector<std::string>& settings, Diagnostics& errors);

}  // namespace strake
