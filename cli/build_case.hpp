#pragma once
#include "casefile/build/build_problem.hpp"

namespace strake::cli {

/// build_problem(); the first INT, TERM or HUP ends it while it remeshes: status 75 (`interrupted`).
BuiltProblem build_case(Case the_case, Purpose purpose = Purpose::any);

}  // namespace strake::cli
