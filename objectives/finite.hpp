#pragma once
#include "objectives/quantity.hpp"

/// What every quantity does before it answers: nothing that is not finite goes in or out.
namespace strake {

/// A failure of kind `undefined` naming the first vertex with a coordinate that is not finite; nothing when all are.
std::optional<Failure> vertices_finite(const std::string& quantity, const TriMesh& surface);

/// One value and, where asked for, its sensitivities (else 0 rows); checked_quantity or `finite` tests both.
QuantityResult one_value(double value, Points dJ_dv);

/// `result`, or a failure of kind `undefined` that says which of its values or sensitivities is not finite.
QuantityResult finite(const std::vector<std::string>& names, QuantityResult result);

/// A quantity of the surfaces that have the counts of `start`: `measure` is asked about finite ones only, what it
/// throws as InvalidInput is a failure of kind `undefined`, and so is a value or sensitivity that is not finite.
Quantity checked_quantity(const std::string& name, std::vector<std::string> names, const TriMesh& start,
                          std::function<QuantityResult(const QuantityRequest&)> measure);

/// @throws InvalidInput when `surface` has not the counts of the surface the quantity was made for.
void require_same_counts(const std::string& quantity, const TriMesh& surface, int num_vertices, int num_triangles);

}  // namespace strake
