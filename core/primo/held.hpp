#pragma once
#include "core/primo/rest_state.hpp"

namespace strake {

/// Throws UnheldPart when a connected part of the shell can move rigidly: no pinned prism, and neither springs nor the
/// symmetry plane stop all six motions. The message names the part by its triangles, counts the free motions and says
/// what to do.
void check_held(const RestState& rest, const Eigen::VectorXd& spring);

}  // namespace strake
