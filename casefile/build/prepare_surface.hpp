#pragma once
#include "casefile/model/case.hpp"
#include "core/formats/io.hpp"

namespace strake {

/// The surface that a case deforms: read, repaired and remeshed as the case says.
struct PreparedSurface {
    TriMesh mesh;
    SurfaceFormat format = SurfaceFormat::stl_binary;  ///< of the file
    int file_triangles = 0;
    bool is_changed = false;  ///< repair or remesh is stated
    bool is_remeshed = false;
    std::vector<int> source_triangle;  ///< of a surface that was repaired but not remeshed: number in the file, -1: new
    std::string repairs_csv;           ///< every single repair, as `strake repair --list`
    std::vector<std::string> notes;    ///< what was done, in words
    std::vector<std::string> warnings;  ///< what is still wrong
};

/// @throws InputError (surface file); CaseError where options do not fit the surface; Interrupted where
/// `Case::stop_wanted` ends the remeshing.
PreparedSurface prepare_surface(const Case& the_case);

}  // namespace strake
