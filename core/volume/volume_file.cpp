#include "core/volume/volume_file.hpp"

#include "core/error.hpp"
#include "core/formats/formats.hpp"
#include "core/formats/io.hpp"
#include "core/text/file.hpp"

#include <charconv>

namespace strake {
namespace {

namespace fs = std::filesystem;

bool is_points_file(const fs::path& path) { return path.filename() == "points" || path.filename() == "points.gz"; }

/// NELEM= of a mesh of three dimensions is above zero: else it is a surface.
bool has_volume_elements(const fs::path& path) {
    const std::string bytes = read_bytes(path);
    for (std::size_t at = bytes.find("NELEM"); at != bytes.npos; at = bytes.find("NELEM", at + 5)) {
        std::size_t digits = bytes.find_first_not_of(" \t=", at + 5);
        int count = 0;
        if (digits != bytes.npos) std::from_chars(bytes.data() + digits, bytes.data() + bytes.size(), count);
        if (count > 0) return true;
    }
    return false;
}

std::string su2_with_points(const VolumeFile& file, const Points& points) {
    std::string out;
    out.reserve(file.bytes.size() + file.bytes.size() / 4);
    std::size_t done = 0;
    for (std::size_t i = 0; i < file.places.size(); ++i) {
        const auto& [begin, end] = file.places[i];
        const auto row = static_cast<Eigen::Index>(i);
        if (points.row(row) == file.mesh.points.row(row)) continue;  // the text stays verbatim
        out.append(file.bytes, done, begin - done);
        formats::append_row(out, "", points.data() + 3 * row);
        out.pop_back();
        done = end;
    }
    return out.append(file.bytes, done, file.bytes.npos);
}

/// Files of the mesh other than its points.
void copy_others(const fs::path& from, const fs::path& to) {
    for (const auto& entry : fs::directory_iterator(from)) {
        std::error_code error;
        if (!entry.is_regular_file(error) || is_points_file(entry.path())) continue;
        write_atomically(to / entry.path().filename(), read_bytes(entry.path()));
    }
}

}  // namespace

bool is_volume(const fs::path& path) {
    std::error_code ignored;
    if (fs::is_directory(path, ignored) || is_points_file(path) || path.extension() == ".vtu") return true;
    return path.extension() == ".su2" && has_volume_elements(path);
}

VolumeFile read_volume(const fs::path& path) {
    std::error_code ignored;
    const std::string name = printable(path.native());
    if (fs::is_directory(path, ignored) || is_points_file(path)) return volume_formats::read_poly_mesh(path);
    if (path.extension() != ".su2" && path.extension() != ".vtu")
        throw InvalidInput(text(name, ": no volume mesh (a polyMesh folder, its points, .su2 or .vtu)"));
    const auto read = path.extension() == ".su2" ? volume_formats::read_su2 : volume_formats::read_vtu;
    VolumeFile file = read(read_bytes(path), name);
    file.source = path;
    return file;
}

void volume_formats::check_corners(const VolumeMesh& mesh, const std::string& name) {
    const auto check = [&](const Polygons& polygons, const std::string& what) {
        for (int f = 0; f < polygons.size(); ++f)
            for (const int v : polygons[f])
                if (v < 0 || v >= mesh.num_points())
                    throw InputError(
                        text(name, ": ", what, " ", f, " has point ", v, ", limits 0 and ", mesh.num_points() - 1));
    };
    check(mesh.faces, "face");
    for (const BoundaryPart& part : mesh.boundary) check(part.faces, "face of '" + printable(part.name, 60) + "'");
}

std::string with_points(const VolumeFile& file, const Points& points) {
    if (points.rows() != file.mesh.num_points())
        throw InvalidInput(text("with_points: ", points.rows(), " points, the mesh has ", file.mesh.num_points()));
    switch (file.format) {
        case VolumeFormat::open_foam:
            return foam::with_vectors(file.bytes, file.list, points.data(), file.mesh.num_points());
        case VolumeFormat::su2:
            return su2_with_points(file, points);
        case VolumeFormat::vtu:
            break;
    }
    return volume_formats::vtu_with_points(file, points);
}

void check_volume_output(const fs::path& out, const fs::path& in) {
    std::error_code ignored;
    const std::string name = printable(out.native(), 400);
    if (fs::is_directory(in, ignored) || is_points_file(in)) {
        if (out.extension() == ".vtu" || out.extension() == ".su2")
            throw InvalidInput(text(name, ": a mesh keeps its format: write a folder, or a file of the name points"));
        if (out.extension() == ".gz") throw InvalidInput(text(name, ": points are written unpacked: leave out .gz"));
        if (!fs::is_directory(in, ignored) && out.filename() != "points")
            throw InvalidInput(text(name, ": the points of a mesh of OpenFOAM go to a file of the name points"));
    } else if (out.extension() != in.extension()) {
        throw InvalidInput(text(name, ": a mesh keeps its format: write ", in.extension().string()));
    }
}

void write_volume(const fs::path& out, const VolumeFile& file, const Points& points) {
    const bool is_file = file.format != VolumeFormat::open_foam || file.folder.empty() || out.filename() == "points";
    std::error_code error;
    for (const fs::path& target : {is_file ? out : out / "points", is_file ? out : out / "points.gz"})
        if (fs::equivalent(target, file.source, error) && !error)
            throw InvalidInput(text(printable(target.native(), 400), ": would overwrite what is read"));
    const std::string bytes = with_points(file, points);
    if (is_file) return write_atomically(out, bytes);
    fs::create_directories(out, error);
    if (error) throw OutputError(text(printable(out.native(), 400), ": cannot make the folder: ", error.message()));
    copy_others(file.folder, out);
    write_atomically(out / "points", bytes);
}

}  // namespace strake
