#pragma once
#include "casefile/model/case.hpp"
#include "core/formats/io.hpp"

namespace strake {

/// The surface that a case deforms: read, repaired and remeshed as the case says.
struct PreparedSurface {
    TriMesh mesh;
    SurfaceFormat format = SurfaceFormat::stl_binary;  ///< of the file
    int file_triangles = 0;
    bool is_changed = false;  ///< repair, remesh or symmetry.snap is stated
    bool is_remeshed = false;
    std::vector<int> source_triangle;  ///< of a surface that was repaired but not remeshed: number in the file, -1: new
    std::string repairs_csv;           ///< every single repair, as `strake repair --list`
    std::vector<std::string> notes;    ///< what was done, in words
    std::vector<std::string> warnings;  ///< what is still wrong
};

struct Snapped {
    int vertices = 0;
    double farthest = 0;  ///< that one of them has moved
};
/// Moves open edges with both ends within `reach` of the plane onto it.
Snapped snap_open_edges(const SymmetryPlane& plane, double reach, TriMesh& mesh);

/// @throws InputError (surface file); CaseError where options do not fit the surface; Interrupted where
/// `Case::stop_wanted` ends the remeshing.
PreparedSurface prepare_surface(const Case& the_case);

}  // namespace strake
