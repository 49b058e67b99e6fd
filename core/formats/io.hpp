#pragma once
#include "core/formats/surface_file.hpp"

#include <filesystem>
#include <vector>

/// Surface files. Coordinates are kept in double precision, vertices and triangles in the order of the file;
/// only SU2 sorts its triangles by group, and only STL, which has no shared vertices, is welded (bit-equal coordinates,
/// in the order of first appearance).
namespace strake {

/// Reads STL (ASCII, binary), OBJ, PLY (ASCII, both binaries), OFF, Cart3D .tri (text, unformatted), VTK polygons in
/// legacy (.vtk, text and binary) and XML form (.vtp), the markers of an SU2 mesh (.su2), Gmsh (.msh, 2.x and 4.1, text
/// and binary) or NASTRAN bulk data (.nas, .bdf, .dat), each also compressed by gzip (.stl.gz), by extension and
/// content. Unused vertices of volume meshes are dropped. Polygons are cut into fans from their first corner, or into
/// ears where the fan would fold (non-convex polygons).
/// @throws InputError `FILE:LINE: …` or `FILE: byte N …`, for anything but a finite, indexed surface.
SurfaceFile read_surface(const std::filesystem::path& file);

/// Refuses coordinates beyond 1e100, whose areas and volumes overflow. @throws InputError with the vertex and the
/// limit.
void check_coordinates(const std::filesystem::path& file, const TriMesh& mesh);

/// The bytes of `write_surface`. @throws OutputError beyond the range of a single-precision format.
std::string surface_bytes(const TriMesh& mesh, SurfaceFormat format, const std::string& name_for_messages);

/// Writes atomically (temporary file beside it, fsync, rename), with 17 digits or binary doubles where the format
/// allows.
/// @throws OutputError with path and the system's reason.
void write_surface(const std::filesystem::path& file, const TriMesh& mesh, SurfaceFormat format);

/// The format of a file name's extension (.stl and .ply: binary). @throws InvalidInput
/// listing the known ones.
SurfaceFormat format_of(const std::filesystem::path& file);
/// "stl", "stl-ascii", "obj", "ply", "ply-ascii", "off", "tri", "vtk", "vtp", "su2", "msh", "nastran". @throws
/// InvalidInput.
SurfaceFormat format_named(const std::string& name);
std::string name_of(SurfaceFormat format);       ///< its name in `format_named`
std::string extension_of(SurfaceFormat format);  ///< with the dot
bool keeps_parts(SurfaceFormat format);          ///< whether its files store the part of each triangle

}  // namespace strake
