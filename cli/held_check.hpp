#pragma once
#include "cases/build_problem.hpp"

namespace strake::cli {

/// A part that nothing holds would stop the run: told here, with the case file's name. @return the shell's warnings.
/// @throws UnheldPart.
std::vector<std::string> check_shell(const Case& the_case, const Problem& problem);

}  // namespace strake::cli
