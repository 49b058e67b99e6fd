#pragma once
#include "casefile/yaml/value.hpp"

#include <filesystem>
#include <string>

namespace strake {

/// Adds to the tree of a case, before it is checked and read, the defaults that depend on other keys; all of them are
/// about `parameters`: without a shell all displacement fields and no variables of patches; and in a case that says
/// nothing of its variables, fields in front of the patches of a fit, of a short search by values alone, and where
/// `optimize.start_from` has them. What the case states is never changed, and what is no map is left to the checks.
/// @param dir that paths are relative to
/// @param is_new false: the case of a run that continues, which states the fields it began with
void set_dependent_defaults(Value& root, const std::filesystem::path& dir, bool is_new);

/// The same for the file of a run that has begun: what says nothing of its variables has the fields of that run, or
/// none, whatever its own default is by now. @param begun the case as the run's folder has it
void set_defaults_of_run(Value& root, const std::string& begun);

}  // namespace strake
