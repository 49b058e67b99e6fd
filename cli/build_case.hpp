#pragma once
#include "casefile/build/build_problem.hpp"

#include <CLI/CLI.hpp>

namespace strake::cli {

/// build_problem(); the first INT, TERM or HUP ends it while it remeshes: status 75 (`interrupted`).
BuiltProblem build_case(Case the_case, Purpose purpose = Purpose::any);

/// `--set KEY=VALUE`, for commands that read a case.
void add_set_option(CLI::App& command, std::vector<std::string>& settings);

}  // namespace strake::cli
