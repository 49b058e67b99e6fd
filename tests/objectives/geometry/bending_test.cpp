#include "objectives/geometry/bending.hpp"

#include "ask.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <numbers>

using namespace strake;

TEST(BendingEnergy, OfSpheresIsFourPi) {
    const double wanted = 4 * std::numbers::pi;
    double error[2];
    for (int level = 0; level < 2; ++level) {
        const TriMesh mesh = icosphere(3 + level);
        error[level] = std::abs(value(bending_energy("b", mesh), mesh) - wanted);
    }
    EXPECT_LT(error[1], 0.01 * wanted);
    EXPECT_LT(error[1], 0.35 * error[0]);
    const TriMesh large = moved(icosphere(3), 50, {3, 2, 1});
    EXPECT_NEAR(value(bending_energy("b", large), large), value(bending_energy("b", icosphere(3)), icosphere(3)), 1e-9);
}

TEST(BendingEnergy, OfACylinder) {
    // Per length pi / (2 r): H = 1 / (2 r), away from the rims.
    const TriMesh tube = capped_cylinder(96, 96, 0.5, 4);
    std::vector<char> side(tube.num_triangles(), 1);
    for (int t = 0; t < tube.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k) {
            const Eigen::Vector3d v = tube.vertices.row(tube.triangles(t, k));
            side[t] &= std::abs(v.tail<2>().norm() - 0.5) < 1e-9;
        }
    const double W = value(bending_energy("b", tube, side), tube);
    EXPECT_NEAR(W, std::numbers::pi / (2 * 0.5) * 4, 0.04 * W);  // less the two rims' vertices
}

TEST(BendingEnergy, DerivativesAreExact) {
    const TriMesh mesh = ellipsoid({2, 1, 0.5}, 2);
    const Quantity b = bending_energy("b", mesh);
    EXPECT_NEAR(order(b, mesh, 1, 0, 1e-4), 2, 0.1);
    EXPECT_NEAR(order(b, mesh, 1.1, 0, 1e-4), 1, 0.1);
}

TEST(Fairness, SeesBumpsAndNoTranslation) {
    const TriMesh mesh = ellipsoid({2, 1, 0.5}, 3);
    const Quantity f = fairness("f", mesh);
    EXPECT_EQ(value(f, mesh), 0);
    EXPECT_NEAR(value(f, moved(mesh, 1, {1, 2, 3})), 0, 1e-20);
    const auto waved = [&](double waves) {
        TriMesh other = mesh;
        for (int v = 0; v < mesh.num_vertices(); ++v)
            other.vertices(v, 2) += 0.01 * std::sin(waves * mesh.vertices(v, 0));
        return value(f, other);
    };
    EXPECT_GT(waved(8), 20 * waved(2));
    // A flat plate bent to z = c/2 x^2 has |Laplacian|^2 = c^2 per area.
    const TriMesh plate = strip(2, 1, 80, 40);
    TriMesh bent = plate;
    bent.vertices.col(2) = 0.5 * 0.3 * plate.vertices.col(0).array().square();
    EXPECT_NEAR(value(fairness("f", plate), bent), 0.09 * 2, 0.1 * 0.18);  // without the border
    TriMesh other = mesh;
    other.vertices += 0.02 * points(random_vector(mesh.vertices.size(), 9));
    const auto J = [&](const Eigen::VectorXd& x) { return value(f, with_vertices(mesh, points(x))); };
    const Eigen::VectorXd g = flat(ask(f, other, true).dJ_dv.at(0)), p = random_vector(g.size(), 4);
    EXPECT_NEAR(taylor_order(J, flat(other.vertices), g, p, 1e-3), 2, 0.1);
    EXPECT_NEAR(taylor_order(J, flat(other.vertices), 1.5 * g, p, 1e-6), 1, 0.1);
}

TEST(BendingEnergy, AHalfModelHasHalfOfTheWholes) {
    const auto [half, whole] = crooked_box(6);
    const SymmetryPlane plane{Eigen::Vector3d::UnitY(), 1};
    const double W = value(bending_energy("b", whole), whole);
    const Quantity bent = bending_energy("b", half, {}, plane);
    EXPECT_NEAR(value(bent, half), 0.5 * W, 1e-10 * W);
    EXPECT_GT(std::abs(value(bending_energy("b", half), half) - 0.5 * W), 0.01 * W);  // the plane as a border
    EXPECT_NEAR(order_in_plane(bent, half, 1, 1, 0, 1e-5), 2, 0.1);
    EXPECT_NEAR(order_in_plane(bent, half, 1, 1.1, 0, 1e-5), 1, 0.1);

    const auto waved = [](TriMesh mesh) {
        for (int v = 0; v < mesh.num_vertices(); ++v) {
            const double y = mesh.vertices(v, 1) - 1;
            mesh.vertices.row(v) += 0.1 * Eigen::RowVector3d(std::cos(2 * y), y, std::sin(3 * mesh.vertices(v, 0)));
        }
        return mesh;
    };
    const Quantity fair = fairness("f", half, {}, plane);
    const double F = value(fairness("f", whole), waved(whole));
    EXPECT_NEAR(value(fair, waved(half)), 0.5 * F, 1e-10 * F);
    const TriMesh other = waved(half);
    EXPECT_NEAR(order_in_plane(fair, other, 1, 1, 0, 1e-3), 2, 0.1);
    EXPECT_NEAR(order_in_plane(fair, other, 1, 1.5, 0, 1e-6), 1, 0.1);
}

TEST(BendingEnergy, WhatCannotBeIsRefused) {
    const TriMesh two = hinge(1, 1);
    EXPECT_TRUE(has(refusal([&] { bending_energy("b", two); }), "b: no inner vertex"));
    EXPECT_TRUE(has(refusal([&] { fairness("f", icosphere(1), {1}); }), "marks"));
}
