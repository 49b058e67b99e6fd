#include "core/remesh/remesh.hpp"

#include "measure.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>

using namespace strake;

namespace {

/// Copies of the outline at y = 0..span, joined; its ends stay open. The outline runs so that normals point outward.
TriMesh extruded(const std::vector<Eigen::Vector2d>& outline, double span, int cells) {
    const int n = static_cast<int>(outline.size());
    TriMesh mesh;
    mesh.vertices.resize(n * (cells + 1), 3);
    mesh.triangles.resize(2 * n * cells, 3);
    for (int j = 0; j <= cells; ++j)
        for (int i = 0; i < n; ++i) mesh.vertices.row(j * n + i) << outline[i].x(), span * j / cells, outline[i].y();
    for (int j = 0, t = 0; j < cells; ++j)
        for (int i = 0; i < n; ++i) {
            const int a = j * n + i, b = j * n + (i + 1) % n;
            mesh.triangles.row(t++) << a, b + n, b;
            mesh.triangles.row(t++) << a, a + n, b + n;
        }
    return mesh;
}

/// A lens of length 1 whose back is round: an arc of radius `back` in eight chords, none of them a crease at 40
/// degrees.
std::vector<Eigen::Vector2d> blunt_outline(double back) {
    constexpr int n = 40;
    const auto half_height = [&](int i) { return back + 0.24 * i * (n - i) / (n * n); };
    std::vector<Eigen::Vector2d> outline{{-0.01, 0}};
    for (int i = 0; i < n; ++i) outline.emplace_back(static_cast<double>(i) / n, -half_height(i));
    for (int i = 0; i <= 8; ++i)
        outline.emplace_back(1 + back * std::sin(i * std::numbers::pi / 8), -back * std::cos(i * std::numbers::pi / 8));
    for (int i = n - 1; i >= 0; --i) outline.emplace_back(static_cast<double>(i) / n, half_height(i));
    return outline;
}

/// Share of the vertices of `after` that are farther than `far` from every one of `before`.
double share_moved(const TriMesh& before, const TriMesh& after, double far) {
    int moved = 0;
    for (int v = 0; v < after.num_vertices(); ++v)
        moved += (before.vertices.rowwise() - after.vertices.row(v)).rowwise().squaredNorm().minCoeff() > far * far;
    return static_cast<double>(moved) / after.num_vertices();
}

TriMesh torus(int n, int m) {
    TriMesh mesh;
    mesh.vertices.resize(n * m, 3);
    mesh.triangles.resize(2 * n * m, 3);
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < m; ++j) {
            const double a = 2 * std::numbers::pi * i / n, b = 2 * std::numbers::pi * j / m, r = 1 + 0.3 * std::cos(b);
            mesh.vertices.row(i * m + j) << r * std::cos(a), r * std::sin(a), 0.3 * std::sin(b);
            const int next = (i + 1) % n * m;
            mesh.triangles.row(2 * (i * m + j)) << i * m + j, next + j, next + (j + 1) % m;
            mesh.triangles.row(2 * (i * m + j) + 1) << i * m + j, next + (j + 1) % m, i * m + (j + 1) % m;
        }
    return mesh;
}

TriMesh cone(int sides) {
    TriMesh mesh;
    mesh.vertices.resize(sides + 2, 3);
    mesh.triangles.resize(2 * sides, 3);
    mesh.vertices.row(sides) << 0, 0, 2;
    mesh.vertices.row(sides + 1) << 0, 0, 0;
    for (int i = 0; i < sides; ++i) {
        const double a = 2 * std::numbers::pi * i / sides;
        mesh.vertices.row(i) << 0.6 * std::cos(a), 0.6 * std::sin(a), 0;
        mesh.triangles.row(2 * i) << sides, i, (i + 1) % sides;
        mesh.triangles.row(2 * i + 1) << sides + 1, (i + 1) % sides, i;
    }
    return mesh;
}

}  // namespace

TEST(RemeshShapes, RoundedTrailingEdgeNarrowerThanTheEdgesLeavesNoSlivers) {
    const TriMesh mesh = extruded(blunt_outline(0.002), 1.5, 60);
    for (const auto& edge : creases_of(mesh, 40)) ASSERT_LT(edge[0].x(), 0.5);  // none at the back
    const RemeshResult result = remesh(mesh, {.edge_length = 0.04});
    const Shape shape = shape_of(result.mesh);
    EXPECT_GT(shape.smallest, 0.2);
    EXPECT_GT(shape.smallest_angle, 5);
    EXPECT_GT(shape.mean, 0.94);
    EXPECT_LT(hausdorff(mesh, result.mesh), 3e-3 * box_diagonal(mesh));
    EXPECT_EQ(result.new_intersections, 0);
}

TEST(RemeshShapes, TorusMeetsTheGoalsAndStaysWhenRemeshedAgain) {
    const TriMesh mesh = torus(110, 30);
    const RemeshResult once = remesh(mesh);
    const Shape shape = shape_of(once.mesh);
    expect_goals(shape);
    EXPECT_EQ(euler(once.mesh), 0);
    const RemeshResult twice = remesh(once.mesh, {.edge_length = once.edge_length});
    EXPECT_LT(share_moved(once.mesh, twice.mesh, 0.1 * once.edge_length), 0.02);
    EXPECT_GT(
        share_moved(once.mesh, remesh(mesh, {.edge_length = 0.9 * once.edge_length}).mesh, 0.1 * once.edge_length),
        0.5);  // the measure can tell
}

TEST(RemeshShapes, ShorterEdgesOfSharpBendsStayWhenRemeshedAgain) {
    std::vector<Eigen::Vector2d> outline;  // a plate with round ends
    for (const double end : {1.0, -1.0})
        for (int i = 0; i <= 24; ++i) {
            const double angle = std::numbers::pi * i / 24;
            outline.emplace_back(end * (1 + 0.06 * std::sin(angle)), -end * 0.06 * std::cos(angle));
            if (i == 24)
                for (int k = 1; k < 40; ++k) outline.emplace_back(end * (1 - 0.05 * k), end * 0.06);
        }
    const TriMesh mesh = extruded(outline, 2, 40);
    const RemeshResult once = remesh(mesh, {.edge_length = 0.12});
    ASSERT_LT(shape_of(once.mesh).mean_edge, 0.85 * once.edge_length);
    const double far = 0.1 * once.edge_length;
    const RemeshResult twice = remesh(once.mesh, {.edge_length = once.edge_length}), automatic = remesh(once.mesh);
    EXPECT_LT(share_moved(once.mesh, twice.mesh, far), 0.05);
    EXPECT_LT(share_moved(twice.mesh, once.mesh, far), 0.05);
    EXPECT_NEAR(automatic.edge_length, once.edge_length, 0.07 * once.edge_length);
    EXPECT_LT(share_moved(once.mesh, automatic.mesh, far), 0.05);
    for (const double factor : {0.85, 1.15}) {  // other lengths are followed
        const RemeshResult other = remesh(once.mesh, {.edge_length = factor * once.edge_length});
        EXPECT_GT(share_moved(once.mesh, other.mesh, far), 0.5);
    }
}

TEST(RemeshShapes, ShortEdgesOfBentRimsStayWhenRemeshedAgain) {
    constexpr int around = 160, rings = 48;  // a flat washer
    TriMesh mesh;
    mesh.vertices.resize(around * (rings + 1), 3);
    mesh.triangles.resize(2 * around * rings, 3);
    for (int j = 0; j <= rings; ++j)
        for (int i = 0; i < around; ++i) {
            const double angle = 2 * std::numbers::pi * i / around, r = 0.3 + 1.7 * j / rings;
            const int v = j * around + i, w = j * around + (i + 1) % around, t = 2 * v;
            mesh.vertices.row(v) << r * std::cos(angle), r * std::sin(angle), 0;
            if (j == rings) continue;
            mesh.triangles.row(t) << v, v + around, w;
            mesh.triangles.row(t + 1) << w, v + around, w + around;
        }
    const RemeshResult once = remesh(mesh, {.edge_length = 0.25});
    ASSERT_LT(shape_of(once.mesh).mean_edge, 0.97 * once.edge_length);
    const RemeshResult twice = remesh(once.mesh, {.edge_length = once.edge_length});
    const double far = 0.1 * once.edge_length;
    EXPECT_LT(share_moved(once.mesh, twice.mesh, far), 0.05);
    EXPECT_LT(share_moved(twice.mesh, once.mesh, far), 0.05);
}

TEST(RemeshShapes, NoiseDoesNotPassForShapeThatAsksForShortEdges) {
    TriMesh mesh = remesh(ellipsoid({1, 0.6, 0.4}, 4), {.edge_length = 0.05}).mesh;
    unsigned state = 1;
    for (double& x : mesh.vertices.reshaped())
        x += 0.012 * ((state = state * 1664525u + 1013904223u) / 4294967296.0 - 0.5) * 2;
    const RemeshResult coarse = remesh(mesh, {.edge_length = 0.1});
    EXPECT_LT(coarse.mesh.num_vertices(), 0.8 * mesh.num_vertices());
}

TEST(RemeshShapes, ApexOfAConeStaysAndItsFanGoes) {
    const TriMesh mesh = cone(64);
    const RemeshResult result = remesh(mesh, {.edge_length = 0.05});
    EXPECT_GT(shape_of(result.mesh).smallest, 0.2);
    EXPECT_LT((result.mesh.vertices.rowwise() - mesh.vertices.row(64)).rowwise().norm().minCoeff(), 1e-15);
    EXPECT_LT(farthest(creases_of(mesh, 40), creases_of(result.mesh, 40), false), 1e-3 * box_diagonal(mesh));
    const Adjacency adjacent = adjacency(result.mesh);
    int most = 0;
    for (int v = 0; v < result.mesh.num_vertices(); ++v)
        most = std::max(most, static_cast<int>(adjacent.vertex_triangles[v].size()));
    EXPECT_LT(most, 20);
}

TEST(RemeshShapes, CreaseFadingBelowTheAngleInBetweenIsOneCurve) {
    const auto roof = [](double dip) {  // of a dihedral of 57 degrees, two ribs of it of another slope
        TriMesh mesh = strip(20, 1, 20, 2, 0);
        for (int v = 0; v < mesh.num_vertices(); ++v)
            mesh.vertices(v, 2) =
                -std::tan(std::abs(mesh.vertices(v, 0) - 10.5) < 0.6 ? dip : 0.5) * std::abs(mesh.vertices(v, 1) - 0.5);
        return mesh;
    };
    const TriMesh mesh = roof(0.34);
    ASSERT_EQ(creases_of(mesh, 40).size(), 19u);  // one edge is of less than 40 degrees
    ASSERT_EQ(creases_of(roof(0.5), 40).size(), 20u);
    const RemeshResult result = remesh(mesh, {.edge_length = 0.3, .angle_deg = 40});
    EXPECT_EQ(result.corners, remesh(roof(0.5), {.edge_length = 0.3, .angle_deg = 40}).corners);
    EXPECT_LT(farthest(creases_of(mesh, 40), creases_of(result.mesh, 20), true), 1e-9);
    EXPECT_GT(remesh(roof(0.1), {.edge_length = 0.3, .angle_deg = 40}).corners, result.corners);  // a gap ends it
}

TEST(RemeshShapes, PartsThatTouchAlongEdgesKeepTouching) {
    TriMesh mesh = box_surface({1, 1, 1}, 3);  // and a sheet whose border lies on one edge of the box, unshared
    const TriMesh sheet = strip(1, 0.7, 3, 2);
    const int n = mesh.num_vertices(), m = mesh.num_triangles();
    mesh.vertices.conservativeResize(n + sheet.num_vertices(), 3);
    mesh.triangles.conservativeResize(m + sheet.num_triangles(), 3);
    for (int v = 0; v < sheet.num_vertices(); ++v)
        mesh.vertices.row(n + v) << sheet.vertices(v, 0), 1 + sheet.vertices(v, 1), 1 + 0.5 * sheet.vertices(v, 1);
    mesh.triangles.bottomRows(sheet.num_triangles()) = sheet.triangles.array() + n;
    const RemeshResult result = remesh(mesh, {.edge_length = 0.15});
    EXPECT_GT(result.kept_edges, 0);
    const Intersections before = intersections(mesh), after = intersections(result.mesh);
    EXPECT_EQ(after.apart.size() + after.adjacent.size(), before.apart.size() + before.adjacent.size());
}

TEST(RemeshShapes, NumberingChangesLittle) {
    const TriMesh mesh = torus(60, 20);
    const Shape one = shape_of(remesh(mesh).mesh), other = shape_of(remesh(renumbered(mesh, 5)).mesh);
    EXPECT_NEAR(one.mean, other.mean, 0.01);
    EXPECT_NEAR(one.mean_edge, other.mean_edge, 0.03 * one.mean_edge);
}

TEST(RemeshShapes, ThinWiresOfLongNeedlesEnd) {
    // Prisms of length 400 and width 0.05: the length wanted is far from both.
    const TriMesh mesh = extruded({{0, 0}, {0.05, 0}, {0.05, 0.05}, {0, 0.05}}, 400, 1);
    const RemeshResult result = remesh(mesh, {.edge_length = 1});
    EXPECT_EQ(topology(result.mesh, adjacency(result.mesh)).boundary_loops.size(), 2u);
    EXPECT_LT(result.mesh.num_triangles(), 200'000);
    EXPECT_NEAR(surface_area(result.mesh), 80, 1e-9);
}

/// A cylinder with one edge folded by 34 degrees, below the angle of creases.
TEST(RemeshShapes, FoldBelowTheAngleIsFollowed) {
    const double half = 17 * std::numbers::pi / 180;
    std::vector<Eigen::Vector2d> outline{{1 / std::cos(half), 0}};
    for (int i = 0; i <= 120; ++i) {
        const double angle = half + i * (2 * std::numbers::pi - 2 * half) / 120;
        outline.emplace_back(std::cos(angle), std::sin(angle));
    }
    const TriMesh body = extruded(outline, 1.0, 12);
    const TriMesh made = remesh(body, {.edge_length = 0.15}).mesh;
    const ClosestPointTree tree(made);
    double farthest = 0;
    for (int i = 0; i <= 100; ++i) farthest = std::max(farthest, tree.find({outline[0].x(), i / 100.0, 0}).distance);
    EXPECT_LT(farthest, 0.05 * 0.15);
}
