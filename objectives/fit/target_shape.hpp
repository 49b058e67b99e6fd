#pragma once
#include "objectives/quantity/quantity.hpp"

/// Distance to a target shape, mean square over the start's area: J = sum a_k |r_k|^2 / sum a_k, length squared; a_k
/// the start's vertex areas. Residuals are r_k sqrt(a_k / sum a), so that J is their sum of squares and
/// dJ/dv_k = 2 r_k^T dr_k/dv_k. On a surface that is not finite, `evaluate` fails with kind `undefined` and `residuals`
/// throws InvalidInput.
namespace strake {

/// Distance of vertex k to vertex k of `target`. @throws InvalidInput when counts or triangles differ, or the start has
/// zero area.
Quantity target_shape_same(const std::string& name, const TriMesh& start, const TriMesh& target);

/// Distance of vertex k to the closest point of `target` (any triangulation). The derivative of r = v - q(v) is n n^T
/// for a closest face, I - e e^T for an edge and I for a vertex: exact wherever the closest point is unique. @throws
/// InvalidInput for a target without triangles or a start without area.
Quantity target_shape_closest(const std::string& name, const TriMesh& start, const TriMesh& target);

}  // namespace strake
