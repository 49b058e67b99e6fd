#pragma once
#include "core/mesh/mesh.hpp"

#include <string>

namespace strake {

/// dJ/dv (n x 3) from the text of a gradient file: rows `index,dJ/dx,dJ/dy,dJ/dz` (0-based vertex of `surface`) or
/// `x,y,z,dJ/dx,dJ/dy,dJ/dz` (matched to the nearest vertex within `tolerance`), one per vertex in any order; one
/// header line, empty lines and lines that start with # are skipped. `name` is the file's, for messages.
/// @throws Refused: unreadable (line: what, expected), not_finite, wrong_count (have, want; a vertex twice; none near).
Points parse_gradient(const std::string& bytes, const std::string& name, const TriMesh& surface, double tolerance);

}  // namespace strake
