#include "cases/geometry/waverider.hpp"
#include "core/remesh/prepare_base.hpp"
#include "core/remesh/remesh.hpp"

#include "measure.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>

using namespace strake;

namespace {

TriMesh mesh_of(const std::vector<Eigen::Vector3d>& points, const std::vector<std::array<int, 3>>& triangles) {
    TriMesh mesh;
    mesh.vertices.resize(static_cast<Eigen::Index>(points.size()), 3);
    mesh.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
    for (std::size_t v = 0; v < points.size(); ++v) mesh.vertices.row(v) = points[v];
    for (std::size_t t = 0; t < triangles.size(); ++t)
        mesh.triangles.row(t) << triangles[t][0], triangles[t][1], triangles[t][2];
    return mesh;
}

/// A wing without thickness at its edges, x = 0 and x = 1; the cells there are a hundredth of their length wide. If
/// wanted, the diagonal of each third cell is cut a thousandth from its end at the edge.
TriMesh knife_edge(bool with_needles) {
    constexpr int n = 24, cells = 14;
    std::vector<Eigen::Vector3d> points;
    std::vector<std::array<int, 3>> triangles;
    for (int s = 0; s <= cells; ++s)
        for (int i = 0; i < 2 * n; ++i) {
            const double x = 0.5 * (1 + std::cos(std::numbers::pi * i / n));
            points.emplace_back(x, 0.4 * s, (i <= n ? 0.2 : -0.2) * x * (1 - x));
        }
    for (int s = 0; s < cells; ++s)
        for (int i = 0; i < 2 * n; ++i) {
            const int a = s * 2 * n + i, b = s * 2 * n + (i + 1) % (2 * n);
            if (with_needles && i == 0 && s % 3 == 1) {
                const int m = static_cast<int>(points.size());
                points.push_back((1 - 1e-3) * points[a] + 1e-3 * points[b + 2 * n]);
                for (const auto& t : {std::array<int, 3>{a, m, b}, {m, b + 2 * n, b}, {a, a + 2 * n, m}})
                    triangles.push_back(t);
                triangles.push_back({m, a + 2 * n, b + 2 * n});
                continue;
            }
            triangles.push_back({a, b + 2 * n, b});
            triangles.push_back({a, a + 2 * n, b + 2 * n});
        }
    return mesh_of(points, triangles);
}

double off_the_edges(const Eigen::Vector3d& x) { return std::min(std::abs(x.x()), std::abs(x.x() - 1)); }

/// A sheet that bends a little, with slivers folded over their longest sides.
TriMesh sheet_with_folded_slivers() {
    const TriMesh sheet = strip(10, 10, 40, 40);
    std::vector<Eigen::Vector3d> points;
    std::vector<std::array<int, 3>> triangles;
    for (int v = 0; v < sheet.num_vertices(); ++v) {
        const double x = sheet.vertices(v, 0), y = sheet.vertices(v, 1);
        points.emplace_back(x, y, 0.02 * (x * x + x * y));
    }
    for (int t = 0; t < sheet.num_triangles(); ++t) {
        const int a = sheet.triangles(t, 0), b = sheet.triangles(t, 1), c = sheet.triangles(t, 2);
        if (t % 97 != 40) {
            triangles.push_back({a, b, c});
            continue;
        }
        const int m = static_cast<int>(points.size());
        const Eigen::Vector3d ab = points[b] - points[a], ac = points[c] - points[a];
        const Eigen::Vector3d normal = ab.cross(ac).normalized(), out = ab.cross(normal).normalized();
        points.push_back(points[a] + 0.4 * ab + 0.02 * ab.norm() * (out + 0.5 * normal));
        triangles.push_back({a, b, m});
        triangles.push_back({b, c, m});
        triangles.push_back({c, a, m});
    }
    return mesh_of(points, triangles);
}

/// A ruled surface that twists by a quarter, cut into slivers from one end to the other.
TriMesh bellows() {
    constexpr int n = 20;
    std::vector<Eigen::Vector3d> points;
    std::vector<std::array<int, 3>> triangles;
    for (int k = 0; k <= n; ++k) points.emplace_back(0, 0.001 * k, 0);
    for (int k = 0; k <= n; ++k) points.emplace_back(1, 0, 0.004 * k);
    for (int k = 0; k < n; ++k) {
        triangles.push_back({k, n + 1 + k, k + 1});
        triangles.push_back({k + 1, n + 1 + k, n + 2 + k});
    }
    return mesh_of(points, triangles);
}

/// A cone to x = 8 with a flat base, half an ellipse above and a flatter one below: where it is thin its sides are
/// rounded edges, and the middle of their bend wanders from one meridian to the next.
TriMesh cone_with_flat_belly(int rings, int meridians) {
    std::vector<Eigen::Vector3d> points{{0, 0, 0}};
    std::vector<std::array<int, 3>> triangles;
    const auto at = [&](int i, int j) { return 1 + i * meridians + j % meridians; };
    constexpr int of_base = 4;
    for (int i = 0; i < rings + of_base; ++i)
        for (int j = 0; j < meridians; ++j) {
            const double x = 8.0 * std::min(i + 1, rings) / rings, t = 2 * std::numbers::pi * j / meridians;
            const double r = i < rings ? x : x * (1 - (i + 1.0 - rings) / (of_base + 1));
            points.emplace_back(x, 0.375 * r * std::cos(t), (std::sin(t) > 0 ? 0.1625 : 0.0625) * r * std::sin(t));
        }
    points.emplace_back(8, 0, 0);
    for (int j = 0; j < meridians; ++j) {
        triangles.push_back({0, at(0, j + 1), at(0, j)});
        triangles.push_back(
            {static_cast<int>(points.size()) - 1, at(rings + of_base - 1, j), at(rings + of_base - 1, j + 1)});
        for (int i = 0; i + 1 < rings + of_base; ++i) {
            triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j + 1)});
            triangles.push_back({at(i, j), at(i + 1, j + 1), at(i + 1, j)});
        }
    }
    return mesh_of(points, triangles);
}

}  // namespace

TEST(RemeshSlivers, NoneWhereTheMiddleOfARoundedEdgeWanders) {
    for (const int meridians : {120, 200, 280}) {
        const TriMesh mesh = cone_with_flat_belly(90, meridians);
        const RemeshResult result = remesh(mesh, {.edge_length = 0.09});
        EXPECT_GT(shape_of(result.mesh).smallest, 0.2) << meridians;
        EXPECT_EQ(result.new_intersections, 0) << meridians;
    }
}

TEST(RemeshSlivers, BesideAKnifeEdgeDoNotBendItsLine) {
    const TriMesh mesh = knife_edge(true);
    ASSERT_LT(shape_of(mesh).smallest, 1e-5);
    int creases = 0;
    const BaseSurface base = base_surface(mesh, 40 * std::numbers::pi / 180, 0.1, {});
    for (const FeatureEdge& edge : base.features) {
        if (edge.kind != FeatureKind::crease) continue;
        ++creases;
        for (const int v : edge.v) EXPECT_LT(off_the_edges(base.points[v]), 1e-12);  // not round by the needle's point
    }
    EXPECT_EQ(creases, 28);
    const RemeshResult result = remesh(mesh, {.edge_length = 0.1}),
                       without = remesh(knife_edge(false), {.edge_length = 0.1});
    EXPECT_GT(shape_of(result.mesh).smallest, 0.2);
    EXPECT_NEAR(result.mesh.num_triangles(), without.mesh.num_triangles(), 0.02 * without.mesh.num_triangles());
    EXPECT_EQ(result.corners, without.corners);
    EXPECT_EQ(result.new_intersections, 0);
    for (const auto& edge : creases_of(result.mesh, 40))
        for (const Eigen::Vector3d& end : edge) EXPECT_LT(off_the_edges(end), 1e-12);
}

TEST(RemeshSlivers, FoldedOnesMakeNoCreases) {
    const TriMesh mesh = sheet_with_folded_slivers();
    ASSERT_GT(creases_of(mesh, 40).size(), 60u);
    const RemeshResult result = remesh(mesh, {.edge_length = 0.25});
    EXPECT_EQ(result.crease_edges, 0);
    EXPECT_EQ(result.corners, 4);
    expect_goals(shape_of(result.mesh));
    EXPECT_LT(hausdorff(mesh, result.mesh), 1e-3 * box_diagonal(mesh));
}

TEST(RemeshSlivers, BellowsOfThemAreNoCreases) {
    const TriMesh mesh = bellows();
    ASSERT_GT(creases_of(mesh, 40).size(), 36u);
    const RemeshResult result = remesh(mesh, {.edge_length = 0.2, .shortest_edge = 0.15});
    EXPECT_LT(result.crease_edges, 12);  // of the last ones at both ends
}

TEST(RemeshSlivers, RealStepsStay) {
    // A ledge a fiftieth of the wanted length high, across a plate: two creases.
    std::vector<Eigen::Vector3d> points;
    std::vector<std::array<int, 3>> triangles;
    constexpr int n = 12;
    for (const auto& [x, z] : {std::pair{0.0, 0.0}, {1.0, 0.0}, {1.0, 0.004}, {2.0, 0.004}})
        for (int k = 0; k <= n; ++k) points.emplace_back(x, 0.25 * k, z);
    for (int row = 0; row < 3; ++row)
        for (int k = 0; k < n; ++k) {
            const int a = row * (n + 1) + k, b = a + n + 1;
            triangles.push_back({a, b, b + 1});
            triangles.push_back({a, b + 1, a + 1});
        }
    const TriMesh mesh = mesh_of(points, triangles);
    const RemeshResult result = remesh(mesh, {.edge_length = 0.2});
    EXPECT_GE(result.crease_edges, 2 * 13);
    EXPECT_LT(farthest(creases_of(mesh, 40), creases_of(result.mesh, 40), true), 1e-9);
}

TEST(RemeshSlivers, AWingWithCreasesStaysWhenRemeshedAgain) {
    const RemeshResult once = remesh(knife_edge(true), {.edge_length = 0.1});
    const RemeshResult twice = remesh(once.mesh, {.edge_length = once.edge_length});
    int moved = 0;
    for (int v = 0; v < twice.mesh.num_vertices(); ++v)
        moved += (once.mesh.vertices.rowwise() - twice.mesh.vertices.row(v)).rowwise().norm().minCoeff() >
                 0.1 * once.edge_length;
    EXPECT_LT(moved, 0.05 * twice.mesh.num_vertices());
}

/// Sheets nearer to each other than any edge: shortening edges there doubles the intersections. The input is kept
/// beside them at once; other lengths, which had taken half of the time, would leave some as well.
TEST(RemeshSlivers, OtherLengthsAreNotTriedWhereShorterEdgesDoubleTheIntersections) {
    const TriMesh mesh = example::waverider(40000);
    int iterations = 0;
    const RemeshResult result =
        remesh(mesh, {.edge_length = 0.21}, [&](const RemeshRecord&) { return ++iterations > 0; });
    EXPECT_EQ(result.new_intersections, 0);
    EXPECT_GT(result.frozen_triangles, 100) << "the surface is not one of those";
    EXPECT_LT(iterations, 30) << "of two attempts, not four";
}
