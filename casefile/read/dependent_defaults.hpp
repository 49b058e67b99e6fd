#pragma once
#include "casefile/yaml/value.hpp"

#include <filesystem>

namespace strake {

/// Adds to the tree of a case, before it is checked and read, the defaults that depend on other keys; all of them are
/// about `parameters`: without a shell all displacement fields and no variables of patches; and in a case that says
/// nothing of its variables, fields in front of the patches of a fit, of a search by values alone, whose patches have
/// normal loads, and where `optimize.start_from` has them. What the case states is never changed, and what is no map is
/// left to the checks.
/// @param dir that paths are relative to
/// @param is_new false: the case of a run that continues, which states the fields it began with
void set_dependent_defaults(Value& root, const std::filesystem::path& dir, bool is_new);

/// In place of the defaults of a new run: the fields and kinds of variables of one that has begun, or that it has none.
/// @param begun the case that it began with, as written
void set_fields_of_run(Value& root, const std::string& begun);

}  // namespace strake
