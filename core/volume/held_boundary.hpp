#pragma once
#include "core/volume/volume_mesh.hpp"

namespace strake {

/// Per point: a factor for its displacement that keeps parts of the boundary in place. 0 on these parts, 1 on the
/// moving surface, smoothstep(d / (d + s)) between, d the distance from the parts and s from the surface. A point on
/// both moves with the surface.
/// @param distances of the points from the surface, P.
/// @throws InvalidInput for an unknown name, listing the known ones.
Eigen::VectorXd hold_factors(const VolumeMesh& mesh, const std::vector<std::string>& names,
                             const Eigen::VectorXd& distances);

}  // namespace strake
