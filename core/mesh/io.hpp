#pragma once
#include "core/mesh/mesh.hpp"

#include <filesystem>
#include <vector>

/// Surface files. Coordinates are kept in double precision, vertices and triangles in the order of the file;
/// only SU2 sorts its triangles by group, and only STL, which has no shared vertices, is welded (bit-equal coordinates,
/// in the order of first appearance).
namespace strake {

enum class SurfaceFormat { stl_binary, stl_ascii, obj, ply_ascii, ply_binary, off, tri, vtk, vtp, su2, gmsh, nastran };

/// What a reader saw besides the surface itself.
struct SurfaceFile {
    TriMesh mesh;
    SurfaceFormat format = SurfaceFormat::stl_binary;  ///< of the file; big-endian PLY reads as ply_binary
    int file_vertices = 0;                             ///< before welding
};

/// Reads STL (ASCII, binary), OBJ, PLY (ASCII, both binaries), OFF, Cart3D .tri (text, unformatted), legacy VTK
/// polygons
/// (.vtk, text and binary), XML ones (.vtp), the markers of an SU2 mesh (.su2), Gmsh (.msh, 2.x and 4.1, text and
/// binary) or NASTRAN bulk data (.nas, .bdf, .dat), each also packed by gzip (.stl.gz), by extension and content. Of
/// meshes that hold volumes, too, the vertices that no triangle names are left out. Polygons are cut into fans from
/// their first corner, and where such a fan would be folded (polygons that are not convex) into ears.
/// @throws InputError `FILE:LINE: …` or `FILE: byte N …`, for whatever is not a finite, indexed surface.
SurfaceFile read_surface(const std::filesystem::path& file);

/// Areas and volumes of coordinates beyond 1e100 are no numbers any more. @throws InputError with the vertex and the
/// limit.
void check_coordinates(const std::filesystem::path& file, const TriMesh& mesh);

/// What `write_surface` would write. @throws OutputError beyond single precision where the format has no more.
std::string surface_bytes(const TriMesh& mesh, SurfaceFormat format, const std::string& name_for_messages);

/// Writes atomically (temporary file beside it, fsync, rename), 17 digits or binary doubles where the format has them.
/// @throws OutputError with path and the system's reason.
void write_surface(const std::filesystem::path& file, const TriMesh& mesh, SurfaceFormat format);

/// The format that a name's extension asks for (.stl and .ply: binary). @throws InvalidInput
/// listing the known ones.
SurfaceFormat format_of(const std::filesystem::path& file);
/// "stl", "stl-ascii", "obj", "ply", "ply-ascii", "off", "tri", "vtk", "vtp", "su2", "msh", "nastran". @throws
/// InvalidInput.
SurfaceFormat format_named(const std::string& name);
std::string name_of(SurfaceFormat format);       ///< as `format_named` knows it
std::string extension_of(SurfaceFormat format);  ///< with the dot
bool keeps_parts(SurfaceFormat format);          ///< whether a file of it holds which triangles belong to which part

/// Writes bytes so that readers see the old file or the whole new one. @throws OutputError.
void write_atomically(const std::filesystem::path& file, const std::string& bytes);

}  // namespace strake
