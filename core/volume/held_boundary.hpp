#pragma once
#include "core/volume/volume_mesh.hpp"

namespace strake {

/// Per point a factor for its displacement that lets parts of the boundary stay where they are: 0 on them, 1 on the
/// surface that moves, smoothstep(d / (d + s)) between, d the distance from the parts and s that from the surface. A
/// point on both goes with the surface.
/// @param distances of the points from the surface, P.
/// @throws InvalidInput for a name that the mesh has not, with the names that it has.
Eigen::VectorXd hold_factors(const VolumeMesh& mesh, const std::vector<std::string>& names,
                             const Eigen::VectorXd& distances);

}  // namespace strake
