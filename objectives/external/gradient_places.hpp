#pragma once
#include "core/mesh/mesh.hpp"

#include <cstdint>
#include <vector>

namespace strake {

/// Places of the rows of a gradient file.
struct GradientPlaces {
    Points at;                           ///< n x 3, as given to the program
    std::vector<std::int64_t> ids = {};  ///< the program's numbers; empty: counted from 0
    Points normals = {};                 ///< n x 3, unit, outward: for files with the normal component only
    double tolerance = 0;                ///< rows with coordinates match the nearest place within it
    const char* whole = "the surface";   ///< for messages
    const char* one = "vertex";
    const char* many = "vertices";
};
GradientPlaces vertices_of(const TriMesh& surface, double tolerance);

}  // namespace strake
