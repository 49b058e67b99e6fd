#pragma once
#include <string>

namespace strake {

/// How to solve systems with the Hessian. `multigrid` needs a quarter of the memory and is faster for a few solves with
/// many prisms; `direct` keeps a factor that makes further solves cheap.
enum class LinearSolver { automatic, direct, multigrid };
std::string to_string(LinearSolver solver);

}  // namespace strake
