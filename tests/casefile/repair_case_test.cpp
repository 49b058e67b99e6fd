#include "casefile/build/prepare_surface.hpp"
#include "core/mesh/adjacency.hpp"
#include "tests/casefile/build_fixture.hpp"

#include <algorithm>

namespace strake {
namespace {

/// An open box: four triangles of its top are missing, and one is turned.
TriMesh open_box() {
    TriMesh mesh = box_surface({1, 1, 1}, 4);
    mesh.triangles = mesh.triangles.topRows(mesh.num_triangles() - 4).eval();
    std::swap(mesh.triangles(40, 1), mesh.triangles(40, 2));
    return mesh;
}

TEST_F(BuildProblem, TheSurfaceIsMendedBeforeAnythingElse) {
    surface(open_box());
    const std::string rest =
        "fixed: [low]\nregions: {low: {box: [[-1, -1, -1], [2, 2, 0.3]]}}\nobjective: {maximize: volume}\n";
    EXPECT_TRUE(contains(error(rest, Purpose::run), "repair: {orient: true}"));
    const BuiltProblem built = build("repair: {orient: true, holes: 100%}\n" + rest, Purpose::run);
    EXPECT_TRUE(built.is_prepared);
    EXPECT_EQ(built.problem.surface.num_triangles(), 192);
    EXPECT_TRUE(contains(built.repairs_csv, "kind,vertex,triangle,x,y,z,size,triangles,words\norient,"));
    EXPECT_TRUE(contains(built.repairs_csv, "\nhole,"));
    ASSERT_FALSE(built.notes.empty());  // what was asked for and done is no warning
    EXPECT_EQ(built.notes[0], "repair: 1 orient, 1 hole");
    for (const std::string& words : built.warnings) EXPECT_FALSE(words.starts_with("repair:")) << words;
}

TEST_F(BuildProblem, HolesOfAnySizeAreClosedAsOnTheCommandLine) {
    surface(open_box());
    const std::string rest =
        "fixed: [low]\nregions: {low: {box: [[-1, -1, -1], [2, 2, 0.3]]}}\nobjective: {maximize: volume}\n";
    EXPECT_EQ(build("repair: {orient: true, holes: all}\n" + rest, Purpose::run).problem.surface.num_triangles(), 192);
    EXPECT_TRUE(contains(error("repair: {holes: any}\n" + rest), "repair.holes = any must be"));
}

TEST_F(BuildProblem, WithoutRepairNothingIsPrepared) {
    surface(box_surface());
    EXPECT_FALSE(build("").is_prepared);
    EXPECT_TRUE(build("").repairs_csv.empty());
}

TEST_F(BuildProblem, TriangleNumbersOfTheFileFollowTheRepair) {
    TriMesh mesh = box_surface({1, 1, 1}, 2);
    const Triangles twice = mesh.triangles;
    mesh.triangles.resize(twice.rows() + 1, 3);
    mesh.triangles << twice.topRows(5), twice.row(0), twice.bottomRows(twice.rows() - 5);  // number 5 is a copy
    surface(mesh);
    folder.write("t.txt", "4\n5\n6\n");
    const std::string rest = "regions: {some: {triangles: t.txt}}\nfixed: [some]\n";
    EXPECT_EQ(region(build("repair: {duplicates: true}\n" + rest), "some"), (std::vector<int>{4, 5}));
    EXPECT_TRUE(
        contains(error("repair: {duplicates: true}\nremesh: {edge_length: 40%}\n" + rest), "not valid after remesh"));
}

TEST_F(BuildProblem, TheSurfaceIsRemeshedAfterTheRepair) {
    surface(open_box());
    const BuiltProblem built = build(
        "repair: {all: true, holes: 100%}\nremesh: {edge_length: 0.1, angle: 30deg, iterations: 3}\n"
        "regions: {low: {box: [[-1, -1, -1], [2, 2, 0.3]]}}\nfixed: [low]\n");
    EXPECT_GT(built.problem.surface.num_triangles(), 800);
    const Adjacency adjacent = adjacency(built.problem.surface);
    for (int e = 0; e < adjacent.num_edges(); ++e) ASSERT_TRUE(adjacent.is_regular(e));
    EXPECT_TRUE(std::any_of(built.notes.begin(), built.notes.end(), [](const std::string& words) {
        return words.starts_with("remesh: 192 triangles replaced by ");
    }));
}

TEST_F(BuildProblem, RemeshingWithoutALengthTakesTheMeanEdge) {
    surface(open_box());
    const auto made = [&](const char* remesh) { return build(remesh).problem.surface; };
    const TriMesh said = made("remesh: {edge_length: auto, iterations: 2}\n"),
                  silent = made("remesh: {iterations: 2}\n");
    EXPECT_EQ(said.vertices, silent.vertices);
    EXPECT_EQ(said.triangles, silent.triangles);
    EXPECT_NE(said.num_triangles(), open_box().num_triangles());
}

TEST_F(BuildProblem, WhatDoesNotFitTheSurfaceIsAnErrorAtItsPlace) {
    surface(box_surface());
    EXPECT_TRUE(contains(error("repair: {components: {min_triangles: 1000}}\n"), "case.yaml:3:9: "));
    EXPECT_TRUE(contains(error("repair: {wled: 1}\n"), "did you mean 'weld'?"));
    EXPECT_TRUE(contains(error("repair: {cracks: 0}\n"), "repair.cracks"));
    EXPECT_TRUE(contains(error("repair: {fill: smooth}\n"), "fill"));
    EXPECT_TRUE(contains(error("remesh: {angle: 100deg}\n"), "remesh.angle"));
    EXPECT_TRUE(contains(error("remesh: {edge_length: 1e-9}\n"), "case.yaml:3:9: "));
}

}  // namespace
}  // namespace strake
