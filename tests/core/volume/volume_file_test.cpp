#include "core/volume/volume_file.hpp"

#include "core/error.hpp"
#include "core/formats/io.hpp"
#include "core/mesh/temp_folder.hpp"
#include "core/text/file.hpp"
#include "core/volume/blocks.hpp"
#include "core/volume/cell_check.hpp"

#include <gtest/gtest.h>
#include <cstring>

namespace strake {
namespace {

std::string join(const Points& points, const char* before, const char* after) {
    std::string out;
    for (Eigen::Index i = 0; i < points.rows(); ++i)
        out += text(before, points(i, 0), " ", points(i, 1), " ", points(i, 2), after);
    return out;
}

std::string su2_of(const Block& b) {
    std::string out = text("% made for a test\nNDIME= 3\nNELEM= ", b.cells.size(), "\n");
    int number = 0;
    for (const auto& cell : b.cells) {
        out += "12";
        for (const int v : cell) out += text(" ", v);
        out += text("  ", number++, "\n");
    }
    out += text("NPOIN= ", b.points.rows(), "\n");
    for (Eigen::Index v = 0; v < b.points.rows(); ++v)
        out += text("\t", b.points(v, 0), "  ", b.points(v, 1), "\t", b.points(v, 2), " ", v, " % point\r\n");
    return out + "NMARK= 1\nMARKER_TAG= floor\nMARKER_ELEMS= 1\n9 0 1 4 3\n";
}

std::string header(const std::string& kind, const std::string& format) {
    return "/* a banner */\nFoamFile\n{\n    version 2.0;\n    format " + format + ";\n    class " + kind +
           ";\n    arch \"LSB;label=32;scalar=64\";\n    object x;\n}\n// * * * //\n\n";
}

template <class Number>
std::string raw(const std::vector<Number>& numbers) {
    return {reinterpret_cast<const char*>(numbers.data()), sizeof(Number) * numbers.size()};
}

/// The polyMesh of a block: inner faces are shared.
void write_poly_mesh(const TempFolder& folder, const Block& b, bool binary) {
    const VolumeMesh mesh = mesh_of(b);
    std::map<std::vector<int>, int> known;
    std::vector<int> order, behind(static_cast<std::size_t>(mesh.faces.size()), -1);
    for (int f = 0; f < mesh.faces.size(); ++f) {
        std::vector<int> key(mesh.faces[f].begin(), mesh.faces[f].end());
        std::sort(key.begin(), key.end());
        const auto [at, is_new] = known.try_emplace(key, f);
        if (is_new)
            order.push_back(f);
        else
            behind[static_cast<std::size_t>(at->second)] = mesh.owner[static_cast<std::size_t>(f)];
    }
    std::stable_partition(order.begin(), order.end(), [&](int f) { return behind[static_cast<std::size_t>(f)] >= 0; });
    std::vector<int> owner, neighbour, first{0}, corners;
    std::string faces;
    for (const int f : order) {
        owner.push_back(mesh.owner[static_cast<std::size_t>(f)]);
        if (behind[static_cast<std::size_t>(f)] >= 0) neighbour.push_back(behind[static_cast<std::size_t>(f)]);
        faces += "4(";
        for (const int v : mesh.faces[f]) faces += std::to_string(v) + " ", corners.push_back(v);
        faces.back() = ')';
        faces += "\n";
        first.push_back(static_cast<int>(corners.size()));
    }
    const auto list = [&](const std::vector<int>& labels) {
        std::string out = std::to_string(labels.size()) + "\n(";
        if (binary) return out + raw(labels) + ")\n";
        for (const int v : labels) out += std::to_string(v) + "\n";
        return out + ")\n";
    };
    const std::string format = binary ? "binary" : "ascii", count = std::to_string(b.points.rows()) + "\n(";
    const std::vector<double> at(b.points.data(), b.points.data() + b.points.size());
    folder.write("points", header("vectorField", format) + count + (binary ? raw(at) : join(b.points, "\n(", ")")) +
                               ")\n// the end\n");
    folder.write("faces", binary ? header("faceCompactList", format) + list(first) + list(corners)
                                 : header("faceList", format) + std::to_string(order.size()) + "(\n" + faces + ")\n");
    folder.write("owner", header("labelList", format) + list(owner));
    folder.write("neighbour", header("labelList", format) + list(neighbour));
    folder.write("boundary", header("polyBoundaryMesh", format) +
                                 text("1\n(\n walls { type wall; inGroups 1(wall); nFaces ",
                                      owner.size() - neighbour.size(), "; startFace ", neighbour.size(), "; }\n)\n"));
}

Points shaken(const Points& points) {
    Points out = points;
    for (Eigen::Index v = 0; v < out.rows(); v += 2)
        out.row(v) += 0.01 * Eigen::RowVector3d(std::sin(1.0 * v), std::cos(2.0 * v), std::sin(3.0 * v));
    return out;
}

TEST(VolumeFile, Su2KeepsEverythingButCoordinates) {
    const TempFolder folder;
    const Block b = block(3);
    const auto path = folder.write("m.su2", su2_of(b));
    EXPECT_TRUE(is_volume(path));
    const VolumeFile file = read_volume(path);
    EXPECT_EQ(file.mesh.num_cells, 27);
    ASSERT_EQ(file.mesh.boundary.size(), 1U);
    EXPECT_EQ(file.mesh.boundary[0].name, "floor");
    EXPECT_NEAR(cell_sizes(file.mesh, file.mesh.points).volume.sum(), 1, 1e-13);
    EXPECT_EQ(with_points(file, file.mesh.points), su2_of(b)) << "nothing has moved";
    const Points moved = shaken(file.mesh.points);
    write_volume(folder / "n.su2", file, moved);
    const VolumeFile again = read_volume(folder / "n.su2");
    EXPECT_EQ(again.mesh.points, moved);
    EXPECT_EQ(again.mesh.faces.corners, file.mesh.faces.corners);
    EXPECT_EQ(with_points(again, file.mesh.points).substr(0, 60), su2_of(b).substr(0, 60));
    EXPECT_NE(again.bytes.find(" 5 % point\r\n"), std::string::npos) << "numbers, comments and line ends stay";
}

TEST(VolumeFile, PolyMeshInTextAndBinary) {
    for (const bool binary : {false, true}) {
        const TempFolder folder, out;
        const Block b = block(3);
        write_poly_mesh(folder, b, binary);
        const VolumeFile file = read_volume(folder.path());
        EXPECT_EQ(file.mesh.num_cells, 27);
        EXPECT_EQ(file.mesh.faces.size(), 108);
        EXPECT_NEAR(cell_sizes(file.mesh, file.mesh.points).volume.sum(), 1, 1e-13);
        EXPECT_GT(cell_sizes(file.mesh, file.mesh.points).pyramid.minCoeff(), 0);
        ASSERT_EQ(file.mesh.boundary.size(), 1U);
        EXPECT_EQ(file.mesh.boundary[0].faces.size(), 54);
        if (binary) {
            EXPECT_EQ(with_points(file, file.mesh.points), file.bytes);
        }
        const Points moved = shaken(file.mesh.points);
        write_volume(out / "mesh", file, moved);
        const VolumeFile again = read_volume(out / "mesh");
        EXPECT_EQ(again.mesh.points, moved);
        EXPECT_EQ(bytes_of(out / "mesh/faces"), bytes_of(folder / "faces"));
        EXPECT_TRUE(again.bytes.ends_with(")\n// the end\n"));
        const VolumeFile alone = read_volume(folder / "points");
        EXPECT_EQ(alone.mesh.num_cells, 27) << "the files beside it are known";
        write_volume(out / "points", alone, moved);
        EXPECT_EQ(bytes_of(out / "points"), again.bytes);
        EXPECT_FALSE(std::filesystem::exists(out / "faces"));
        EXPECT_THROW(write_volume(folder.path(), file, moved), InvalidInput) << "what is read is not overwritten";
        EXPECT_THROW(write_volume(folder / "points", file, moved), InvalidInput);
        EXPECT_EQ(read_volume(folder.path()).mesh.points, file.mesh.points);
    }
}

std::string vtu_of(const Block& b, bool appended) {
    std::string corners, ends, types, data;
    for (std::size_t c = 0; c < b.cells.size(); ++c) {
        for (const int v : b.cells[c]) corners += std::to_string(v) + " ";
        ends += std::to_string(8 * (c + 1)) + " ";
        types += "12 ";
    }
    const std::uint64_t length = 8 * static_cast<std::uint64_t>(b.points.size());
    const std::string info = "<InformationKey name=\"L2_NORM_RANGE\"><Value index=\"0\">0</Value></InformationKey>\n";
    if (appended)
        data = "<AppendedData encoding=\"raw\">\n_" + raw<std::uint64_t>({length}) +
               std::string(reinterpret_cast<const char*>(b.points.data()), length) + raw<std::uint64_t>({8}) +
               "AAAAAAAA" + "\n</AppendedData>\n";
    return "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
           "header_type=\"UInt64\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"" +
           std::string(text(b.points.rows(), "\" NumberOfCells=\"", b.cells.size())) + "\">\n<Points>\n" +
           (appended ? "<DataArray type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\" format=\"appended\" "
                       "offset=\"0\">\n" +
                           info + "</DataArray>\n"
                     : "<DataArray type=\"Float32\" Name=\"Points\" NumberOfComponents=\"3\" format=\"ascii\">\n" +
                           info + join(b.points, "", "\n") + "</DataArray>\n") +
           "</Points>\n<Cells>\n<DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">" + corners +
           "</DataArray>\n<DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">" + ends +
           "</DataArray>\n<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">" + types +
           "</DataArray>\n</Cells>\n</Piece>\n</UnstructuredGrid>\n" + data + "</VTKFile>\n";
}

TEST(VolumeFile, VtuInPlaceAndAsText) {
    for (const bool appended : {false, true}) {
        const TempFolder folder;
        const Block b = block(2);
        const VolumeFile file = read_volume(folder.write("m.vtu", vtu_of(b, appended)));
        EXPECT_EQ(file.mesh.num_cells, 8);
        EXPECT_EQ(file.mesh.points, b.points);
        EXPECT_NEAR(cell_sizes(file.mesh, file.mesh.points).volume.sum(), 1, 1e-13);
        const Points moved = shaken(b.points);
        write_volume(folder / "n.vtu", file, moved);
        const VolumeFile again = read_volume(folder / "n.vtu");
        EXPECT_EQ(again.mesh.points, moved);
        EXPECT_EQ(again.mesh.faces.corners, file.mesh.faces.corners);
        EXPECT_EQ(again.bytes.find("InformationKey"), std::string::npos) << "ranges of other points";
        if (appended) {
            EXPECT_NE(again.bytes.find("AAAAAAAA"), std::string::npos);
        }
    }
}

TEST(VolumeFile, SaysWhatIsWrongAndWhere) {
    const TempFolder folder;
    const auto words = [](const auto& work) {
        try {
            work();
        } catch (const std::exception& e) {
            return std::string(e.what());
        }
        return std::string("nothing");
    };
    const auto refused = [&](const std::string& name, const std::string& bytes) {
        return words([&] { read_volume(folder.write(name, bytes)); });
    };
    const std::string su2 = su2_of(block(1)), foam = header("vectorField", "ascii");
    EXPECT_NE(refused("a.su2", "NDIME= 2\nNELEM= 1\n").find("a.su2:1: NDIME="), std::string::npos);
    EXPECT_NE(refused("b.su2", "NDIME= 3\nNELEM= 1\n10 0 1 2 9\nNPOIN= 1\n0 0 0\n").find("has point"),
              std::string::npos);
    EXPECT_NE(refused("c.su2", su2.substr(0, su2.size() / 2)), "nothing");
    EXPECT_NE(refused("points", "x").find("does not begin with FoamFile"), std::string::npos);
    EXPECT_NE(refused("points", foam + "9999999((0 0 0))").find("room for"), std::string::npos);
    EXPECT_NE(refused("points", foam + "2((0 0 0) (0 0 nan))").find("point 1 is not finite"), std::string::npos);
    EXPECT_NE(refused("points", foam + "2((0 0 0) (0 0))").find("coordinate of point 1"), std::string::npos);
    EXPECT_NE(refused("points", header("vectorField", "binary") + "3(aaaaaaaa)"), "nothing");
    EXPECT_NE(refused("a.vtu", "<VTKFile type=\"PolyData\">").find("must be UnstructuredGrid"), std::string::npos);
    EXPECT_NE(words([&] { read_volume(folder / "none"); }), "nothing");
    EXPECT_NE(words([&] { check_volume_output("o.vtu", "i.su2"); }).find("keeps its format"), std::string::npos);
    EXPECT_NE(words([&] { check_volume_output("o.vtu", folder.path()); }).find("keeps its format"), std::string::npos);
}

/// Every prefix of every format is read or refused, never more.
TEST(VolumeFile, TornFilesAreRefused) {
    const TempFolder folder;
    write_poly_mesh(folder, block(1), true);
    const std::string points = bytes_of(folder / "points"), su2 = su2_of(block(1)), vtu = vtu_of(block(1), true);
    for (const auto& [name, bytes] :
         {std::pair<std::string, std::string>{"points", points}, {"t.su2", su2}, {"t.vtu", vtu}})
        for (std::size_t n = 0; n < bytes.size(); n += 13) {
            try {
                read_volume(folder.write(name, bytes.substr(0, n)));
            } catch (const InputError&) {
            }
        }
}

}  // namespace
}  // namespace strake
