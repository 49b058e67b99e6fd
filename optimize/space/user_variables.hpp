#pragma once
#include "optimize/space/rest_facts.hpp"

/// Design variables that the user states (`Parameters::user_variables`). Each is one degree of freedom, behind those of
/// the patches: the factor on its traction or on its motion. Internal.
namespace strake {

/// @param values per user variable.
void add_user_traction(const RestFacts& rest, const Eigen::VectorXd& values, Points& traction);
void add_user_motions(const RestFacts& rest, const Eigen::VectorXd& values, std::vector<RigidMotion>& motions);

/// dJ/d(degree of freedom) of all of them, added to `gradient` from `first` on. @param motions at the design.
void add_user_gradient(const RestFacts& rest, int first, const std::vector<RigidMotion>& motions,
                       const ShellSensitivities& sensitivities, Eigen::VectorXd& gradient);

/// dJ/d(traction) of a triangle.
Eigen::RowVector3d traction_gradient(const RestFacts& rest, const Points& dJ_dF, int triangle);

}  // namespace strake
