#pragma once
#include "cases/build_problem.hpp"

namespace strake::cli {

/// build_problem(), which the first INT, TERM or HUP ends where it remeshes: status 75 (`interrupted`).
BuiltProblem build_case(Case the_case, Purpose purpose = Purpose::any);

}  // namespace strake::cli
