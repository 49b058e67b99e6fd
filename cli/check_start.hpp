#pragma once
#include "cases/case.hpp"

namespace strake::cli {

/// `strake check --evaluate`: one evaluation at the start design, told in words or as JSON.
/// @param out folder that keeps the evaluation's files; empty: they go away unless something fails.
/// @throws ExitStatus where there is no value or no gradient.
void check_start_of(Case the_case, const std::string& out, bool json);

}  // namespace strake::cli
