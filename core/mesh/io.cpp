#include "core/mesh/io.hpp"

#include "core/error.hpp"
#include "core/mesh/file.hpp"
#include "core/mesh/formats.hpp"

#include <charconv>
#include <cmath>
#include <limits>
#include <new>

namespace strake {
namespace formats {

int SurfaceBuilder::group_number(const std::string& name) {
    const auto [at, is_new] = known_.try_emplace(name, static_cast<int>(group_names.size()));
    if (is_new) group_names.push_back(name);
    return at->second;
}

void SurfaceBuilder::add_polygon(std::span<const int> polygon, int group_of_polygon) {
    for (std::size_t k = 2; k < polygon.size(); ++k) {
        corners.insert(corners.end(), {polygon[0], polygon[k - 1], polygon[k]});
        if (group_of_polygon >= 0) group.push_back(group_of_polygon);
    }
}

SurfaceFile SurfaceBuilder::finish(const std::string& name, SurfaceFormat format) {
    if (corners.empty()) throw InputError(text(name, ": holds no triangles (", num_vertices(), " vertices)"));
    if (corners.size() / 3 > static_cast<std::size_t>(std::numeric_limits<int>::max() / 3))
        throw InputError(text(name, ": ", corners.size() / 3, " triangles, at most 715827882 are possible"));
    SurfaceFile surface;
    surface.format = format;
    surface.file_vertices = num_vertices();
    surface.mesh.triangles =
        Eigen::Map<const Triangles>(corners.data(), static_cast<Eigen::Index>(corners.size() / 3), 3);
    std::vector<int>().swap(corners);
    surface.mesh.vertices = Eigen::Map<const Points>(coordinates.data(), surface.file_vertices, 3);
    surface.mesh.group = std::move(group);
    surface.mesh.group_names = std::move(group_names);
    return surface;
}

void append(std::string& out, double value) {
    char digits[32];
    out.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
}

void append(std::string& out, int value) {
    char digits[16];
    out.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
}

void append_counts(std::string& out, const TriMesh& mesh) {
    append(out, mesh.num_vertices());
    out += ' ';
    append(out, mesh.num_triangles());
    out += '\n';
}

void append_row(std::string& out, std::string_view lead, const double* row) {
    out += lead;
    for (int k = 0; k < 3; ++k) {
        append(out, row[k]);
        out += k < 2 ? ' ' : '\n';
    }
}

void append_row(std::string& out, std::string_view lead, const int* row, int offset) {
    out += lead;
    for (int k = 0; k < 3; ++k) {
        append(out, row[k] + offset);
        out += k < 2 ? ' ' : '\n';
    }
}

std::string one_line(const std::string& name) {
    std::string line = name;
    for (char& c : line)
        if (static_cast<unsigned char>(c) < 0x20) c = ' ';
    return line;
}

}  // namespace formats
namespace {

struct FormatName {
    const char* name;
    const char* extension;
    SurfaceFormat format;
};
/// The first entry of an extension is what the extension alone asks for.
constexpr FormatName format_names[] = {
    {"stl", ".stl", SurfaceFormat::stl_binary},
    {"stl-ascii", ".stl", SurfaceFormat::stl_ascii},
    {"obj", ".obj", SurfaceFormat::obj},
    {"ply", ".ply", SurfaceFormat::ply_binary},
    {"ply-ascii", ".ply", SurfaceFormat::ply_ascii},
    {"off", ".off", SurfaceFormat::off},
    {"tri", ".tri", SurfaceFormat::tri},
    {"vtp", ".vtp", SurfaceFormat::vtp},
};

std::string lower_extension(const std::filesystem::path& file) {
    std::string extension = file.extension().native();
    for (char& c : extension)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return extension;
}

SurfaceFile read_by_name(const std::filesystem::path& file, std::string_view bytes, const std::string& name) {
    const std::string extension = lower_extension(file);
    if (extension == ".stl") return formats::read_stl(bytes, name);
    if (extension == ".obj") return formats::read_obj(bytes, name);
    if (extension == ".ply") return formats::read_ply(bytes, name);
    if (extension == ".off") return formats::read_off(bytes, name);
    if (extension == ".tri") return formats::read_tri(bytes, name);
    if (extension == ".vtp") return formats::read_vtp(bytes, name);
    if (bytes.starts_with("ply\n") || bytes.starts_with("ply\r")) return formats::read_ply(bytes, name);
    if (bytes.starts_with("OFF")) return formats::read_off(bytes, name);
    if (bytes.starts_with("solid")) return formats::read_stl(bytes, name);
    throw InputError(text(name, ": not a known surface format: extension '", printable(extension),
                          "'; known are .stl .obj .ply .off .tri .vtp"));
}

/// Nothing that a reader would refuse is written.
void check_writable(const TriMesh& mesh) {
    for (int v = 0; v < mesh.num_vertices(); ++v)
        if (!mesh.vertices.row(v).allFinite())
            throw InvalidInput(text("write_surface: vertex ", v, " = ", mesh.vertices.row(v), " is not finite"));
    for (int i = 0; i < mesh.triangles.size(); ++i) {
        const int v = mesh.triangles.data()[i];
        if (v < 0 || v >= mesh.num_vertices())
            throw InvalidInput(
                text("write_surface: triangle ", i / 3, " has vertex ", v, ", limits 0 and ", mesh.num_vertices() - 1));
    }
    const bool complete = mesh.group.empty() || mesh.group.size() == static_cast<std::size_t>(mesh.num_triangles());
    for (const int g : mesh.group)
        if (!complete || g < 0 || g >= static_cast<int>(mesh.group_names.size()))
            throw InvalidInput(text("write_surface: ", mesh.group.size(), " group numbers for ", mesh.num_triangles(),
                                    " triangles, ", mesh.group_names.size(), " names, found group ", g));
}

}  // namespace

SurfaceFile read_surface(const std::filesystem::path& file) {
    const std::string name = printable(file.native());
    const std::string bytes = read_bytes(file);
    if (bytes.empty()) throw InputError(text(name, ": the file is empty"));
    try {
        return read_by_name(file, bytes, name);
    } catch (const std::bad_alloc&) {
        throw InputError(text(name, ": the surface of a file of ", bytes.size(), " bytes does not fit into memory"));
    }
}

std::string surface_bytes(const TriMesh& mesh, SurfaceFormat format, const std::string& name) {
    check_writable(mesh);
    switch (format) {
        case SurfaceFormat::stl_binary:
            return formats::stl_binary(mesh, name);
        case SurfaceFormat::stl_ascii:
            return formats::stl_ascii(mesh);
        case SurfaceFormat::obj:
            return formats::obj(mesh);
        case SurfaceFormat::ply_ascii:
            return formats::ply(mesh, false);
        case SurfaceFormat::ply_binary:
            return formats::ply(mesh, true);
        case SurfaceFormat::off:
            return formats::off(mesh);
        case SurfaceFormat::tri:
            return formats::tri(mesh);
        case SurfaceFormat::vtp:
            return formats::vtp(mesh);
    }
    throw InvalidInput(text("write_surface: format number ", static_cast<int>(format), " does not exist"));
}

void write_surface(const std::filesystem::path& file, const TriMesh& mesh, SurfaceFormat format) {
    write_atomically(file, surface_bytes(mesh, format, printable(file.native())));
}

SurfaceFormat format_of(const std::filesystem::path& file) {
    const std::string extension = lower_extension(file);
    for (const auto& f : format_names)
        if (extension == f.extension) return f.format;
    throw InvalidInput(text(printable(file.native()), ": no surface format has the extension '", printable(extension),
                            "'; known are .stl .obj .ply .off .tri .vtp"));
}

SurfaceFormat format_named(const std::string& name) {
    for (const auto& f : format_names)
        if (name == f.name) return f.format;
    throw InvalidInput(text("surface format '", printable(name),
                            "' is unknown; known are stl stl-ascii obj ply ply-ascii off tri vtp"));
}

std::string name_of(SurfaceFormat format) {
    for (const auto& f : format_names)
        if (format == f.format) return f.name;
    throw InvalidInput(text("name_of: format number ", static_cast<int>(format), " does not exist"));
}

std::string extension_of(SurfaceFormat format) {
    for (const auto& f : format_names)
        if (format == f.format) return f.extension;
    throw InvalidInput(text("extension_of: format number ", static_cast<int>(format), " does not exist"));
}

}  // namespace strake
