#pragma once
#include "core/patches/hierarchy.hpp"

namespace strake {

/// Names the patches of `level` after their parents in `above` (scheme: hierarchy.hpp).
void name_children(const TriMesh& mesh, const Eigen::VectorXd& areas, const PatchLevel& above, PatchLevel& level);

}  // namespace strake
