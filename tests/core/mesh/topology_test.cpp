#include "core/mesh/topology.hpp"

#include "surfaces.hpp"

#include <gtest/gtest.h>

namespace strake {
namespace {

TriMesh surface(std::initializer_list<Eigen::Vector3d> vertices, std::initializer_list<Eigen::Vector3i> triangles) {
    TriMesh mesh;
    mesh.vertices.resize(static_cast<Eigen::Index>(vertices.size()), 3);
    mesh.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
    int i = 0;
    for (const auto& v : vertices) mesh.vertices.row(i++) = v;
    i = 0;
    for (const auto& t : triangles) mesh.triangles.row(i++) = t;
    return mesh;
}

TopologyFacts facts_of(const TriMesh& mesh) { return topology(mesh, adjacency(mesh)); }

TEST(Topology, AClosedSphereHasNoDefect) {
    const TopologyFacts f = facts_of(icosphere(2));
    EXPECT_TRUE(f.closed);
    EXPECT_TRUE(f.orientable);
    EXPECT_EQ(f.components, 1);
    EXPECT_TRUE(f.boundary_loops.empty() && f.nonmanifold_edges.empty() && f.nonmanifold_vertices.empty() &&
                f.misoriented_edges.empty() && f.duplicate_triangles.empty() && f.degenerate_triangles.empty() &&
                f.isolated_vertices.empty() && f.duplicate_vertices.empty());
}

TEST(Topology, AStripHasOneLoopOfItsOuterVertices) {
    const TopologyFacts f = facts_of(strip(2, 1, 4, 2, 0));
    ASSERT_EQ(f.boundary_loops.size(), 1u);
    EXPECT_EQ(f.boundary_loops[0].size(), 12u);
    EXPECT_FALSE(f.closed);
}

TEST(Topology, LoopsThatTouchInAVertexAreOneBoundary) {
    // Two triangles that share a vertex only: one component of vertices, a pinched one.
    const TriMesh mesh = surface({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}}, {{0, 1, 2}, {0, 3, 4}});
    const TopologyFacts f = facts_of(mesh);
    EXPECT_EQ(f.components, 2);
    ASSERT_EQ(f.boundary_loops.size(), 1u);
    EXPECT_EQ(f.boundary_loops[0].size(), 6u);
    EXPECT_EQ(f.nonmanifold_vertices, std::vector<int>{0});
}

TEST(Topology, ThreeTrianglesAtAnEdgeAreNamed) {
    const TriMesh mesh = surface({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, -1, 0}, {5, 5, 5}, {1, 0, -0.0}},
                                 {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}});
    const TopologyFacts f = facts_of(mesh);
    EXPECT_EQ(f.nonmanifold_edges, std::vector<int>{0});
    EXPECT_EQ(f.nonmanifold_vertices, (std::vector<int>{0, 1}));
    EXPECT_EQ(f.isolated_vertices, (std::vector<int>{5, 6}));
    EXPECT_EQ(f.duplicate_vertices, std::vector<int>{6});
}

TEST(Topology, OrientationDuplicatesAndDegenerates) {
    TriMesh mesh = icosphere(0);
    mesh.triangles.row(7).reverseInPlace();
    TopologyFacts f = facts_of(mesh);
    EXPECT_EQ(f.misoriented_edges.size(), 3u);
    EXPECT_TRUE(f.orientable);
    EXPECT_FALSE(f.closed);
    mesh.triangles.row(9) = mesh.triangles.row(4);
    mesh.triangles(11, 0) = mesh.triangles(11, 1);
    f = facts_of(mesh);
    EXPECT_EQ(f.duplicate_triangles, std::vector<int>{9});
    EXPECT_EQ(f.degenerate_triangles, std::vector<int>{11});
}

TEST(Topology, AMoebiusBandIsNotOrientable) {
    const int n = 8;
    TriMesh mesh;
    mesh.vertices.resize(2 * n, 3);
    mesh.triangles.resize(2 * n, 3);
    for (int i = 0; i < n; ++i) {
        const double a = 2 * M_PI * i / n;
        for (const int s : {0, 1}) {
            const double r = 1 + 0.3 * (2 * s - 1) * std::cos(a / 2);
            mesh.vertices.row(2 * i + s) << r * std::cos(a), r * std::sin(a), 0.3 * (2 * s - 1) * std::sin(a / 2);
        }
        const bool last = i == n - 1;
        const int c = last ? 1 : 2 * i + 2, d = last ? 0 : 2 * i + 3;
        mesh.triangles.row(2 * i) << 2 * i, c, 2 * i + 1;
        mesh.triangles.row(2 * i + 1) << 2 * i + 1, c, d;
    }
    const TopologyFacts f = facts_of(mesh);
    EXPECT_FALSE(f.orientable);
    EXPECT_EQ(f.boundary_loops.size(), 1u);
    EXPECT_EQ(f.misoriented_edges.size(), 1u);
}

TEST(Topology, VerdictsDoNotDependOnScaleOrOffset) {
    for (const double scale : {1e-9, 1.0, 1e12})
        for (const double offset : {0.0, 1e7}) {
            TriMesh mesh = box_surface(Eigen::Vector3d::Ones(), 3);
            mesh.vertices = ((mesh.vertices.array() + offset) * scale).matrix();
            const TopologyFacts f = facts_of(mesh);
            EXPECT_TRUE(f.closed);
            EXPECT_TRUE(f.degenerate_triangles.empty());
            EXPECT_TRUE(self_intersections(mesh).empty());
        }
}

TEST(SelfIntersections, NamesThePairThatPierces) {
    TriMesh mesh = surface({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.2, 0.2, -1}, {0.2, 0.2, 1}, {0.9, 0.9, 0}},
                           {{0, 1, 2}, {3, 4, 5}});
    EXPECT_EQ(self_intersections(mesh), (std::vector<std::array<int, 2>>{{0, 1}}));
    mesh.vertices.row(3) << 0.6, 0.6, -1;
    mesh.vertices.row(4) << 0.6, 0.6, 1;
    EXPECT_TRUE(self_intersections(mesh).empty());
}

TEST(SelfIntersections, TouchingIsIntersecting) {
    const TriMesh mesh =
        surface({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.25, 0.25, 0}, {0, 0, 1}, {1, 0, 1}}, {{0, 1, 2}, {3, 4, 5}});
    EXPECT_EQ(self_intersections(mesh).size(), 1u);
}

TEST(SelfIntersections, SeamsOfEqualCoordinatesAreShared) {
    const TriMesh mesh =
        surface({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, {{0, 1, 2}, {4, 3, 5}});
    const Intersections found = intersections(mesh);
    EXPECT_TRUE(found.apart.empty() && found.adjacent.empty());
}

TEST(SelfIntersections, NeighboursThatOverlapAreToldApart) {
    // Folded flat over the common edge; then pierced beside the common vertex.
    const TriMesh folded = surface({{0, 0, 0}, {1, 0, 0}, {0.2, 1, 0}, {0.6, 0.5, 0}}, {{0, 1, 2}, {1, 0, 3}});
    EXPECT_EQ(intersections(folded).adjacent.size(), 1u);
    const TriMesh pierced =
        surface({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3, 0.3, -1}, {0.3, 0.3, 1}}, {{0, 1, 2}, {0, 3, 4}});
    const Intersections found = intersections(pierced);
    EXPECT_TRUE(found.apart.empty());
    EXPECT_EQ(found.adjacent, (std::vector<std::array<int, 2>>{{0, 1}}));
    EXPECT_TRUE(intersections(icosphere(1)).adjacent.empty());
}

TEST(SelfIntersections, TwoSpheresIntersectWhereTheyMeet) {
    const TriMesh a = icosphere(2);
    TriMesh both;
    both.vertices.resize(2 * a.num_vertices(), 3);
    both.vertices << a.vertices, (a.vertices.rowwise() + Eigen::RowVector3d(1.1, 0.05, 0.02));
    both.triangles.resize(2 * a.num_triangles(), 3);
    both.triangles << a.triangles, (a.triangles.array() + a.num_vertices()).matrix();
    const auto pairs = self_intersections(both);
    EXPECT_GT(pairs.size(), 20u);
    EXPECT_TRUE(std::is_sorted(pairs.begin(), pairs.end()));
    for (const auto& [s, t] : pairs) EXPECT_TRUE(s < a.num_triangles() && t >= a.num_triangles());
}

}  // namespace
}  // namespace strake
