#pragma once
#include "core/mesh/mesh.hpp"

namespace strake {

enum class SurfaceFormat { stl_binary, stl_ascii, obj, ply_ascii, ply_binary, off, tri, vtk, vtp, su2, gmsh, nastran };

/// A surface with facts about its file.
struct SurfaceFile {
    TriMesh mesh;
    SurfaceFormat format = SurfaceFormat::stl_binary;  ///< of the file; big-endian PLY reads as ply_binary
    int file_vertices = 0;                             ///< before welding
};

}  // namespace strake
