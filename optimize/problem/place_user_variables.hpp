#pragma once
#include "optimize/problem/problem.hpp"

/// Where the rigid motions of the user's variables act.
namespace strake {

struct PlacedVariables {
    std::vector<RigidMotion> motions;      ///< at rest, about their points; variables of the same triangles share one
    std::vector<int> motion;               ///< per variable: its number behind `first`; -1: a load
    std::vector<std::vector<int>> pinned;  ///< per variable: the triangles that follow its motion
    std::vector<std::string> warnings;
};

/// @throws InvalidInput: a change of a wing moves a vertex of these triangles, which are held.
void refuse_held(const PlanformMotion& planform, const TriMesh& surface, const std::vector<int>& triangles,
                 const std::string& what);

/// Pins the triangles of the motions among `Parameters::user_variables`, motion number k as k + 1 in `pin`.
/// @param first number of motions that are there already (the given strains).
/// @throws InvalidInput: names twice or empty; triangles that do not exist, are held or follow two motions; a load
/// without effect; motions of the same triangles about different points.
PlacedVariables place_user_variables(const Problem& problem, int first, std::vector<int>& pin);

}  // namespace strake
