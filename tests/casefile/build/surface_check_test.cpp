#include "casefile/load_case.hpp"
#include "tests/casefile/build_fixture.hpp"

#include <cstdlib>

/// Surfaces that can be read, but not be deformed as they are.
namespace strake {
namespace {

TEST_F(BuildProblem, OpenSurfaceIsRefusedOnlyWhereVolumeIsAsked) {
    TriMesh open = box_surface();
    open.triangles.conservativeResize(11, 3);
    surface(open);
    const std::string levels = "parameters: {levels: [20deg]}\n";
    EXPECT_EQ(error(levels + "objective: {maximize: area}\n"), "");
    const std::string message = error(levels + "objective: {maximize: volume}\n");
    EXPECT_TRUE(contains(message, "s.obj: the surface cannot be used as it is")) << message;
    EXPECT_TRUE(contains(message, "3 open edges in 1 boundary loop (first: vertices ")) << message;
    EXPECT_TRUE(contains(message, "volume needs a closed surface")) << message;
}

TEST_F(BuildProblem, MisorientedNonManifoldAndDegenerateTrianglesAreNamed) {
    TriMesh flipped = box_surface();
    std::swap(flipped.triangles(4, 0), flipped.triangles(4, 1));
    surface(flipped);
    const std::string volume = "parameters: {levels: [20deg]}\nobjective: {maximize: volume}\n";
    EXPECT_TRUE(contains(error(volume), "3 edges with inconsistently oriented triangles (first: ver"));
    EXPECT_EQ(error("parameters: {levels: [20deg]}\n"), "");

    TriMesh fin = box_surface();
    fin.vertices.conservativeResize(9, 3);
    fin.vertices.row(8) << 2, 2, 2;
    fin.triangles.conservativeResize(13, 3);
    fin.triangles.row(12) << fin.triangles(0, 0), fin.triangles(0, 1), 8;
    surface(fin);
    EXPECT_TRUE(contains(error(""), "1 edge with more than two triangles (first: vertices "));
    EXPECT_EQ(error("shell: {nonmanifold: couple}\nparameters: {levels: [20deg]}\n"), "");

    TriMesh flat = box_surface();
    flat.triangles.conservativeResize(13, 3);
    flat.triangles.row(12) << 0, 0, 1;
    surface(flat);
    EXPECT_TRUE(contains(error(""), "1 triangle of zero area (12)")) << error("");
}

TEST_F(BuildProblem, CracksAreRefused) {
    const TriMesh left = strip(1, 1, 2, 2);
    TriMesh both = left;
    const int n = left.num_vertices(), m = left.num_triangles();
    both.vertices.conservativeResize(2 * n, 3);
    both.vertices.bottomRows(n) = left.vertices.rowwise() + Eigen::RowVector3d(1 + 1e-6, 0, 0);
    both.triangles.conservativeResize(2 * m, 3);
    both.triangles.bottomRows(m) = left.triangles.array() + n;
    surface(both);
    const std::string message = error("", Purpose::deform);
    EXPECT_TRUE(contains(message, "4 of 16 open edges lie on other ones (first: vertices ")) << message;
    EXPECT_TRUE(contains(message, "repair: {cracks: ")) << message;
    both.vertices.bottomRows(n).col(0).array() += 0.1;
    surface(both);
    EXPECT_EQ(error("", Purpose::deform), "");
}

TEST_F(BuildProblem, SymmetryNeedsOpenEdgesOnThePlane) {
    surface(box_surface());
    EXPECT_TRUE(contains(error("symmetry: {plane: y}\n", Purpose::deform),
                         "the surface is closed; remove symmetry for a full model"));
    surface(strip(1, 1, 2, 2));
    EXPECT_EQ(error("symmetry: {plane: y}\n", Purpose::deform), "");
    const std::string off = error("symmetry: {plane: y, at: 0.25}\n", Purpose::deform);
    EXPECT_TRUE(contains(off, "case.yaml:3:11: symmetry: no open edge on the symmetry plane")) << off;
    EXPECT_TRUE(contains(off, "at 0.25") && contains(off, "the open edges of the half lie between ")) << off;
}

TEST_F(BuildProblem, CessnaWingIsRefusedWithPlaceAndRemedy) {
    const char* data = std::getenv("STRAKE_DATA");
    if (!data) GTEST_SKIP() << "STRAKE_DATA is not set";  // the surfaces are not ours to ship
    const std::string file = std::string(data) + "/wing_c172_pygeo.stl";
    const auto yaml =
        folder.write("case.yaml", "case: c172\nsurface: {file: " + file +
                                      "}\nregions: {root: {box: [[-9, "
                                      "-9, -9], [9, 9, 0.3]]}}\nfixed: [root]\nobjective: {maximize: volume}\n");
    try {
        build_problem(load_case(yaml));
        FAIL() << "accepted";
    } catch (const SurfaceRefused& e) {
        const std::string message = e.what();
        EXPECT_TRUE(contains(message, "212 of 334 open edges lie on other ones (first: vertices 38-39, triangle 37"));
        EXPECT_TRUE(contains(message, "repair: {cracks: "));
        EXPECT_TRUE(contains(message, "4 edges with inconsistently oriented triangles")) << message;
        EXPECT_TRUE(contains(message, "334 open edges in 2 boundary loops")) << message;
    }
}

/// What is good enough to be deformed must not be refused.
TEST_F(BuildProblem, RealSurfacesAreAccepted) {
    const char* data = std::getenv("STRAKE_DATA");
    if (!data) GTEST_SKIP() << "STRAKE_DATA is not set";  // the surfaces are not ours to ship
    for (const char* name :
         {"wing717_pyhyp.ply", "zeroebwb_93k.ply", "bunny_closed_cgal.off", "oneraM6_pyhyp_small.ply",
          "supersonic_wing_body_pypan.stl", "dpw_w1_pypan.tri", "bunny70k_meshlab.ply"}) {
        const auto yaml =
            folder.write("case.yaml", std::string("case: c\nsurface: {file: ") + data + "/" + name + "}\n");
        EXPECT_NO_THROW(build_problem(load_case(yaml, Purpose::deform), Purpose::deform)) << name;
    }
}

}  // namespace
}  // namespace strake
