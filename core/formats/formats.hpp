#pragma once
#include "core/formats/surface_file.hpp"

#include <map>
#include <span>
#include <string_view>

/// Shared by the readers and writers of the formats. Internal: programs use io.hpp.
namespace strake::formats {

/// Collects vertices and polygons in the order of the file.
struct SurfaceBuilder {
    std::vector<double> coordinates;
    std::vector<int> corners;  ///< three a triangle
    std::vector<int> group;
    std::vector<std::string> group_names;

    int num_vertices() const { return static_cast<int>(coordinates.size() / 3); }
    /// Number of the group of that name; adds a new one.
    int group_number(const std::string& name);
    /// Cuts a polygon (at least 3 corners) into a fan of triangles of the given group; -1: none.
    void add_polygon(std::span<const int> polygon, int group_of_polygon = -1);
    /// The same surface without unused vertices; the others keep their order.
    SurfaceBuilder with_used_vertices_only() const;
    /// Moves the data out. Folded fans of non-convex polygons are triangulated again, now that all vertices are known.
    /// @throws InputError without triangles.
    SurfaceFile finish(const std::string& name, SurfaceFormat format);

private:
    /// Of a polygon of more than three corners.
    struct Fan {
        std::size_t first_triangle;
        int corners;
    };
    void cut_again(const Fan& fan);
    std::map<std::string, int> known_;
    std::vector<Fan> fans_;
};

/// Readers: `bytes` of the file, `name` for messages.
SurfaceFile read_stl(std::string_view bytes, const std::string& name);
SurfaceFile read_obj(std::string_view bytes, const std::string& name);
SurfaceFile read_ply(std::string_view bytes, const std::string& name);
SurfaceFile read_off(std::string_view bytes, const std::string& name);
SurfaceFile read_tri(std::string_view bytes, const std::string& name);
SurfaceFile read_su2(std::string_view bytes, const std::string& name);
SurfaceFile read_gmsh(std::string_view bytes, const std::string& name);
SurfaceFile read_nastran(std::string_view bytes, const std::string& name);
SurfaceFile read_vtk(std::string_view bytes, const std::string& name);
SurfaceFile read_vtp(std::string_view bytes, const std::string& name);
/// Decompresses gzip data; refuses more than a thousand times the packed size. @throws InputError.
std::string unpacked(std::string_view bytes, const std::string& name);

/// Writers: the whole file as bytes. Numbers avoid streams, which follow the program's locale.
std::string stl_binary(const TriMesh& mesh, const std::string& name);  ///< @throws OutputError beyond single precision
std::string stl_ascii(const TriMesh& mesh);
std::string obj(const TriMesh& mesh);
std::string ply(const TriMesh& mesh, bool binary);
std::string off(const TriMesh& mesh);
std::string tri(const TriMesh& mesh);
std::string su2(const TriMesh& mesh);
std::string gmsh(const TriMesh& mesh);     ///< version 4.1
std::string nastran(const TriMesh& mesh);  ///< GRID* (16 columns) and CTRIA3
std::string vtk(const TriMesh& mesh);      ///< legacy polygons, binary
std::string vtp(const TriMesh& mesh);      ///< parts: cell field "part", their names "part_names"
/// Groups as positive numbers: their names where all are such numbers, else counted from 1.
std::vector<std::string> component_numbers(const TriMesh& mesh);
/// Triangles of each group in their order; one part where there are no groups.
std::vector<std::vector<int>> triangles_by_group(const TriMesh& mesh);

void append(std::string& out, double value);  ///< the shortest text that reads back to the same bits
void append(std::string& out, int value);
void append_counts(std::string& out, const TriMesh& mesh);  ///< one line: vertices, triangles
/// One line "a b c\n" after `lead`.
void append_row(std::string& out, std::string_view lead, const double* row);
void append_row(std::string& out, std::string_view lead, const int* row, int offset);
/// A group's name as one line of text: control characters become blanks.
std::string one_line(const std::string& name);
std::string one_word(const std::string& name);  ///< the same without blanks

}  // namespace strake::formats
