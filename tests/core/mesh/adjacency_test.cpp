#include "core/mesh/adjacency.hpp"
#include "core/mesh/geometry.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <algorithm>
#include <chrono>
#include <numbers>

using namespace strake;

TEST(Adjacency, ClosedSurfaceHasTwoTrianglesAtEveryEdge) {
    const TriMesh mesh = icosphere(2);
    const Adjacency adjacent = adjacency(mesh);
    EXPECT_EQ(mesh.num_vertices() - adjacent.num_edges() + mesh.num_triangles(), 2);
    for (int e = 0; e < adjacent.num_edges(); ++e) EXPECT_TRUE(adjacent.is_regular(e));
}

TEST(Adjacency, FlippedTriangleIsMisorientedAtItsThreeEdges) {
    TriMesh mesh = icosphere(1);
    std::swap(mesh.triangles(5, 0), mesh.triangles(5, 1));
    const Adjacency adjacent = adjacency(mesh);
    int count = 0;
    for (const char m : adjacent.misoriented) count += m;
    EXPECT_EQ(count, 3);
}

/// Walking over an edge from each of its triangles to each other one takes a minute here.
TEST(Adjacency, ComponentsOfManyTrianglesAtOneEdgeTakeNoTime) {
    const int n = 200'000;
    TriMesh book;
    book.vertices = Points::Zero(n + 5, 3);
    book.triangles.resize(n + 1, 3);
    for (int t = 0; t < n; ++t) book.triangles.row(t) << 0, 1, t + 2;
    book.triangles.row(n) << n + 2, n + 3, n + 4;  // apart
    const Adjacency adjacent = adjacency(book);
    const auto begin = std::chrono::steady_clock::now();
    const std::vector<int> component = edge_components(book, adjacent);
    EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(), 2);
    EXPECT_EQ(std::count(component.begin(), component.end(), 0), n);
    EXPECT_EQ(component[n], 1);
}

TEST(Geometry, VolumesAndAreasOfTheTestSurfaces) {
    EXPECT_NEAR(enclosed_volume(box_surface({2, 3, 4}, 3)), 24, 1e-12);
    EXPECT_NEAR(surface_area(box_surface({2, 3, 4}, 3)), 52, 1e-12);
    EXPECT_NEAR(enclosed_volume(icosphere(5)), 4 * std::numbers::pi / 3, 1e-2);
    EXPECT_NEAR(enclosed_volume(capped_cylinder(360, 2)), 2 * std::numbers::pi, 1e-3);
    TriMesh far = box_surface();
    far.vertices.rowwise() += Eigen::RowVector3d(1e7, 1e7, 1e7);
    EXPECT_NEAR(enclosed_volume(far), 1, 1e-6);
}
