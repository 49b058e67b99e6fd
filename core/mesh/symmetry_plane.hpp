#pragma once
#include <Eigen/Core>

namespace strake {

/// The plane in which half a body is mirrored.
struct SymmetryPlane {
    Eigen::Vector3d normal;  ///< unit
    double offset = 0;       ///< the plane is normal . x = offset
};

}  // namespace strake
