#pragma once
#include "optimize/nlp/surrogate/allowed_designs.hpp"

/// A way back to equations and exact limits. Internal to the search by models.
namespace strake {

/// The design of the shortest step from x, in the metric, to where the equations hold and the other constraints and the
/// limit of motion are kept, to first order; at most `radius` away: beyond, slopes say too little. Minima of models
/// miss equations by what the models err by; without this no design meets one before steps are as short as that allows.
/// @param at at x, with gradients by the models @param allowed looks from x
Eigen::VectorXd restored(const NonlinearProgram& program, const std::vector<int>& free, const Eigen::VectorXd& x,
                         const Evaluation& at, double radius, AllowedDesigns& allowed);

}  // namespace strake
