#include "core/error.hpp"
#include "core/formats/formats.hpp"
#include "core/text/file.hpp"
#include "core/volume/volume_file.hpp"

#include <algorithm>
#include <charconv>

/// OpenFOAM's polyMesh: points, faces, owner, neighbour and boundary, a file each.
namespace strake::volume_formats {
namespace {

namespace fs = std::filesystem;

/// `folder/name` or `folder/name.gz`; empty when there is neither.
fs::path found(const fs::path& folder, const std::string& name) {
    std::error_code ignored;
    for (const char* ending : {"", ".gz"})
        if (fs::path file = folder / (name + ending); fs::exists(file, ignored)) return file;
    return {};
}

std::string content(const fs::path& file) {
    std::string bytes = read_bytes(file);
    return file.extension() == ".gz" ? formats::unpacked(bytes, printable(file.native())) : bytes;
}

fs::path mesh_folder(const fs::path& path) {
    for (const fs::path& folder : {path, path / "polyMesh", path / "constant/polyMesh"})
        if (!found(folder, "points").empty()) return folder;
    throw InputError(text(printable(path.native(), 400),
                          ": no mesh of OpenFOAM (there is no points, polyMesh/points or constant/polyMesh/points)"));
}

std::vector<int> read_labels(const fs::path& folder, const std::string& name) {
    const fs::path path = found(folder, name);
    const std::string bytes = content(path);
    return foam::File(bytes, printable(path.native())).labels();
}

void read_faces(const fs::path& folder, Polygons& faces) {
    const fs::path path = found(folder, "faces");
    const std::string bytes = content(path);
    foam::File file(bytes, printable(path.native()));
    if (file.kind() != "faceCompactList") return file.label_lists(faces.first, faces.corners);
    faces.first = file.labels();
    faces.corners = file.labels();
    if (faces.first.empty()) faces.first = {0};
    if (faces.first.front() != 0 || faces.first.back() != static_cast<int>(faces.corners.size()) ||
        !std::is_sorted(faces.first.begin(), faces.first.end()))
        file.fail("the offsets of the faces do not fit the points that they list");
}

int whole(std::string_view word, const foam::File& file) {
    int value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() || value < 0)
        file.fail(text("'", printable(word, 60), "' is not a whole number"));
    return value;
}

/// N ( name { type wall; nFaces 12; startFace 345; … } … )
void read_boundary(const fs::path& folder, VolumeMesh& mesh) {
    const fs::path path = found(folder, "boundary");
    if (path.empty()) return;
    const std::string bytes = content(path);
    foam::File file(bytes, printable(path.native()));
    std::string_view word = file.token();
    if (word != "(") word = file.token();
    for (word = file.token(); !word.empty() && word != ")"; word = file.token()) {
        BoundaryPart part{std::string(word), {}};
        int count = 0, start = 0;
        if (file.token() != "{") file.fail("a patch without '{'");
        for (std::string_view key = file.token(); key != "}"; key = file.token()) {
            if (key.empty()) file.fail("a patch without its end");
            if (key == "nFaces") count = whole(file.token(), file);
            if (key == "startFace") start = whole(file.token(), file);
        }
        if (start > mesh.faces.size() || count > mesh.faces.size() - start)
            file.fail(text("patch ", printable(part.name, 60), " ends behind the last face"));
        for (int f = start; f < start + count; ++f) part.faces.add(mesh.faces[f]);
        mesh.boundary.push_back(std::move(part));
    }
}

void read_cells(const fs::path& folder, VolumeMesh& mesh) {
    read_faces(folder, mesh.faces);
    mesh.owner = read_labels(folder, "owner");
    std::vector<int> behind = read_labels(folder, "neighbour");
    const std::string name = printable(folder.native());
    const auto count = static_cast<std::size_t>(mesh.faces.size());
    if (mesh.owner.size() != count || behind.size() > count)
        throw InputError(
            text(name, ": ", count, " faces, but ", mesh.owner.size(), " owners and ", behind.size(), " neighbours"));
    behind.resize(count, -1);
    mesh.neighbour = std::move(behind);
    for (std::size_t f = 0; f < count; ++f) {
        if (mesh.owner[f] < 0) throw InputError(text(name, "/owner: face ", f, " belongs to no cell"));
        mesh.num_cells = std::max({mesh.num_cells, mesh.owner[f] + 1, mesh.neighbour[f] + 1});
    }
    if (static_cast<std::size_t>(mesh.num_cells) > count)
        throw InputError(text(name, ": ", mesh.num_cells, " cells with ", count, " faces in all"));
    check_corners(mesh, name);
    read_boundary(folder, mesh);
}

}  // namespace

VolumeFile read_poly_mesh(const fs::path& path) {
    std::error_code ignored;
    VolumeFile out;
    out.format = VolumeFormat::open_foam;
    const bool is_folder = fs::is_directory(path, ignored);
    const fs::path folder = is_folder ? mesh_folder(path) : path.parent_path();
    const fs::path file = is_folder ? found(folder, "points") : path;
    if (is_folder) out.folder = folder;
    out.bytes = content(file);
    out.source = file;
    out.name = printable(file.native());
    const std::vector<double> at = foam::File(out.bytes, out.name).vectors(out.list);
    out.mesh.points = Eigen::Map<const Points>(at.data(), static_cast<Eigen::Index>(at.size() / 3), 3);
    const bool has_cells =
        !found(folder, "faces").empty() && !found(folder, "owner").empty() && !found(folder, "neighbour").empty();
    if (has_cells) read_cells(folder, out.mesh);
    if (is_folder && !has_cells)
        throw InputError(text(printable(folder.native(), 400), ": there must be faces, owner and neighbour, too"));
    return out;
}

}  // namespace strake::volume_formats
