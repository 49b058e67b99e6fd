#pragma once
#include "core/primo/shell.hpp"
#include "optimize/space/design_space.hpp"

/// What a mirror image of the body makes of the motions of its variables.
namespace strake {

/// size() x size(), symmetric, by the linear response at rest, per unit of each variable; what is no variable of the
/// shape is its own image.
struct MotionImages {
    Eigen::MatrixXd motion;  ///< ij: mean over the surface of motion i times motion j, units of the model squared
    Eigen::MatrixXd image;   ///< the same with the mirror image of motion j
};

/// Between vertices motions are linear: weights of the six next to each image, on its side of a thin body (locally
/// linear embedding, Roweis and Saul 2000).
/// @pre all variables of the shape are loads or fields; the surface is its own image in the plane
MotionImages motion_images(const DesignSpace& space, const SymmetryPlane& plane);

}  // namespace strake
