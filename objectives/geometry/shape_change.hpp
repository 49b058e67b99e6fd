#pragma once
#include "core/mesh/symmetry_plane.hpp"
#include "objectives/quantity/quantity.hpp"

/// Deviation of the surface from the start, from a plane or from symmetry: mean squares, zero where there is none,
/// weighted by the start. `region`: marks per triangle; empty: the whole surface.
namespace strake {

/// sum w_k |v_k - v_k(start)|^2, w_k the vertex's share of the start's area (of the marked triangles). length^2.
Quantity displacement(const std::string& name, const TriMesh& start, const std::vector<char>& region = {});

/// sum w_e (theta_e - theta_e(start))^2 over the edges of dihedral |theta| >= `angle` at the start, w_e the edge's
/// share of their length; radians^2. Theta is signed (a ridge is positive), differences are taken within (-pi, pi].
/// @throws InvalidInput when there is no such edge, or for an angle outside of (0, pi).
Quantity creases(const std::string& name, const TriMesh& start, double angle, const std::vector<char>& region = {});

/// Least mean square distance of the region's vertices from a plane, weights as for `displacement`; length^2. Smooth
/// unless two directions are equally flat. @throws InvalidInput for fewer than four vertices.
Quantity planarity(const std::string& name, const TriMesh& start, const std::vector<char>& region = {});

/// sum w_k |R v_k - q_k|^2, R the reflection in the plane and q_k the point of the surface closest to it at the start
/// (in a triangle, at fixed barycentric coordinates); length^2. Quadratic in the vertices. A symmetric start with an
/// asymmetric triangulation has the error of its triangulation.
Quantity symmetry_error(const std::string& name, const TriMesh& start, const SymmetryPlane& plane);

}  // namespace strake
