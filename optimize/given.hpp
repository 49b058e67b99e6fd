#pragma once
#include "optimize/design_space.hpp"

/// Design variables that the user states (`Parameters::given`). Each is one degree of freedom, behind those of the
/// patches: the factor on its traction or on its motion. Internal.
namespace strake {

/// Pins the triangles of given motions, each set under a motion of its own behind the given strains.
/// @throws InvalidInput: names twice or empty; triangles that do not exist, are held or follow two motions; a load
/// without effect; motions of the same triangles about different points.
void place_given(const Problem& problem, ShellSetup& setup);

/// One variable each, with unit 1 where none is stated.
void list_given(DesignSpace& space);

/// Degree of freedom of a given variable.
int given_freedom(const DesignSpace& space, int given);

/// @param values per given variable.
void add_given_traction(const RestFacts& rest, const Eigen::VectorXd& values, Points& traction);
void add_given_motions(const RestFacts& rest, const Eigen::VectorXd& values, std::vector<RigidMotion>& motions);

/// dJ/d(degree of freedom) of all of them, into `gradient` (num_freedoms()). @param motions at the design.
void add_given_gradient(const DesignSpace& space, const std::vector<RigidMotion>& motions,
                        const ShellSensitivities& sensitivities, Eigen::VectorXd& gradient);

/// dJ/d(traction) of a triangle.
Eigen::RowVector3d traction_gradient(const RestFacts& rest, const Points& dJ_dF, int triangle);

}  // namespace strake
