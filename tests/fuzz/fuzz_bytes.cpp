#include "core/error.hpp"
#include "core/formats/formats.hpp"
#include "core/formats/npy.hpp"
#include "core/formats/vtp_reader.hpp"
#include "core/repair/repair.hpp"
#include "core/volume/cell_check.hpp"
#include "core/volume/volume_file.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

/// Whatever the bytes are, a reader ends in a surface or in an InputError, and repair in a surface or InvalidInput.
/// What is promised about the results is checked, too.
namespace strake {
namespace {

using Try = void (*)(std::string_view bytes);

void require(bool kept, const char* promise) {
    if (kept) return;
    std::fprintf(stderr, "broken promise: %s\n", promise);
    std::abort();
}

void check(const TriMesh& mesh) {
    require(mesh.vertices.allFinite(), "coordinates are finite");
    require(mesh.triangles.size() == 0 ||
                (mesh.triangles.minCoeff() >= 0 && mesh.triangles.maxCoeff() < mesh.num_vertices()),
            "indices are in range");
    require(mesh.group.empty() || mesh.group.size() == static_cast<std::size_t>(mesh.num_triangles()),
            "every triangle has a group, or none");
    for (const int g : mesh.group)
        require(g >= 0 && g < static_cast<int>(mesh.group_names.size()), "groups are in range");
}

/// What was read is written and read again.
template <SurfaceFile (*read)(std::string_view, const std::string&)>
void try_reader(std::string_view bytes) {
    SurfaceFile file;
    try {
        file = read(bytes, "f");
    } catch (const InputError& refused) {
        require(std::strlen(refused.what()) < 4000, "messages are short");
        return;
    }
    check(file.mesh);
    require(file.mesh.num_triangles() > 0, "a surface has triangles");
    std::string again;
    try {
        again = surface_bytes(file.mesh, file.format, "f");
    } catch (const OutputError&) {
        return;  // beyond what single precision holds
    }
    const SurfaceFile back = read(again, "f");
    require(back.mesh.num_triangles() == file.mesh.num_triangles(), "a round trip keeps the triangles");
}

void try_gzip(std::string_view bytes) {
    try {
        const std::string plain = formats::unpacked(bytes, "f");
        require(plain.size() <= 1000 * bytes.size(), "what is packed too well is refused");
        try_reader<formats::read_stl>(plain);
    } catch (const InputError&) {
    }
}

void try_npy(std::string_view bytes) {
    try {
        parse_npy(bytes);
    } catch (const NpyError&) {
    }
}

void try_vtp_fields(std::string_view bytes) {
    try {
        const VtpFile file = parse_vtp(bytes, "f");
        check(file.surface.mesh);
    } catch (const InputError&) {
    }
}

/// The mesh of a volume: its cells are measured, and the same points are written into it again.
template <VolumeFile (*read)(std::string, const std::string&)>
void try_volume(std::string_view bytes) {
    try {
        const VolumeFile file = read(std::string(bytes), "f");
        require(file.mesh.points.allFinite(), "coordinates are finite");
        cell_sizes(file.mesh, file.mesh.points);
        const VolumeFile again = read(with_points(file, file.mesh.points), "f");
        require(again.mesh.points == file.mesh.points, "a round trip keeps the points");
        require(again.mesh.num_cells == file.mesh.num_cells, "a round trip keeps the cells");
    } catch (const InputError& refused) {
        require(std::strlen(refused.what()) < 4000, "messages are short");
    }
}

void try_foam(std::string_view bytes) {
    try {
        foam::File file(bytes, "f");
        const foam::File begin = file;
        foam::ListPlace place;
        const std::vector<double> at = foam::File(begin).vectors(place);
        foam::with_vectors(bytes, place, at.data(), static_cast<int>(at.size() / 3));
    } catch (const InputError&) {
    }
    try {
        foam::File file(bytes, "f");
        std::vector<int> first, entries;
        if (file.kind() == "labelList")
            file.labels();
        else
            file.label_lists(first, entries);
    } catch (const InputError&) {
    }
}

/// Bytes as a surface: small numbers, so that places and vertices meet.
TriMesh mesh_of(std::string_view bytes) {
    TriMesh mesh;
    if (bytes.size() < 2) return mesh;
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(bytes[i]); };
    const int n = 3 + byte(0) % 30;
    const std::size_t m = std::min<std::size_t>((bytes.size() - 1) / 3, 80);
    mesh.vertices.resize(n, 3);
    for (int v = 0; v < n; ++v)
        for (int k = 0; k < 3; ++k) mesh.vertices(v, k) = byte((7 * v + 3 * k + byte(1)) % bytes.size()) % 8;
    mesh.triangles.resize(static_cast<Eigen::Index>(m), 3);
    for (std::size_t i = 0; i < 3 * m; ++i) mesh.triangles.data()[i] = byte(1 + i) % n;
    return mesh;
}

void try_repair(std::string_view bytes) {
    const TriMesh mesh = mesh_of(bytes);
    if (mesh.num_triangles() == 0) return;
    RepairOptions options = all_repairs(box_diagonal(mesh));
    const int choice = static_cast<unsigned char>(bytes[0]);
    if (choice % 2) options.fill = HoleFill::smooth;
    if (choice % 3 == 0) options.split = false;
    if (choice % 5 == 0) options.weld.reset();
    if (choice % 7 == 0) options.cracks.reset();
    if (options.holes) options.holes = 100;
    try {
        const RepairResult result = repair(mesh, options);
        check(result.mesh);
        require(result.source_triangle.size() == static_cast<std::size_t>(result.mesh.num_triangles()),
                "every triangle has a source");
        require(result.after.facts.isolated_vertices.empty(), "isolated vertices go");
        repair_csv(result);
        defects_in_words(result.mesh, result.after);
        advice(result.mesh, result.after);
        defect_fields(result.mesh, result.after);
    } catch (const InvalidInput&) {
    }
}

struct Target {
    const char* name;
    Try run;
};
constexpr Target targets[] = {{"stl", try_reader<formats::read_stl>},
                              {"obj", try_reader<formats::read_obj>},
                              {"ply", try_reader<formats::read_ply>},
                              {"off", try_reader<formats::read_off>},
                              {"tri", try_reader<formats::read_tri>},
                              {"su2", try_reader<formats::read_su2>},
                              {"msh", try_reader<formats::read_gmsh>},
                              {"nas", try_reader<formats::read_nastran>},
                              {"vtk", try_reader<formats::read_vtk>},
                              {"vtp", try_reader<formats::read_vtp>},
                              {"vtp_fields", try_vtp_fields},
                              {"gz", try_gzip},
                              {"npy", try_npy},
                              {"su2_volume", try_volume<volume_formats::read_su2>},
                              {"vtu", try_volume<volume_formats::read_vtu>},
                              {"foam", try_foam},
                              {"repair", try_repair}};

Try chosen() {
    const char* name = std::getenv("FUZZ");
    for (const Target& target : targets)
        if (name && std::strcmp(name, target.name) == 0) return target.run;
    std::fprintf(stderr, "FUZZ must name one of:");
    for (const Target& target : targets) std::fprintf(stderr, " %s", target.name);
    std::fprintf(stderr, "\n");
    std::exit(2);
}

}  // namespace
}  // namespace strake

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
    static const strake::Try run = strake::chosen();
    run({reinterpret_cast<const char*>(data), size});
    return 0;
}
