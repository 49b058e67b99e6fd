#include "core/formats/io.hpp"
#include "core/text/file.hpp"

#include "core/error.hpp"
#include "core/formats/formats.hpp"
#include "core/formats/obj_skipped.hpp"
#include "core/formats/vtp.hpp"
#include "core/mesh/adjacency.hpp"
#include "core/mesh/geometry.hpp"
#include "core/mesh/temp_folder.hpp"
#include "derivatives.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <zlib.h>

#include <bit>
#include <clocale>
#include <cstring>
#include <locale>
#include <numeric>
#include <sstream>

namespace strake {
namespace {

constexpr SurfaceFormat all_formats[] = {SurfaceFormat::stl_binary, SurfaceFormat::stl_ascii,  SurfaceFormat::obj,
                                         SurfaceFormat::ply_ascii,  SurfaceFormat::ply_binary, SurfaceFormat::off,
                                         SurfaceFormat::tri,        SurfaceFormat::vtk,        SurfaceFormat::su2,
                                         SurfaceFormat::gmsh};

/// A sphere whose coordinates need all digits; vertices in the order in which triangles meet them, as STL has them.
TriMesh rough_sphere() {
    TriMesh mesh = icosphere(2);
    const Eigen::VectorXd r = random_vector(mesh.vertices.size(), 3);
    for (int i = 0; i < mesh.vertices.size(); ++i) mesh.vertices.data()[i] *= 1 + 1e-3 * r[i];
    mesh.vertices(0, 0) = 1.0 / 3 * 1e-300;
    mesh.vertices(1, 1) = 5e-324;
    std::vector<int> number(static_cast<std::size_t>(mesh.num_vertices()), -1);
    TriMesh ordered = mesh;
    int count = 0;
    for (int i = 0; i < mesh.triangles.size(); ++i) {
        int& n = number[mesh.triangles.data()[i]];
        if (n < 0) ordered.vertices.row(n = count++) = mesh.vertices.row(mesh.triangles.data()[i]);
        ordered.triangles.data()[i] = n;
    }
    return ordered;
}

SurfaceFile obj_of(const std::string& s) { return formats::read_obj(s, "f.obj"); }
SurfaceFile off_of(const std::string& s) { return formats::read_off(s, "f.off"); }
SurfaceFile ply_of(const std::string& s) { return formats::read_ply(s, "f.ply"); }
SurfaceFile stl_of(const std::string& s) { return formats::read_stl(s, "f.stl"); }
SurfaceFile tri_of(const std::string& s) { return formats::read_tri(s, "f.tri"); }

std::string with_crlf(const std::string& s) {
    std::string out;
    for (const char c : s) (c == '\n' ? out += '\r' : out) += c;
    return out;
}

TEST(SurfaceIo, RoundTripKeepsEveryBitInDoubleFormatsAndFloatsInBinaryStl) {
    const TempFolder folder;
    const TriMesh mesh = rough_sphere();
    for (const SurfaceFormat format : all_formats) {
        const auto file = folder / text("sphere", extension_of(format));
        write_surface(file, mesh, format);
        const SurfaceFile back = read_surface(file);
        EXPECT_EQ(back.format, format);
        EXPECT_EQ(back.mesh.triangles, mesh.triangles) << static_cast<int>(format);
        if (format == SurfaceFormat::stl_binary)
            EXPECT_EQ(back.mesh.vertices, mesh.vertices.cast<float>().cast<double>());
        else
            EXPECT_EQ(std::memcmp(back.mesh.vertices.data(), mesh.vertices.data(), 8 * mesh.vertices.size()), 0)
                << static_cast<int>(format);
    }
}

TEST(SurfaceIo, RoundTripKeepsGroupsWhereTheFormatHasThem) {
    const TempFolder folder;
    TriMesh mesh = box_surface();
    mesh.group = {2, 2, 0, 0, 1, 1, 0, 0, 2, 2, 1, 1};
    mesh.group_names = {"upper side", "2", "tail"};
    for (const SurfaceFormat format :
         {SurfaceFormat::stl_ascii, SurfaceFormat::obj, SurfaceFormat::tri, SurfaceFormat::su2, SurfaceFormat::gmsh,
          SurfaceFormat::nastran, SurfaceFormat::vtp}) {
        EXPECT_TRUE(keeps_parts(format));
        const auto file = folder / text("box", extension_of(format));
        write_surface(file, mesh, format);
        const TriMesh back = read_surface(file).mesh;
        ASSERT_EQ(back.group.size(), mesh.group.size());
        std::vector<std::size_t> order(mesh.group.size());
        std::iota(order.begin(), order.end(), 0);
        if (format == SurfaceFormat::su2)  // whose markers stand one after the other
            std::ranges::stable_sort(order, {}, [&](std::size_t t) { return mesh.group[t]; });
        for (std::size_t i = 0; i < order.size(); ++i) {
            const std::size_t t = order[i];
            EXPECT_EQ(back.triangles.row(static_cast<int>(i)), mesh.triangles.row(static_cast<int>(t)));
            const std::string& name = back.group_names[back.group[i]];
            const bool numbers = format == SurfaceFormat::tri || format == SurfaceFormat::nastran;
            const std::string& given = mesh.group_names[mesh.group[t]];
            const std::string word = format == SurfaceFormat::su2 && given == "upper side" ? "upper_side" : given;
            EXPECT_EQ(name, numbers ? std::to_string(mesh.group[t] + 1) : word);
        }
    }
    mesh.group_names = {"11", "7", "1012"};  // component numbers survive
    write_surface(folder / "box.tri", mesh, SurfaceFormat::tri);
    const TriMesh back = read_surface(folder / "box.tri").mesh;
    for (std::size_t t = 0; t < mesh.group.size(); ++t)
        EXPECT_EQ(back.group_names[back.group[t]], mesh.group_names[mesh.group[t]]);
}

template <class T>
std::string raw(const std::vector<T>& values) {
    return {reinterpret_cast<const char*>(values.data()), sizeof(T) * values.size()};
}

TEST(SurfaceIo, GmshVariants) {
    // A quadrilateral and a triangle of second order beside a point, a line and a tetrahedron; node 9 is in none.
    const std::string nodes =
        "$Nodes\n9\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n5 2 0 0\n6 1.5 0 0\n7 1.5 .5 0\n8 1 .5 0\n"
        "9 5 5 5\n$EndNodes\n";
    const std::string two =
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n1 4 \"edge\"\n2 4 \"upper side\"\n"
        "$EndPhysicalNames\n" +
        nodes +
        "$Elements\n5\n1 15 2 1 1 1\n2 1 2 4 1 1 2\n3 3 2 4 11 1 2 3 4\n"
        "4 9 3 0 12 7 2 5 3 6 7 8\n5 4 0 1 2 3 9\n$EndElements\n";
    for (const std::string& s : {two, with_crlf(two), "$Comments\nx\n$EndComments\n" + two}) {
        const SurfaceFile file = formats::read_gmsh(s, "f.msh");
        EXPECT_EQ(file.mesh.num_vertices(), 8);
        ASSERT_EQ(file.mesh.num_triangles(), 6);
        EXPECT_EQ(file.mesh.triangles.row(1), Eigen::RowVector3i(0, 2, 3));
        EXPECT_EQ(file.mesh.triangles.row(2), Eigen::RowVector3i(1, 5, 7));
        EXPECT_EQ(file.mesh.group, (std::vector<int>{0, 0, 1, 1, 1, 1}));
        EXPECT_EQ(file.mesh.group_names, (std::vector<std::string>{"upper side", "12"}));
        EXPECT_DOUBLE_EQ(surface_area(file.mesh), 1.5);
    }
    // 4.1 with a sparse numbering, parametric nodes and a surface with a physical group.
    const std::string four =
        "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n1 1 2 0\n1 0 0 0 0\n3 0 0 0 1 0 0 0 2 1 -1\n"
        "7 0 0 0 1 1 0 1 6 1 3\n8 0 0 0 1 1 0 0 0\n$EndEntities\n$Nodes\n2 4 10 40\n0 1 0 1\n10\n0 0 0\n"
        "2 7 1 3\n20\n30\n40\n1 0 0 .1 .2\n1 1 0 .1 .2\n0 1 0 .1 .2\n$EndNodes\n$Elements\n3 3 1 3\n"
        "1 3 1 1\n1 10 20\n2 7 2 1\n2 10 20 30\n2 8 2 1\n3 10 30 40\n$EndElements\n";
    const TriMesh square = formats::read_gmsh(four, "f.msh").mesh;
    EXPECT_EQ(square.num_vertices(), 4);
    EXPECT_EQ(square.group_names, (std::vector<std::string>{"6", "8"}));
    EXPECT_DOUBLE_EQ(surface_area(square), 1);
}

TEST(SurfaceIo, GmshBinaryVariants) {
    using Ints = std::vector<std::int32_t>;
    using Longs = std::vector<std::int64_t>;
    using Reals = std::vector<double>;
    std::string nodes, elements;
    const double corners[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
    for (int v = 0; v < 4; ++v) nodes += raw(Ints{v + 1}) + raw(Reals(corners + 3 * v, corners + 3 * v + 3));
    elements = raw(Ints{2, 2, 2, 1, 5, 5, 1, 2, 3, 2, 6, 6, 1, 3, 4});
    const std::string two = "$MeshFormat\n2.2 1 8\n" + raw(Ints{1}) + "\n$EndMeshFormat\n$Nodes\n4\n" + nodes +
                            "\n$EndNodes\n$Elements\n2\n" + elements + "\n$EndElements\n";
    const std::string four = "$MeshFormat\n4.1 1 8\n" + raw(Ints{1}) + "\n$EndMeshFormat\n$Nodes\n" +
                             raw(Longs{1, 4, 1, 4}) + raw(Ints{2, 5, 0}) + raw(Longs{4, 1, 2, 3, 4}) +
                             raw(Reals(corners, corners + 12)) + "\n$EndNodes\n$Elements\n" + raw(Longs{2, 2, 1, 2}) +
                             raw(Ints{2, 5, 2}) + raw(Longs{1, 1, 1, 2, 3}) + raw(Ints{2, 6, 2}) +
                             raw(Longs{1, 2, 1, 3, 4}) + "\n$EndElements\n";
    for (const std::string& s : {two, four}) {
        const TriMesh square = formats::read_gmsh(s, "f.msh").mesh;
        EXPECT_EQ(square.num_vertices(), 4);
        ASSERT_EQ(square.num_triangles(), 2);
        EXPECT_EQ(square.group_names, (std::vector<std::string>{"5", "6"}));
        EXPECT_DOUBLE_EQ(surface_area(square), 1);
    }
}

TEST(SurfaceIo, Su2Variants) {
    // A hexahedron's points are there for the volume; only those of the markers are kept.
    const std::string file =
        "% a mesh\nNDIME= 3\nNELEM= 1\n10 0 1 2 4 0\nNPOIN=5 5\n0 0 0 0\n1 0 0 1\n1 1 0 2 % last\n9 9 9 3\n0 1 0 4\n"
        "NMARK = 2\nMARKER_TAG= wall\nMARKER_ELEMS= 1\n9 0 1 2 4 0\nMARKER_TAG=far\nMARKER_ELEMS=1\n5 4 2 0\n"
        "FFD_NBOX= 1\nFFD_TAG= BOX\n1 2 3\n";
    for (const std::string& s : {file, with_crlf(file)}) {
        const TriMesh mesh = formats::read_su2(s, "f.su2").mesh;
        EXPECT_EQ(mesh.num_vertices(), 4);
        ASSERT_EQ(mesh.num_triangles(), 3);
        EXPECT_EQ(mesh.triangles.row(1), Eigen::RowVector3i(0, 2, 3));
        EXPECT_EQ(mesh.group, (std::vector<int>{0, 0, 1}));
        EXPECT_EQ(mesh.group_names, (std::vector<std::string>{"wall", "far"}));
    }
}

TEST(SurfaceIo, Su2MarkersMayStandBeforeThePoints) {
    const std::string head = "NDIME= 3\nNMARK= 1\nMARKER_TAG= wall\nMARKER_ELEMS= 2\n5 0 1 2\n",
                      points = "NPOIN= 3\n0 0 0 0\n1 0 0 1\n0 1 0 2\n";
    const TriMesh mesh = formats::read_su2(head + "5 2 1 0\n" + points, "f.su2").mesh;
    EXPECT_EQ(mesh.num_vertices(), 3);
    EXPECT_EQ(mesh.triangles.row(1), Eigen::RowVector3i(2, 1, 0));
    try {
        formats::read_su2(head + "5 2 1 3\n" + points, "f.su2");
        ADD_FAILURE() << "point 3 of 3 was accepted";
    } catch (const InputError& error) {
        EXPECT_STREQ(error.what(), "f.su2:6: point 3 of an element, limits 0 and 2");
    }
}

TEST(SurfaceIo, NastranFindsItsBulkDataHoweverTheyAreWritten) {
    const std::string cards = "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\nCTRIA3,1,1,1,2,3\n";
    for (const std::string head : {"", "$ no BEGIN BULK in here\n", "SOL 101\nCEND\nTITLE = GRID,1\n  begin  bulk\n",
                                   "cend\ngrid,1\nBegin,Bulk\n"})
        EXPECT_EQ(formats::read_nastran(head + cards, "f.nas").mesh.num_vertices(), 3) << head;
}

TEST(SurfaceIo, NastranRefusesCommasInFixedFields) {
    const std::string cards = "CTRIA3,1,1,1,2,3\nGRID,1,,0.,0.,0.\n   GRID,2,,1.,0.,0.\n";
    for (const std::string last :
         {"GRID           3              0.      1.     2,5\n",
          "GRID*                  3                              0.              1.\n*G3     2,5\n",
          "GRID*                  3                              0.              1.\n        2,5\n"}) {
        try {
            formats::read_nastran(cards + last, "f.nas");
            ADD_FAILURE() << last;
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()).find("'2,5'; decimals are written with a point"), std::string::npos)
                << error.what();
        }
    }
    EXPECT_EQ(formats::read_nastran(cards + "GRID*,3,,0.,1.\n        ,2.5\n", "f.nas").mesh.vertices(2, 2), 2.5);
}

/// Whatever the format, the triangles of a polygon cover it once and look the same way.
TEST(SurfaceIo, PolygonsThatAreNotConvexAreNotFolded) {
    const std::string arrow = "v 0 0 5\nv 2 -1 5\nv 0 3 5\nv -2 -1 5\n", offset =
                                                                             "v 100000000 0 0\nv 100000002 -1 0\n"
                                                                             "v 100000000 3 0\nv 99999998 -1 0\n";
    for (const std::string& points : {arrow, offset})
        for (const char* face : {"f 1 2 3 4", "f 2 3 4 1", "f 3 4 1 2", "f 4 1 2 3"}) {
            const TriMesh mesh = obj_of(points + face + "\n").mesh;
            ASSERT_EQ(mesh.num_triangles(), 2);
            EXPECT_DOUBLE_EQ(surface_area(mesh), 6) << face;
            for (int t = 0; t < 2; ++t) EXPECT_GT(area_vector(mesh, t).z(), 0) << face;
        }
    // Convex ones keep the fan from their first corner; a corner on a straight side makes no triangle without an area.
    EXPECT_EQ(obj_of("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 2 3 4 1\n").mesh.triangles.row(1),
              Eigen::RowVector3i(1, 3, 0));
    const TriMesh hanging = obj_of("v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 2 0\nf 1 2 3 4\n").mesh;
    EXPECT_DOUBLE_EQ(triangle_areas(hanging).minCoeff(), 1);
    // A comb of 400 corners, as text and in PLY with the faces first.
    std::string vertices, face;
    for (int i = 0; i < 100; ++i)
        vertices += text(4 * i, " 0 1\n", 4 * i + 1, " 0 1\n", 4 * i + 2, " 9 1\n", 4 * i + 3, " 9 1\n");
    vertices += "400 -1 1\n-1 -1 1\n";
    for (int i = 401; i >= 0; --i) face += text(" ", i);
    const TriMesh comb = ply_of(text("ply\nformat ascii 1.0\nelement face 1\nproperty list int int vertex_indices\n"
                                     "element vertex 402\nproperty double x\nproperty double y\nproperty double z\n"
                                     "end_header\n402",
                                     face, "\n", vertices))
                             .mesh;
    ASSERT_EQ(comb.num_triangles(), 400);
    double sum = 0;
    for (int t = 0; t < 400; ++t) sum += area_vector(comb, t).z();
    EXPECT_NEAR(surface_area(comb), std::abs(sum), 1e-9);
}

TEST(SurfaceIo, AnEditorsMarkBeforeTextIsReadOver) {
    const TempFolder folder;
    const std::string mark = "\xEF\xBB\xBF";
    for (const SurfaceFormat format : all_formats) {
        const std::string bytes = surface_bytes(box_surface(), format, "box");
        if (format == SurfaceFormat::stl_binary) continue;
        folder.write("box" + extension_of(format), mark + bytes);
        EXPECT_EQ(read_surface(folder / ("box" + extension_of(format))).mesh.num_triangles(), 12);
    }
    std::string header = surface_bytes(box_surface(), SurfaceFormat::stl_binary, "box");
    std::copy(mark.begin(), mark.end(), header.begin());  // whatever the header of a binary STL holds
    folder.write("binary.stl", header);
    EXPECT_EQ(read_surface(folder / "binary.stl").mesh.num_triangles(), 12);
}

TEST(SurfaceIo, NastranVariants) {
    // Fixed, long and free fields, exponents without E, continuations, points behind the elements.
    const std::string file =
        "SOL 101\nCEND\nTITLE = GRID\nBEGIN BULK\n$ a comment\nCQUAD4         1       7      10      20      30      "
        "40\n"
        "GRID          10             0.0      0.      0.\nGRID*                 20                         1.+0       "
        "       0.D0\n"
        "*                      "
        "0\nGRID,30,,1.,1.,\ngrid,40,0,0.,10.-1,0.\nGRID,50,,2.,0.,7.5E-0\nCTRIA3,2,,10,20,30\nMAT1,1,2.1+11,,.3\n"
        "ENDDATA\nrubbish";
    for (const std::string& s : {file, with_crlf(file)}) {
        const TriMesh mesh = formats::read_nastran(s, "f.nas").mesh;
        EXPECT_EQ(mesh.num_vertices(), 4);
        ASSERT_EQ(mesh.num_triangles(), 3);
        EXPECT_EQ(mesh.group_names, (std::vector<std::string>{"7", "2"}));
        EXPECT_EQ(mesh.triangles.row(1), Eigen::RowVector3i(0, 2, 3));
        EXPECT_EQ(mesh.vertices.row(3), Eigen::RowVector3d(0, 1, 0));
        EXPECT_EQ(mesh.vertices.row(1), Eigen::RowVector3d(1, 0, 0));
    }
    // 16 columns hold 10 digits or more.
    const TempFolder folder;
    TriMesh mesh = rough_sphere();
    mesh.vertices(0, 0) = -1.0 / 3 * 1e-7;
    mesh.vertices(1, 1) = -2.0 / 3 * 1e100;
    write_surface(folder / "s.bdf", mesh, SurfaceFormat::nastran);
    const TriMesh back = read_surface(folder / "s.bdf").mesh;
    EXPECT_EQ(back.triangles, mesh.triangles);
    for (int i = 0; i < mesh.vertices.size(); ++i)
        EXPECT_NEAR(back.vertices.data()[i], mesh.vertices.data()[i], 1e-9 * std::abs(mesh.vertices.data()[i]));
}

TEST(SurfaceIo, VtkVariants) {
    const std::string points = "POINTS 5 float\n0 0 0 1 0 0 1 1 0\n0 1 0 9 9 9\n";
    const std::string head = "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET ";
    const std::string old = head + "POLYDATA\n" + points +
                            "METADATA\nINFORMATION 0\n\nVERTICES 1 2\n1 0\n"
                            "POLYGONS 1 5\n4 0 1 2 3\nCELL_DATA 1\nSCALARS a int 1\nLOOKUP_TABLE default\n1\n";
    const std::string fresh = head + "POLYDATA\n" + points +
                              "POLYGONS 3 6\nOFFSETS vtktypeint64\n0 3 6\nCONNECTIVITY "
                              "vtktypeint64\n0 1 2\n0 2 3\n";
    const std::string strip = head + "POLYDATA\n" + points + "TRIANGLE_STRIPS 1 5\n4 0 1 3 2\n";
    const std::string grid = head + "UNSTRUCTURED_GRID\n" + points +
                             "CELLS 3 13\n3 0 1 2\n3 0 2 3\n4 0 1 2 4\n"
                             "CELL_TYPES 3\n5\n5\n10\n";
    for (const std::string& s : {old, fresh, strip, grid, with_crlf(old), with_crlf(fresh)}) {
        const TriMesh mesh = formats::read_vtk(s, "f.vtk").mesh;
        ASSERT_EQ(mesh.num_triangles(), 2) << s;
        EXPECT_DOUBLE_EQ(surface_area(mesh), 1) << s;
        EXPECT_TRUE(adjacency(mesh).num_edges() == 5) << s;
        EXPECT_EQ(triangle_normals(mesh), (Points(2, 3) << 0, 0, 1, 0, 0, 1).finished()) << s;
    }
}

TEST(SurfaceIo, PackedFilesAreUnpackedAndBombsRefused) {
    // gzip of "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
    const auto packed = [](const std::string& bytes) {
        std::string out(compressBound(bytes.size()) + 64, '\0');
        z_stream stream{};
        EXPECT_EQ(deflateInit2(&stream, 9, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY), Z_OK);
        stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
        stream.avail_in = static_cast<uInt>(bytes.size());
        stream.next_out = reinterpret_cast<Bytef*>(out.data());
        stream.avail_out = static_cast<uInt>(out.size());
        EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
        out.resize(stream.total_out);
        deflateEnd(&stream);
        return out;
    };
    const TempFolder folder;
    const std::string triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", whole = packed(triangle);
    const auto file = folder / "t.obj.gz";
    write_atomically(file, whole);
    EXPECT_EQ(read_surface(file).mesh.num_triangles(), 1);
    write_atomically(file, packed(triangle.substr(0, 10)) + packed(triangle.substr(10)));  // two members
    EXPECT_EQ(read_surface(file).mesh.num_triangles(), 1);
    const auto refusal = [&](const std::string& bytes) -> std::string {
        write_atomically(file, bytes);
        try {
            read_surface(file);
        } catch (const InputError& e) {
            return e.what();
        }
        return "";
    };
    for (std::size_t n = 1; n < whole.size(); ++n) EXPECT_NE(refusal(whole.substr(0, n)), "") << n;
    std::string damaged = whole;
    damaged[whole.size() - 6] ^= 1;  // the checksum
    EXPECT_NE(refusal(damaged).find("gzip"), std::string::npos);
    EXPECT_NE(refusal(packed(std::string(std::size_t{1} << 24, ' '))).find("1000 times"), std::string::npos);
    EXPECT_NE(refusal("v 0 0 0").find("gzip"), std::string::npos);
}

TEST(SurfaceIo, GroupNamesOfObjKeepTheirLine) {
    TriMesh mesh = rough_sphere();
    mesh.group_names = {"left\\", "tail #2"};
    mesh.group.assign(static_cast<std::size_t>(mesh.num_triangles()), 0);
    mesh.group.back() = 1;
    const TriMesh back = formats::read_obj(surface_bytes(mesh, SurfaceFormat::obj, "f"), "f").mesh;
    EXPECT_EQ(back.triangles, mesh.triangles);
    EXPECT_EQ(back.group, mesh.group);
    EXPECT_EQ(back.group_names, (std::vector<std::string>{"left_", "tail _2"}));
}

TEST(SurfaceIo, ObjVariants) {
    const std::string file =
        "# comment\nmtllib never_opened.mtl\no part\nv 0 0 0\nv 1 0 0 1.0\nv 1 1 0 0.5 0.5 0.5\nv 0 1 0\nvt 0 0\n"
        "vn 0 0 1\nusemtl red\ns off\nf 1/1/1 2//1 3/1 4 # quad\ng a  b\nf -4 -3 \\\n -2\n";
    for (const std::string& s : {file, with_crlf(file), "\n\n" + file}) {
        const TriMesh mesh = obj_of(s).mesh;
        EXPECT_EQ(mesh.num_vertices(), 4);
        ASSERT_EQ(mesh.num_triangles(), 3);
        EXPECT_EQ(mesh.triangles.row(1), Eigen::RowVector3i(0, 2, 3));
        EXPECT_EQ(mesh.triangles.row(2), Eigen::RowVector3i(0, 1, 2));
        EXPECT_EQ(mesh.group, (std::vector<int>{0, 0, 1}));
        EXPECT_EQ(mesh.group_names, (std::vector<std::string>{"part", "a  b"}));
    }
    EXPECT_EQ(obj_of("f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0").mesh.num_triangles(), 1);  // faces first, no line end
}

/// Curves and trimmed surfaces stand beside the triangles of some exporters.
TEST(SurfaceIo, FreeFormPartsOfObjAreSkippedWithACount) {
    const std::string plain = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    const std::string curves =
        "vp 0.5 1\ncstype rat bspline\ndeg 2 2\nstep 1 1\nbmat u 1 0 \\\n 0 1\ncurv2 1 2 3\ncurv 0 1 1 2\n"
        "surf 0 1 0 1 1 2 3\nparm u 0 1\ntrim 0 1 1\nhole 0 1 1\nscrv 0 1 1\nsp 1\nend\ncon 1 0 1 1 2 0 1 1\n"
        "ctech cparm 1\nstech cparma 1 1\nbzp 1 2\nres 1 1\ncall a.obj\ncsh ls\n";
    const TriMesh mesh = obj_of(plain + curves).mesh;
    EXPECT_EQ(mesh.num_vertices(), 3);
    EXPECT_EQ(mesh.num_triangles(), 1);
    EXPECT_EQ(formats::skipped_in_obj(plain + curves), "21 lines of free-form curves and surfaces (first: line 5)");
    EXPECT_EQ(formats::skipped_in_obj(plain), "");
    try {
        obj_of(curves);
        ADD_FAILURE() << "was read";
    } catch (const InputError& none) {
        EXPECT_STREQ(none.what(),
                     "f.obj: no faces, only 21 lines of free-form curves and surfaces (first: line 1); "
                     "export triangles");
    }
    EXPECT_THROW(obj_of(plain + "surface 1\n"), InputError);
}

TEST(SurfaceIo, PlyVariants) {
    const std::string ascii =
        "ply\nformat ascii 1.0\ncomment made by hand\nobj_info x\nelement camera 1\nproperty list uint8 float32 view\n"
        "element vertex 4\nproperty float confidence\nproperty double x\nproperty int16 y\nproperty float64 z\n"
        "element face 2\nproperty uchar red\nproperty list uchar uint vertex_index\nproperty list uchar float uv\n"
        "element edge 1\nproperty int vertex1\nend_header\n"
        "2 1 nan\nnan 0 0 0\n1 1 0 0.5\n1 1 1 0\n1 0 1 0\n7 4 0 1 2 3 0\n7 3 0 1 2 2 0.5 0.5\n3\n";
    std::string blank = ascii;
    blank.insert(blank.find("end_header") + 10, " \t");
    for (const std::string& s : {ascii, with_crlf(ascii), blank, with_crlf(blank)}) {
        const SurfaceFile surface = ply_of(s);
        EXPECT_EQ(surface.format, SurfaceFormat::ply_ascii);
        EXPECT_EQ(surface.mesh.num_vertices(), 4);
        EXPECT_EQ(surface.mesh.num_triangles(), 3);
        EXPECT_EQ(surface.mesh.vertices(1, 2), 0.5);
    }
}

TEST(SurfaceIo, PlyOfBothByteOrders) {
    for (const bool big : {false, true})
        for (const std::string line_end : {"\n", "\r\n", "\r"}) {
            std::string s = "ply" + line_end + "format binary_" + (big ? "big" : "little") + "_endian 1.0" + line_end;
            for (const char* line : {"element vertex 3", "property float x", "property float y", "property float z",
                                     "element face 1", "property list uchar ushort vertex_indices", "end_header"})
                s += line + line_end;
            const auto put = [&]<class T>(T value) {
                char raw[sizeof(T)];
                std::memcpy(raw, &value, sizeof(T));
                if (big) std::reverse(raw, raw + sizeof(T));
                s.append(raw, sizeof(T));
            };
            for (const float x : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 2.f, 10.f}) put(x);
            s += '\3';
            for (const std::uint16_t v : {0, 1, 2}) put(v);
            const TriMesh mesh = ply_of(s).mesh;
            EXPECT_EQ(mesh.vertices(2, 1), 2);
            EXPECT_EQ(mesh.triangles.row(0), Eigen::RowVector3i(0, 1, 2));
        }
}

TEST(SurfaceIo, OffVariants) {
    const std::string plain = "OFF # cube corner\n3 1 0\n0 0 0\n1 0 0\n\n# between\n0 1 0\n3 0 1 2 255 0 0\n";
    for (const std::string& s : {plain, with_crlf(plain), std::string("OFF 3 1\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2"),
                                 std::string("3 1 3\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"),
                                 std::string("COFF\n3 1 0\n0 0 0 1 0 0 1\n1 0 0 1 0 0 1\n0 1 0 1 0 0 1\n3 0 1 2\n"),
                                 std::string("NOFF\n3 1 0\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n3 0 1 2 0.5\n")}) {
        const TriMesh mesh = off_of(s).mesh;
        EXPECT_EQ(mesh.num_vertices(), 3);
        EXPECT_EQ(mesh.triangles.row(0), Eigen::RowVector3i(0, 1, 2));
    }
}

TEST(SurfaceIo, StlVariants) {
    const std::string facet =
        "FACET Normal nan nan nan\nouter LOOP\nvertex 0 0 0\nvertex +1.0E0 0 -0.0\nvertex 0 1. .0\nendloop\nendfacet\n";
    const std::string file = "Solid Tip of wing\n" + facet + "endsolid Tip of wing\n\nsolid\n" + facet + "endsolid\n";
    for (const std::string& s : {file, with_crlf(file)}) {
        const SurfaceFile surface = stl_of(s);
        EXPECT_EQ(surface.file_vertices, 6);
        EXPECT_EQ(surface.mesh.num_vertices(), 3);
        EXPECT_EQ(surface.mesh.num_triangles(), 2);
        EXPECT_EQ(surface.mesh.group_names, (std::vector<std::string>{"Tip of wing", "solid_2"}));
    }
    EXPECT_TRUE(stl_of("solid\n" + facet + "endsolid").mesh.group.empty());
    std::string binary = formats::stl_binary(icosphere(1), "f.stl");
    std::memcpy(binary.data(), "solid facet normal", 18);  // a header that looks like text
    EXPECT_EQ(stl_of(binary).format, SurfaceFormat::stl_binary);
    EXPECT_EQ(stl_of(binary).mesh.num_triangles(), 80);
}

TEST(SurfaceIo, StlWeldsZeroAndMinusZeroInTheOrderOfAppearance) {
    const std::string two =
        "solid\nfacet normal 0 0 1\nouter loop\nvertex 5 0 0\nvertex 6 0 0\nvertex 5 1 0\nendloop\nendfacet\n"
        "facet normal 0 0 1\nouter loop\nvertex 5 1 -0\nvertex 6 -0 0\nvertex 6 1 0\nendloop\nendfacet\nendsolid\n";
    const TriMesh mesh = stl_of(two).mesh;
    ASSERT_EQ(mesh.num_vertices(), 4);
    EXPECT_EQ(mesh.triangles.row(1), Eigen::RowVector3i(2, 1, 3));
    EXPECT_EQ(mesh.vertices.row(3), Eigen::RowVector3d(6, 1, 0));
}

TEST(SurfaceIo, TriVariants) {
    const std::string vertices = "0 0 0\n1.0D+00 0 0\n0 .1D1 0\n", faces = "1 2 3\n";
    EXPECT_EQ(tri_of(" 3  1\n" + vertices + faces).mesh.vertices(1, 0), 1);
    EXPECT_EQ(tri_of("3 1\r\n" + with_crlf(vertices + faces + "42\n")).mesh.group_names[0], "42");
    // Fortran breaks lines where it likes.
    EXPECT_EQ(tri_of("3 1\n0 0 0 1 0\n0 0 1 0 1 2 3 7\n").mesh.group_names[0], "7");
    // Nine columns a vertex.
    const TriMesh nine = tri_of("3 1\n0 0 0 9 9 9 1 1 1\n1 0 0 9 9 9 1 1 1\n0 1 0 9 9 9 1 1 1\n1 2 3\n1\n").mesh;
    EXPECT_EQ(nine.vertices.row(2), Eigen::RowVector3d(0, 1, 0));
}

TEST(SurfaceIo, TriRecordsOfBothByteOrdersAndPrecisions) {
    for (const bool big : {false, true})
        for (const bool doubles : {false, true}) {
            std::string s;
            const auto put = [&]<class T>(T value) {
                char raw[sizeof(T)];
                std::memcpy(raw, &value, sizeof(T));
                if (big) std::reverse(raw, raw + sizeof(T));
                s.append(raw, sizeof(T));
            };
            const auto integers = [&](std::initializer_list<int> values) {
                put(static_cast<int>(4 * values.size()));
                for (const int v : values) put(v);
                put(static_cast<int>(4 * values.size()));
            };
            integers({3, 1});
            put(doubles ? 72 : 36);
            for (const float x : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 2.f, 10.f})
                doubles ? put(static_cast<double>(x)) : put(x);
            put(doubles ? 72 : 36);
            integers({1, 2, 3});
            integers({5});
            const TriMesh mesh = tri_of(s).mesh;
            EXPECT_EQ(mesh.vertices(2, 2), 10);
            EXPECT_EQ(mesh.triangles.row(0), Eigen::RowVector3i(0, 1, 2));
            EXPECT_EQ(mesh.group_names, (std::vector<std::string>{"5"}));
        }
}

/// Numbers as written in German: 1.234,5.
struct GermanNumbers : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
};

TEST(SurfaceIo, NumbersDoNotDependOnTheLocale) {
    const TempFolder folder;
    const TriMesh mesh = icosphere(4);  // more than a thousand vertices
    const std::locale before = std::locale::global(std::locale(std::locale::classic(), new GermanNumbers));
    std::setlocale(LC_ALL, "de_DE.UTF-8");
    std::ostringstream in_force;
    in_force << 1234.5;
    EXPECT_EQ(in_force.str(), "1.234,5");
    for (const SurfaceFormat format : all_formats) {
        const auto file = folder / std::string("f").append(extension_of(format));
        write_surface(file, mesh, format);
        EXPECT_EQ(read_surface(file).mesh.num_triangles(), mesh.num_triangles());
    }
    write_vtp(folder / "f.vtp", mesh);
    EXPECT_NE(bytes_of(folder / "f.vtp").find("NumberOfPoints=\"2562\""), std::string::npos);
    std::locale::global(before);
}

TEST(SurfaceIo, LargePolygonsAndLongCommentsTakeNoTime) {
    std::string s = std::string("# ").append(2000000, 'x') + "\n", face = "f";
    for (int v = 0; v < 50000; ++v) {
        s += text("v ", v, " ", v % 7, " 0\n");
        face += text(" ", v + 1);
    }
    EXPECT_EQ(obj_of(s + face).mesh.num_triangles(), 49998);
}

TEST(SurfaceIo, ScaleAndOffsetKeepTheVolume) {
    for (const double offset : {0.0, 1e7}) {
        TriMesh cube = box_surface();
        cube.vertices.array() += offset;
        EXPECT_NEAR(enclosed_volume(tri_of(formats::tri(cube)).mesh), 1, 1e-6);
    }
}

TEST(SurfaceIo, FormatsHaveNames) {
    EXPECT_EQ(format_of("a/B.STL"), SurfaceFormat::stl_binary);
    EXPECT_EQ(format_named("stl-ascii"), SurfaceFormat::stl_ascii);
    EXPECT_THROW(format_of("a.step"), InvalidInput);
    EXPECT_THROW(format_named("step"), InvalidInput);
    for (const SurfaceFormat f : all_formats) EXPECT_EQ(extension_of(f)[0], '.');
}

}  // namespace
}  // namespace strake
