#pragma once
#include "objectives/quantity.hpp"

/// Distance to a wanted shape, mean square over the start's area: J = sum a_k |r_k|^2 / sum a_k, length squared; a_k
/// the start's vertex areas. Residuals are r_k sqrt(a_k / sum a), so that J is their sum of squares and
/// dJ/dv_k = 2 r_k^T dr_k/dv_k. `evaluate` gives a failure of kind `undefined` for a surface that is not finite;
/// `residuals` throws InvalidInput for it.
namespace strake {

/// Vertex k against vertex k of `target`. @throws InvalidInput when counts or triangles differ, or the start has no
/// area.
Quantity target_shape_same(const std::string& name, const TriMesh& start, const TriMesh& target);

/// Vertex k against the closest point of `target` (any triangulation). The derivative of r = v - q(v) is the
/// projector on what the closest face (n n^T), edge (I - e e^T) or vertex (I) leaves: exact wherever the closest
/// point is unique. @throws InvalidInput for a target without triangles or a start without area.
Quantity target_shape_closest(const std::string& name, const TriMesh& start, const TriMesh& target);

}  // namespace strake
