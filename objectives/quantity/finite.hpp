#pragma once
#include "objectives/quantity/quantity.hpp"

/// Checks of every quantity: inputs and results are finite.
namespace strake {

/// A failure of kind `undefined` naming the first vertex with a coordinate that is not finite; nothing when all are.
std::optional<Failure> vertices_finite(const std::string& quantity, const TriMesh& surface);

/// One value and, on request, its sensitivities (else 0 rows); checked_quantity or `finite` checks both.
QuantityResult one_value(double value, Points dJ_dv);

/// `result`, or a failure of kind `undefined` that says which of its values or sensitivities is not finite.
QuantityResult finite(const std::vector<std::string>& names, QuantityResult result);

/// A quantity for surfaces with the counts of `start`. `measure` sees finite surfaces only; its InvalidInput, and any
/// value or sensitivity that is not finite, becomes a failure of kind `undefined`.
Quantity checked_quantity(const std::string& name, std::vector<std::string> names, const TriMesh& start,
                          std::function<QuantityResult(const QuantityRequest&)> measure);

/// @throws InvalidInput when the counts of `surface` differ from those of the quantity's surface.
void require_same_counts(const std::string& quantity, const TriMesh& surface, int num_vertices, int num_triangles);

}  // namespace strake
