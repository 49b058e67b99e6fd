#include "objectives/geometry/wall_thickness.hpp"

#include "ask.hpp"
#include "core/mesh/geometry.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>

using namespace strake;

TEST(WallThickness, OfABoxIsItsSmallestSide) {
    const TriMesh box = box_surface({3, 2, 1}, 4);
    const Quantity w = wall_thickness("w", box);
    EXPECT_NEAR(value(w, box, 1), 1, 1e-12);
    EXPECT_LE(value(w, box, 0), 1);
    EXPECT_GE(value(w, box, 0), std::pow(box.num_triangles(), -1.0 / 60));
}

TEST(WallThickness, OfAnEllipsoidAlongItsNormals) {
    const TriMesh body = ellipsoid({3, 3, 0.5}, 4);
    std::vector<char> middle(body.num_triangles());
    for (int t = 0; t < body.num_triangles(); ++t)
        middle[t] = body.vertices.row(body.triangles(t, 0)).head<2>().norm() < 0.3;
    EXPECT_NEAR(value(wall_thickness("w", body, {60, middle}), body, 1), 1, 0.02);
}

TEST(WallThickness, TheNearestWallCounts) {
    // A shell: a sphere with a hollow.
    TriMesh shell = icosphere(3);
    const int nv = shell.num_vertices(), nt = shell.num_triangles();
    shell.vertices.conservativeResize(2 * nv, 3);
    shell.triangles.conservativeResize(2 * nt, 3);
    shell.vertices.bottomRows(nv) = (0.8 * shell.vertices.topRows(nv)).rowwise() + Eigen::RowVector3d(0.1, 0, 0);
    for (int t = 0; t < nt; ++t)
        shell.triangles.row(nt + t) << nv + shell.triangles(t, 0), nv + shell.triangles(t, 2),
            nv + shell.triangles(t, 1);
    EXPECT_NEAR(value(wall_thickness("w", shell), shell, 1), 0.1, 0.01);
}

TEST(WallThickness, AHalfModelMeetsItsMirrorImage) {
    // Side walls see each other across the plane.
    const auto [half, whole] = crooked_box(6);
    const SymmetryPlane plane{Eigen::Vector3d::UnitY(), 1};
    const auto sides = [](const TriMesh& mesh) {
        std::vector<char> marks(mesh.num_triangles());
        for (int t = 0; t < mesh.num_triangles(); ++t) marks[t] = std::abs(area_vector(mesh, t).normalized().y()) > 0.9;
        return marks;
    };
    const Quantity all = wall_thickness("w", whole, {8, sides(whole)});
    const Quantity part = wall_thickness("w", half, {8, sides(half)}, plane);
    EXPECT_NEAR(value(part, half, 1), value(all, whole, 1), 1e-12);
    EXPECT_NEAR(value(part, half, 0), value(all, whole, 0) * std::pow(2, 1.0 / 8), 1e-12);  // half as many rays
    for (std::size_t i = 0; i < 2; ++i) {
        EXPECT_NEAR(order_in_plane(part, half, 1, 1, i, 1e-5), 2, 0.15) << i;
        EXPECT_NEAR(order_in_plane(part, half, 1, 1.2, i, 1e-5), 1, 0.1) << i;
    }
}

TEST(WallThickness, DerivativesAreExact) {
    TriMesh body = ellipsoid({2, 1, 0.6}, 2);  // without its symmetries: no ray hits an edge
    body.vertices += 0.01 * points(random_vector(body.vertices.size(), 2));
    const Quantity w = wall_thickness("w", body, {8, {}});
    for (std::size_t i = 0; i < 2; ++i) {
        EXPECT_NEAR(order(w, body, 1, i, 1e-5), 2, 0.15) << i;
        EXPECT_NEAR(order(w, body, 1.2, i, 1e-5), 1, 0.1) << i;
    }
}

TEST(WallThickness, WhatCannotBeIsRefused) {
    const TriMesh ball = icosphere(1);
    EXPECT_TRUE(has(refusal([&] { wall_thickness("w", ball, {0.5, {}}); }), "sharpness = 0.5"));
    EXPECT_TRUE(has(refusal([&] { wall_thickness("w", hinge(1, 1)); }), "no ray"));
    TriMesh turned = ball;
    turned.triangles.col(0).swap(turned.triangles.col(1));
    EXPECT_TRUE(has(refusal([&] { wall_thickness("w", turned); }), "inside out"));
}
