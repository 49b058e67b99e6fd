#include "core/remesh/remesh.hpp"

#include "cases/geometry/wing.hpp"
#include "measure.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>

#include <random>
#include <set>

using namespace strake;

namespace {

/// [-2, 2] x [-2, 2] with a square hole, and a round one of `sides` sides.
TriMesh plate_with_holes() {
    TriMesh mesh = strip(4, 4, 40, 40);
    const auto is_hole = [&](int t) {
        const Eigen::RowVector3d c =
            (mesh.vertices.row(mesh.triangles(t, 0)) + mesh.vertices.row(mesh.triangles(t, 1)) +
             mesh.vertices.row(mesh.triangles(t, 2))) /
            3;
        const bool square = c.x() > 0.5 && c.x() < 1.5 && c.y() > 0.5 && c.y() < 1.5;
        return square || (c - Eigen::RowVector3d(2.8, 2.8, 0)).norm() < 0.6;
    };
    int kept = 0;
    for (int t = 0; t < mesh.num_triangles(); ++t)
        if (!is_hole(t)) mesh.triangles.row(kept++) = mesh.triangles.row(t).eval();
    mesh.triangles.conservativeResize(kept, 3);
    return mesh;
}

/// A ball of 5120 triangles with eighty holes, and vertices off by `noise` edge lengths: like a scan.
TriMesh ball_with_holes(double noise) {
    TriMesh mesh = icosphere(4);
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> size(0.06, 0.18);
    std::vector<char> is_gone(static_cast<std::size_t>(mesh.num_triangles()), 0);
    for (int hole = 0; hole < 80; ++hole) {
        const Eigen::RowVector3d at = Eigen::RowVector3d(normal(random), normal(random), normal(random)).normalized();
        const double radius = size(random);
        for (int t = 0; t < mesh.num_triangles(); ++t)
            if ((mesh.vertices.row(mesh.triangles(t, 0)) - at).norm() < radius)
                is_gone[static_cast<std::size_t>(t)] = 1;
    }
    const double edge = (mesh.vertices.row(mesh.triangles(0, 0)) - mesh.vertices.row(mesh.triangles(0, 1))).norm();
    for (int v = 0; v < mesh.num_vertices(); ++v) mesh.vertices.row(v) *= 1 + noise * edge * normal(random);
    int kept = 0;
    for (int t = 0; t < mesh.num_triangles(); ++t)
        if (!is_gone[static_cast<std::size_t>(t)]) mesh.triangles.row(kept++) = mesh.triangles.row(t).eval();
    mesh.triangles.conservativeResize(kept, 3);
    return mesh;
}

bool has_vertex(const TriMesh& mesh, const Eigen::RowVector3d& p) {
    for (int v = 0; v < mesh.num_vertices(); ++v)
        if (mesh.vertices.row(v) == p) return true;
    return false;
}

}  // namespace

TEST(RemeshFeatures, BoxKeepsEdgesAndCornersToTheBit) {
    for (const int cells : {1, 7}) {
        const TriMesh mesh = box_surface({3, 2, 1}, cells);
        const RemeshResult result = remesh(mesh, {.edge_length = 0.15});
        EXPECT_EQ(result.corners, 8);
        const auto was = creases_of(mesh, 40), is = creases_of(result.mesh, 40);
        EXPECT_EQ(static_cast<int>(is.size()), result.crease_edges);
        EXPECT_LT(farthest(is, was, true), 1e-12);
        EXPECT_LT(farthest(was, is, true), 1e-12);
        for (const double x : {0.0, 3.0})
            for (const double y : {0.0, 2.0})
                for (const double z : {0.0, 1.0}) EXPECT_TRUE(has_vertex(result.mesh, {x, y, z}));
        EXPECT_LT(hausdorff(mesh, result.mesh), 1e-12);
        EXPECT_NEAR(enclosed_volume(result.mesh), 6, 1e-12);
        const Shape shape = shape_of(result.mesh);
        EXPECT_GT(shape.mean, 0.94);  // a fifth of the vertices lie on creases
        EXPECT_GT(shape.smallest, 0.3);
        EXPECT_TRUE(topology(result.mesh, adjacency(result.mesh)).closed);
    }
}

TEST(RemeshFeatures, RimsOfACylinderStayOnThePolygonWithinTheArc) {
    const TriMesh mesh = capped_cylinder(96, 20);
    const double l = 0.12;
    const RemeshResult result = remesh(mesh, {.edge_length = l});
    const auto was = creases_of(mesh, 40), is = creases_of(result.mesh, 40);
    ASSERT_GT(is.size(), 40u);
    EXPECT_LT(farthest(is, was, false), 1e-9);  // vertices
    const double allowed = std::max(1e-4 * box_diagonal(mesh), 1.35 * l * 1.35 * l / 8);
    EXPECT_LT(farthest(was, is, true), allowed);
    EXPECT_LT(farthest(is, was, true), allowed);
    EXPECT_EQ(result.corners, 0);
    EXPECT_GT(shape_of(result.mesh).smallest, 0.3);
}

TEST(RemeshFeatures, OpenBoundariesStayOnTheirPolygonsAndPlane) {
    const TriMesh mesh = plate_with_holes();
    ASSERT_EQ(topology(mesh, adjacency(mesh)).boundary_loops.size(), 3u);
    const RemeshResult result = remesh(mesh, {.edge_length = 0.07});
    EXPECT_EQ(topology(result.mesh, adjacency(result.mesh)).boundary_loops.size(), 3u);
    EXPECT_LT(farthest(boundary_of(result.mesh), boundary_of(mesh), false), 1e-12);
    EXPECT_LT(farthest(boundary_of(mesh), boundary_of(result.mesh), false), 1e-12);  // all of its corners are kept
    EXPECT_EQ(result.mesh.vertices.col(2).cwiseAbs().maxCoeff(), 0);
    EXPECT_NEAR(surface_area(result.mesh), surface_area(mesh), 1e-10);
    EXPECT_EQ(topology(result.mesh, adjacency(result.mesh)).components, 1);
    EXPECT_GT(shape_of(result.mesh).smallest, 0.2);
}

TEST(RemeshFeatures, KnifeEdgeAndSymmetryPlaneOfAWing) {
    const TriMesh mesh = example::wing(6000);
    const RemeshResult result = remesh(mesh);
    const auto was = creases_of(mesh, 40), is = creases_of(result.mesh, 40);
    ASSERT_GT(was.size(), 20u);
    EXPECT_LT(farthest(was, is, false), 1e-3 * box_diagonal(mesh));
    EXPECT_EQ(topology(result.mesh, adjacency(result.mesh)).boundary_loops.size(), 1u);
    for (const auto& edge : boundary_of(result.mesh))
        for (const auto& p : edge) EXPECT_EQ(p.y(), 0);
    EXPECT_LT(farthest(boundary_of(result.mesh), boundary_of(mesh), false), 1e-12);
    EXPECT_LT(hausdorff(mesh, result.mesh), 2e-3 * box_diagonal(mesh));
    const Intersections pairs = intersections(result.mesh);
    EXPECT_TRUE(pairs.apart.empty() && pairs.adjacent.empty());
    EXPECT_GT(shape_of(result.mesh).mean, 0.96);
}

TEST(RemeshFeatures, GroupsAreCarriedOverAndTheirBordersStay) {
    TriMesh mesh = icosphere(4);
    mesh.group_names = {"upper", "lower"};
    for (int t = 0; t < mesh.num_triangles(); ++t) mesh.group.push_back(triangle_centroids(mesh)(t, 2) < 0);
    const RemeshResult result = remesh(mesh, {.edge_length = 0.1});
    EXPECT_EQ(result.mesh.group_names, mesh.group_names);
    ASSERT_EQ(static_cast<int>(result.mesh.group.size()), result.mesh.num_triangles());
    EXPECT_GT(result.border_edges, 30);
    double area[2] = {0, 0}, was[2] = {0, 0};
    for (int t = 0; t < mesh.num_triangles(); ++t) was[mesh.group[t]] += area_vector(mesh, t).norm();
    for (int t = 0; t < result.mesh.num_triangles(); ++t)
        area[result.mesh.group[t]] += area_vector(result.mesh, t).norm();
    for (const int g : {0, 1}) EXPECT_NEAR(area[g], was[g], 0.01 * was[g]);
}

TEST(RemeshFeatures, PartsStayApart) {
    TriMesh mesh = icosphere(3);
    const TriMesh box = box_surface({1, 1, 1}, 3);
    const int n = mesh.num_vertices(), m = mesh.num_triangles();
    mesh.vertices.conservativeResize(n + box.num_vertices(), 3);
    mesh.vertices.bottomRows(box.num_vertices()) = box.vertices.rowwise() + Eigen::RowVector3d(1.01, -0.5, -0.5);
    mesh.triangles.conservativeResize(m + box.num_triangles(), 3);
    mesh.triangles.bottomRows(box.num_triangles()) = box.triangles.array() + n;
    const RemeshResult result = remesh(mesh, {.edge_length = 0.12});
    const TopologyFacts facts = topology(result.mesh, adjacency(result.mesh));
    EXPECT_EQ(facts.components, 2);
    EXPECT_TRUE(facts.closed);
    EXPECT_TRUE(intersections(result.mesh).apart.empty());
    EXPECT_EQ(result.corners, 8);
}

TEST(RemeshFeatures, EdgesOfThreeTrianglesStayAsTheyAre) {
    TriMesh mesh = strip(2, 1, 8, 4);  // a wall stands on the middle line
    const TriMesh wall = strip(1, 0.5, 4, 2);
    std::vector<int> number;
    std::vector<Eigen::RowVector3d> more;
    for (int v = 0; v < wall.num_vertices(); ++v) {
        const Eigen::RowVector3d p(1, wall.vertices(v, 0), wall.vertices(v, 1));
        int same = -1;
        for (int u = 0; u < mesh.num_vertices(); ++u)
            if (mesh.vertices.row(u) == p) same = u;
        number.push_back(same >= 0 ? same : mesh.num_vertices() + static_cast<int>(more.size()));
        if (same < 0) more.push_back(p);
    }
    const int n = mesh.num_vertices(), m = mesh.num_triangles();
    mesh.vertices.conservativeResize(n + more.size(), 3);
    for (std::size_t i = 0; i < more.size(); ++i) mesh.vertices.row(n + i) = more[i];
    mesh.triangles.conservativeResize(m + wall.num_triangles(), 3);
    for (int t = 0; t < wall.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k) mesh.triangles(m + t, k) = number[wall.triangles(t, k)];
    const TopologyFacts was = topology(mesh, adjacency(mesh));
    ASSERT_EQ(was.nonmanifold_edges.size(), 4u);
    const RemeshResult result = remesh(mesh, {.edge_length = 0.1});
    const TopologyFacts is = topology(result.mesh, adjacency(result.mesh));
    EXPECT_EQ(is.nonmanifold_edges.size(), 4u);
    EXPECT_EQ(is.components, was.components);
    EXPECT_EQ(result.kept_edges, 12);  // once for each side
    EXPECT_NEAR(surface_area(result.mesh), surface_area(mesh), 1e-12);
}

/// Corners of the holes keep edges short. Longer ones elsewhere must not hang on these as needles, which are split
/// again.
TEST(RemeshFeatures, ALongerLengthNeverMakesMoreTriangles) {
    for (const double noise : {0.0, 0.15, 0.3}) {
        const TriMesh mesh = ball_with_holes(noise);
        int least = std::numeric_limits<int>::max();
        for (const double length : {0.07, 0.1, 0.14, 0.2, 0.28, 0.4, 0.56}) {
            RemeshOptions options;
            options.edge_length = length;
            const RemeshResult result = remesh(mesh, options);
            EXPECT_LE(result.mesh.num_triangles(), 1.01 * least) << "noise " << noise << ", length " << length;
            least = std::min(least, result.mesh.num_triangles());
            if (length > 0.25) {
                const std::string words = short_edge_words(result);
                EXPECT_NE(words.find("open boundaries"), std::string::npos) << words;
                EXPECT_NE(words.find("strake repair --holes"), std::string::npos) << words;
            }
        }
    }
    RemeshOptions options;
    options.edge_length = 0.2;
    EXPECT_EQ(short_edge_words(remesh(icosphere(4), options)), "");
}
