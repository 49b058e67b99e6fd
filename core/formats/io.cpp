#include "core/formats/io.hpp"

#include "core/error.hpp"
#include "core/formats/ear_clipping.hpp"
#include "core/formats/formats.hpp"
#include "core/text/file.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <new>
#include <utility>

namespace strake {
namespace formats {

int SurfaceBuilder::group_number(const std::string& name) {
    const auto [at, is_new] = known_.try_emplace(name, static_cast<int>(group_names.size()));
    if (is_new) group_names.push_back(name);
    return at->second;
}

void SurfaceBuilder::add_polygon(std::span<const int> polygon, int group_of_polygon) {
    if (polygon.size() > 3) fans_.push_back({corners.size() / 3, static_cast<int>(polygon.size())});
    for (std::size_t k = 2; k < polygon.size(); ++k) {
        corners.insert(corners.end(), {polygon[0], polygon[k - 1], polygon[k]});
        if (group_of_polygon >= 0) group.push_back(group_of_polygon);
    }
}

SurfaceBuilder SurfaceBuilder::with_used_vertices_only() const {
    SurfaceBuilder used;
    std::vector<int> number(static_cast<std::size_t>(num_vertices()), -1);
    for (const int v : corners) number[static_cast<std::size_t>(v)] = 0;
    int count = 0;
    for (std::size_t v = 0; v < number.size(); ++v) {
        if (number[v] < 0) continue;
        number[v] = count++;
        used.coordinates.insert(used.coordinates.end(), coordinates.begin() + static_cast<std::ptrdiff_t>(3 * v),
                                coordinates.begin() + static_cast<std::ptrdiff_t>(3 * v + 3));
    }
    for (const int v : corners) used.corners.push_back(number[static_cast<std::size_t>(v)]);
    used.group = group;
    used.group_names = group_names;
    used.fans_ = fans_;
    return used;
}

/// Whether a triangle of the fan would be inverted or degenerate.
void SurfaceBuilder::cut_again(const Fan& fan) {
    constexpr int max_corners = 1000;  // the time grows with their square
    if (fan.corners > max_corners) return;
    int* triangle = corners.data() + 3 * fan.first_triangle;
    std::vector<int> number{triangle[0]};
    for (int k = 1; k < fan.corners; ++k) number.push_back(k == 1 ? triangle[1] : triangle[3 * (k - 2) + 2]);
    Points polygon(fan.corners, 3);
    for (int k = 0; k < fan.corners; ++k)
        for (int c = 0; c < 3; ++c) polygon(k, c) = coordinates[3 * static_cast<std::size_t>(number[k]) + c];
    const Eigen::Vector3d area = polygon_area_vector(polygon);
    const double size = area.stableNorm();
    if (!(size > 0) || !std::isfinite(size)) return;
    const Eigen::Vector3d normal = area / size;
    bool is_folded = false;
    for (int k = 2; k < fan.corners; ++k) {
        const Eigen::Vector3d a = polygon.row(k - 1) - polygon.row(0), b = polygon.row(k) - polygon.row(0);
        is_folded = is_folded || !(a.cross(b).dot(normal) > 1e-12 * size);
    }
    if (!is_folded) return;
    for (const std::array<int, 3>& ear : clip_ears(polygon, normal))
        for (const int k : ear) *triangle++ = number[k];
}

SurfaceFile SurfaceBuilder::finish(const std::string& name, SurfaceFormat format) {
    if (corners.empty()) throw InputError(text(name, ": holds no triangles (", num_vertices(), " vertices)"));
    if (corners.size() / 3 > static_cast<std::size_t>(std::numeric_limits<int>::max() / 3))
        throw InputError(text(name, ": ", corners.size() / 3, " triangles, at most 715827882 are possible"));
    for (const Fan& fan : fans_) cut_again(fan);
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

std::string one_word(const std::string& name) {
    std::string word = one_line(name);
    std::replace(word.begin(), word.end(), ' ', '_');
    return word.empty() ? "_" : word;
}

std::vector<std::string> component_numbers(const TriMesh& mesh) {
    std::vector<std::string> numbers = mesh.group_names;
    const auto is_number = [](const std::string& s) {
        return !s.empty() && s.size() <= 9 && s.find_first_not_of("0123456789") == s.npos && s[0] != '0';
    };
    if (std::all_of(numbers.begin(), numbers.end(), is_number)) return numbers;
    for (std::size_t g = 0; g < numbers.size(); ++g) numbers[g] = std::to_string(g + 1);
    return numbers;
}

std::vector<std::vector<int>> triangles_by_group(const TriMesh& mesh) {
    std::vector<std::vector<int>> parts(std::max<std::size_t>(1, mesh.group.empty() ? 1 : mesh.group_names.size()));
    for (int t = 0; t < mesh.num_triangles(); ++t) parts[mesh.group.empty() ? 0 : mesh.group[t]].push_back(t);
    return parts;
}

}  // namespace formats
namespace {

using Read = SurfaceFile (*)(std::string_view bytes, const std::string& name);
using Write = std::string (*)(const TriMesh& mesh, const std::string& name);

struct Format {
    const char* name;
    const char* extension;
    SurfaceFormat format;
    Read read;
    Write write;
    bool keeps_parts;
    const char* begins = nullptr;  ///< first bytes, for files of unknown extension
};
template <std::string (*write)(const TriMesh&)>
std::string plainly(const TriMesh& mesh, const std::string&) {
    return write(mesh);
}
template <bool binary>
std::string as_ply(const TriMesh& mesh, const std::string&) {
    return formats::ply(mesh, binary);
}
/// The first entry of an extension is its default.
constexpr Format known_formats[] = {
    {"stl", ".stl", SurfaceFormat::stl_binary, formats::read_stl, formats::stl_binary, false, "solid"},
    {"stl-ascii", ".stl", SurfaceFormat::stl_ascii, formats::read_stl, plainly<formats::stl_ascii>, true},
    {"obj", ".obj", SurfaceFormat::obj, formats::read_obj, plainly<formats::obj>, true},
    {"ply", ".ply", SurfaceFormat::ply_binary, formats::read_ply, as_ply<true>, false, "ply"},
    {"ply-ascii", ".ply", SurfaceFormat::ply_ascii, formats::read_ply, as_ply<false>, false},
    {"off", ".off", SurfaceFormat::off, formats::read_off, plainly<formats::off>, false, "OFF"},
    {"tri", ".tri", SurfaceFormat::tri, formats::read_tri, plainly<formats::tri>, true},
    {"vtk", ".vtk", SurfaceFormat::vtk, formats::read_vtk, plainly<formats::vtk>, false, "# vtk DataFile"},
    {"vtp", ".vtp", SurfaceFormat::vtp, formats::read_vtp, plainly<formats::vtp>, true},
    {"su2", ".su2", SurfaceFormat::su2, formats::read_su2, plainly<formats::su2>, true},
    {"msh", ".msh", SurfaceFormat::gmsh, formats::read_gmsh, plainly<formats::gmsh>, true, "$MeshFormat"},
    {"nastran", ".nas", SurfaceFormat::nastran, formats::read_nastran, plainly<formats::nastran>, true},
    {"nastran", ".bdf", SurfaceFormat::nastran, formats::read_nastran, plainly<formats::nastran>, true},
    {"nastran", ".dat", SurfaceFormat::nastran, formats::read_nastran, plainly<formats::nastran>, true},
};

std::string known_extensions() {
    std::string list;
    std::string_view last;
    for (const Format& f : known_formats)
        if (std::exchange(last, f.extension) != f.extension)
            list += (list.empty() ? "" : " ") + std::string(f.extension);
    return list;
}
std::string known_names() {
    std::string list;
    std::string_view last;
    for (const Format& f : known_formats)
        if (std::exchange(last, f.name) != f.name) list += (list.empty() ? "" : " ") + std::string(f.name);
    return list;
}

std::string lower_extension(const std::filesystem::path& file) {
    std::string extension = file.extension().native();
    for (char& c : extension)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return extension;
}

constexpr std::string_view gzip_magic = "\x1f\x8b";

/// Editors on Windows put a byte-order mark before UTF-8 text. The header of a binary STL may hold any bytes.
std::string_view without_mark(std::string_view bytes, const std::string& extension) {
    constexpr std::string_view mark = "\xEF\xBB\xBF";
    if (!bytes.starts_with(mark)) return bytes;
    const std::string_view rest = bytes.substr(mark.size());
    const bool is_text = extension != ".stl" || rest.starts_with("solid") || rest.starts_with("SOLID");
    return is_text ? rest : bytes;
}

SurfaceFile read_by_name(const std::filesystem::path& file, std::string_view bytes, const std::string& name) {
    const std::string extension = lower_extension(file);
    if (extension == ".gz") {
        const std::string unpacked = formats::unpacked(bytes, name);
        if (unpacked.empty()) throw InputError(text(name, ": the packed file is empty"));
        if (lower_extension(file.stem()) == ".gz") throw InputError(text(name, ": packed twice"));
        return read_by_name(file.stem(), unpacked, name);
    }
    bytes = without_mark(bytes, extension);
    for (const Format& f : known_formats)
        if (extension == f.extension) return f.read(bytes, name);
    for (const Format& f : known_formats)
        if (f.begins && bytes.starts_with(f.begins)) return f.read(bytes, name);
    const char* of_case = extension == ".yaml" || extension == ".yml" ? " (a case? `strake check` reads it)" : "";
    throw InputError(text(name, ": not a known surface format: extension '", printable(extension), "'", of_case,
                          "; known are ", known_extensions(),
                          bytes.starts_with(gzip_magic) ? ", each also packed as .gz" : ""));
}

/// Never writes a file that a reader would refuse.
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

void check_coordinates(const std::filesystem::path& file, const TriMesh& mesh) {
    constexpr double limit = 1e100;
    for (int v = 0; v < mesh.num_vertices(); ++v)
        for (int c = 0; c < 3; ++c)
            if (!(std::abs(mesh.vertices(v, c)) <= limit))
                throw InputError(text(printable(file.native()), ": vertex ", v, ": ", "xyz"[c], " = ",
                                      mesh.vertices(v, c), " is beyond what can be computed with, ", limit,
                                      "; scale the surface"));
}

void write_surface(const std::filesystem::path& file, const TriMesh& mesh, SurfaceFormat format) {
    write_atomically(file, surface_bytes(mesh, format, printable(file.native())));
}

std::string surface_bytes(const TriMesh& mesh, SurfaceFormat format, const std::string& name) {
    check_writable(mesh);
    for (const Format& f : known_formats)
        if (f.format == format) return f.write(mesh, name);
    throw InvalidInput(text("write_surface: format number ", static_cast<int>(format), " does not exist"));
}

SurfaceFormat format_of(const std::filesystem::path& file) {
    const std::string extension = lower_extension(file);
    for (const Format& f : known_formats)
        if (extension == f.extension) return f.format;
    if (extension == ".gz")
        throw InvalidInput(text(printable(file.native()), ": packed files are read, not written; leave out .gz"));
    throw InvalidInput(text(printable(file.native()), ": no surface format has the extension '", printable(extension),
                            "'; known are ", known_extensions()));
}

SurfaceFormat format_named(const std::string& name) {
    for (const Format& f : known_formats)
        if (name == f.name) return f.format;
    throw InvalidInput(text("surface format '", printable(name), "' is unknown; known are ", known_names()));
}

std::string name_of(SurfaceFormat format) {
    for (const Format& f : known_formats)
        if (format == f.format) return f.name;
    throw InvalidInput(text("name_of: format number ", static_cast<int>(format), " does not exist"));
}

bool keeps_parts(SurfaceFormat format) {
    return std::any_of(std::begin(known_formats), std::end(known_formats),
                       [&](const Format& f) { return f.format == format && f.keeps_parts; });
}

std::string extension_of(SurfaceFormat format) {
    for (const Format& f : known_formats)
        if (format == f.format) return f.extension;
    throw InvalidInput(text("extension_of: format number ", static_cast<int>(format), " does not exist"));
}

}  // namespace strake
