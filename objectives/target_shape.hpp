#pragma once
#include "objectives/quantity.hpp"

/// Distance to a wanted shape, mean square over the start's area: J = sum a_k |r_k|^2 / sum a_k, length squared; a_k
/// the start's vertex areas. Residuals are r_k sqrt(a_k / sum a), so that J is their sum of squares.
namespace strake {

/// Vertex k against vertex k of `target`. @throws InvalidInput when counts or triangles differ.
Quantity target_shape_same(const std::string& name, const TriMesh& start, const TriMesh& target);

/// Vertex k against the closest point of `target` (any triangulation). The derivative of r = v - q(v) is the
/// projector on what the closest face, edge or vertex leaves: exact wherever the closest point is unique.
Quantity target_shape_closest(const std::string& name, const TriMesh& start, const TriMesh& target);

}  // namespace strake
