#pragma once
#include "core/remesh/base_surface.hpp"

namespace strake {

/// Prepares the input of remeshing. @param angle of creases, radians @param edge_length target; 0: the mean edge length
/// of the input
/// @param frozen per triangle of `tri`: it stays unchanged; empty: none
/// @throws InvalidInput when the area is zero or not finite.
BaseSurface base_surface(const TriMesh& mesh, double angle, double edge_length, const std::vector<char>& frozen);

}  // namespace strake
