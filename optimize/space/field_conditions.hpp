#pragma once
#include "core/fields/displacement_fields.hpp"
#include "optimize/problem/problem.hpp"

namespace strake {

/// What the displacement fields of a problem have to respect. Held is what is fixed, what given strains and user
/// variables move, what is frozen, and what is not under `on`; attached parts are not: they go with their hosts.
/// @param surface of the problem, which may not have it yet
/// @param on per triangle: may be moved by fields; empty: all
FieldConditions field_conditions(const Problem& problem, const TriMesh& surface, const std::vector<char>& on);

/// The same of a whole problem.
FieldConditions field_conditions(const Problem& problem);

}  // namespace strake
