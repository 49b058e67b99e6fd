#pragma once
#include "casefile/model/case.hpp"

namespace strake::cli {

/// `strake check --evaluate`: one evaluation at the start design, reported in words or as JSON.
/// @param out folder that keeps the evaluation's files; empty: they are removed unless something fails.
/// @throws ExitStatus if a value or a gradient is missing.
void check_start_of(Case the_case, const std::string& out, bool json);

}  // namespace strake::cli
