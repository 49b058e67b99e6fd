#pragma once
#include "core/mesh/mesh.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace strake {

/// What the rows of a gradient file belong to.
struct GradientPlaces {
    Points at;                           ///< n x 3, as handed over
    std::vector<std::int64_t> ids = {};  ///< the program's own number of each; empty: counted from 0
    Points normals = {};                 ///< n x 3, unit, outward: for files that have the normal component only
    double tolerance = 0;                ///< rows with coordinates belong to the nearest place within it
    const char* whole = "the surface";   ///< for messages
    const char* one = "vertex";
    const char* many = "vertices";
};
GradientPlaces vertices_of(const TriMesh& surface, double tolerance);

/// Gradients (n x 3) from the bytes of a gradient file, one row for each place:
/// - CSV: rows `index,dJ/dx,dJ/dy,dJ/dz` or `x,y,z,dJ/dx,dJ/dy,dJ/dz` in any order; one header line, empty lines and
///   lines that start with # are skipped;
/// - CSV with a header that names `Sensitivity_x`, `_y` and `_z` (SU2), or FIELD_x, …, in any column, and `PointID`, or
///   x, y and z, or all of these; with `Surface_Sensitivity` alone, -S n (SU2: S is positive into the body);
/// - .npy: shape (n, 3), in the order of the places;
/// - .vtp: a point field of vectors, FIELD or the only one.
/// `name` is the file's, for messages; `field` may be empty.
/// @throws Refused: unreadable (line: what, expected), missing_key (field), not_finite, wrong_count (have, want; a
/// place twice; none near).
Points parse_gradient(const std::string& bytes, const std::string& name, const GradientPlaces& places,
                      const std::string& field = "");

/// The same for the vertices of `surface`.
Points parse_gradient(const std::string& bytes, const std::string& name, const TriMesh& surface, double tolerance);

}  // namespace strake
