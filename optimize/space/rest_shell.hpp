#pragma once
#include "optimize/space/design_space.hpp"

namespace strake {

/// The shell at rest with the pins of the space; null where the problem has none. Springs and pins belong to the rest
/// state, given loads and motions do not. @throws UnheldPart, SolverError.
std::unique_ptr<PrimoShell> shell_at_rest(const DesignSpace& space);

}  // namespace strake
