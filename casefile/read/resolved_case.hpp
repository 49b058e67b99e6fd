#pragma once
#include "casefile/model/case.hpp"

/// A case as written into its run folder, and the differences between two of them.
namespace strake {

/// The case with every default filled in, as YAML text that gives the same case when it is loaded from `folder`
/// (files there and not there are named by absolute paths where they lie outside of it).
/// @param wrap `BuiltProblem::wrap`, which is written for `wrap: auto`: a run goes on with the wrap that it began with.
std::string resolved_case(const Case& the_case, const std::filesystem::path& folder, const std::string& wrap = "");
/// What a text that `resolved_case` gave states of the wrap as a map; empty: nothing.
std::string stated_wrap(const std::string& resolved);

/// Files that the case names (not the programs), as seen from the working directory, by the path of their key; with
/// `optimize.start_from` the design that it begins with.
std::vector<std::pair<std::string, std::filesystem::path>> files_of(const Case& the_case);

/// Keys, as "optimize.method", in which two texts that `resolved_case` gave differ; sorted.
/// @throws CaseError where one of them is no YAML.
std::vector<std::string> changed_keys(const std::string& before, const std::string& now);
/// Whether a run that continues may have another value: budget, output, timeouts.
bool may_change(const std::string& key);

}  // namespace strake
