#pragma once
#include "core/mesh/io.hpp"

#include <map>
#include <span>
#include <string_view>

/// What the readers and writers of the single formats share. Internal: programs use io.hpp.
namespace strake::formats {

/// Vertices and polygons as a reader meets them.
struct SurfaceBuilder {
    std::vector<double> coordinates;
    std::vector<int> corners;  ///< three a triangle
    std::vector<int> group;
    std::vector<std::string> group_names;

    int num_vertices() const { return static_cast<int>(coordinates.size() / 3); }
    /// Number of the group of that name, a new one at first sight.
    int group_number(const std::string& name);
    /// Cuts a polygon (at least 3 corners) into triangles of the given group; -1: none.
    void add_polygon(std::span<const int> polygon, int group_of_polygon = -1);
    /// Gives the data away. @throws InputError without triangles.
    SurfaceFile finish(const std::string& name, SurfaceFormat format);

private:
    std::map<std::string, int> known_;
};

/// Readers: `bytes` of the file, `name` for messages.
SurfaceFile read_stl(std::string_view bytes, const std::string& name);
SurfaceFile read_obj(std::string_view bytes, const std::string& name);
SurfaceFile read_ply(std::string_view bytes, const std::string& name);
SurfaceFile read_off(std::string_view bytes, const std::string& name);
SurfaceFile read_tri(std::string_view bytes, const std::string& name);
SurfaceFile read_vtp(std::string_view bytes, const std::string& name);

/// Writers: the whole file as bytes. Numbers do not go through streams, which follow the program's locale.
std::string stl_binary(const TriMesh& mesh, const std::string& name);  ///< @throws OutputError beyond single precision
std::string stl_ascii(const TriMesh& mesh);
std::string obj(const TriMesh& mesh);
std::string ply(const TriMesh& mesh, bool binary);
std::string off(const TriMesh& mesh);
std::string tri(const TriMesh& mesh);
std::string vtp(const TriMesh& mesh);  ///< parts as numbers in the cell field "part"

void append(std::string& out, double value);  ///< the shortest text that reads back to the same bits
void append(std::string& out, int value);
void append_counts(std::string& out, const TriMesh& mesh);  ///< one line: vertices, triangles
/// One line "a b c\n" behind `lead`.
void append_row(std::string& out, std::string_view lead, const double* row);
void append_row(std::string& out, std::string_view lead, const int* row, int offset);
/// A group's name as one line of text: control characters become blanks.
std::string one_line(const std::string& name);

}  // namespace strake::formats
