#pragma once
#include "objectives/external/gradient_places.hpp"

#include <string>

/// The gradient files of a program, to derivatives by the surface's vertices. Internal.
namespace strake {

/// Gradients (n x 3) from the bytes of a gradient file, one row per place:
/// - CSV: rows `index,dJ/dx,dJ/dy,dJ/dz` or `x,y,z,dJ/dx,dJ/dy,dJ/dz` in any order; one header line, empty lines and
///   lines that start with # are skipped;
/// - CSV with a header that names `Sensitivity_x`, `_y` and `_z` (SU2), or FIELD_x, …, in any column, and `PointID`, or
///   x, y and z, or all of these; with `Surface_Sensitivity` alone, -S n (SU2: S is positive into the body);
/// - .npy: shape (n, 3), in the order of the places;
/// - .vtp: a point field of vectors, FIELD or the only one.
/// `name` of the file for messages; `field` may be empty.
/// @throws Refused: unreadable (line: what, expected), missing_key (field), not_finite, wrong_count (have, want; a
/// place twice; none near).
Points parse_gradient(const std::string& bytes, const std::string& name, const GradientPlaces& places,
                      const std::string& field = "");

/// The same for the vertices of `surface`.
Points parse_gradient(const std::string& bytes, const std::string& name, const TriMesh& surface, double tolerance);

}  // namespace strake
