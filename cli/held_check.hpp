#pragma once
#include "casefile/build/build_problem.hpp"

namespace strake::cli {

/// Refuses a part that nothing holds, which would stop the run, and names the case file. @return the shell's warnings.
/// @throws UnheldPart.
std::vector<std::string> check_shell(const Case& the_case, const Problem& problem);

}  // namespace strake::cli
