#include "cli/run_strake.hpp"
#include "core/formats/formats.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>

/// Broken surface files through the real program: one precise message on stderr, status 3, nothing on stdout.
namespace strake {
namespace {

struct Broken {
    std::string name, bytes;
    std::string message;  ///< behind the file's path
};

std::vector<Broken> broken_files() {
    const std::string xyz = "0 0 0\n1 0 0\n0 1 0\n", v = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    const std::string ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n";
    const std::string stl = formats::stl_binary(icosphere(0), ""), bin = formats::ply(icosphere(0), true);
    return {
        {"comma.off", "OFF\n3 1 0\n0 0 0\n1,5 0 0\n0 1 0\n3 0 1 2\n",
         ":4: expected a number (coordinate of a vertex), got '1,5'; decimals are written with a point"},
        {"nan.tri", "3 1\n0 0 0\n1 0 nan\n0 1 0\n1 2 3\n", ":3: coordinate of a vertex: 'nan' is not a finite number"},
        {"huge.obj", "v 1e400 0 0\n",
         ":1: coordinate of a vertex: '1e400' is outside the range of double precision (1.8e308)"},
        {"index.obj", v + "f 1 2 9\n", ":4: vertex number 9 of a face: the file has 3 vertices"},
        {"zero.obj", v + "f 0 1 2\n", ":4: a face has the vertex number 0; OBJ counts from 1"},
        {"index.tri", "3 1\n" + xyz + "1 2 4\n", ":5: corner 4 of a triangle, limits 1 and 3"},
        {"short.tri", "3 2\n" + xyz + "1 2 3\n",
         ":5: 3 vertices of 3 numbers and 2 triangles need 15 numbers, or 17 with component numbers; the file has 12 "
         "after the header"},
        {"bomb.off", "OFF\n2000000000 1 0\n0 0 0\n",
         ":2: the header announces 2000000000 vertices, the 7 bytes that follow have room for at most 1"},
        {"no_z.ply",
         ply + "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0\n1 0\n0 1\n3 0 1 2\n",
         ":8: element 'vertex' with properties x, y and z expected"},
        {"points.ply", ply + "property float z\nend_header\n" + xyz,
         ":7: element 'face' with a list property 'vertex_indices' expected"},
        {"cut.stl", stl.substr(0, 500),
         ": byte 80: the header announces 20 triangles, that is 1084 bytes, the file has 500"},
        {"cut.ply", bin.substr(0, bin.size() - 3),
         ": byte " + std::to_string(bin.size() - 12) +
             " (face 19): list 'vertex_indices' of 3 values, the 9 bytes that follow have no room for it"},
        {"cut_ascii.stl", "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n",
         ":4: expected 'vertex', got the end of the file"},
        {"text.stl", "this is not a surface, but long enough to have the 84 bytes of a header, is it not so?\n",
         ": byte 80: the header announces"},
        {"empty.off", "", ": the file is empty"},
        {"nothing.obj", "# only a comment\n", ": holds no triangles (0 vertices)"},
        {"model.step", "ISO-10303-21;\n",
         ": not a known surface format: extension '.step'; known are .stl .obj .ply .off .tri .vtk .vtp .su2 .msh .nas "
         ".bdf .dat"},
    };
}

void expect_refused(const std::string& file, const std::string& message) {
    const ProgramRun run = run_strake({"info", file});
    EXPECT_EQ(run.status, 3) << file;
    EXPECT_EQ(run.out, "") << file;
    EXPECT_EQ(run.err.rfind("strake: " + file + message, 0), 0u) << run.err << "expected: " << message;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
}

TEST(BrokenSurface, EachGivesOnePreciseMessageAndStatusThree) {
    const TempFolder folder;
    for (const Broken& broken : broken_files())
        expect_refused(folder.write(broken.name, broken.bytes).string(), broken.message);
}

TEST(BrokenSurface, NotARegularFile) {
    const TempFolder folder;
    ASSERT_EQ(mkfifo((folder / "pipe.stl").c_str(), 0600), 0);
    expect_refused((folder / "pipe.stl").string(), ": cannot read: is a pipe, not a regular file");
    expect_refused(folder.path().string(), ": cannot read: is a directory, not a regular file");
    expect_refused((folder / "none.stl").string(), ": cannot read: No such file or directory");
}

}  // namespace
}  // namespace strake
