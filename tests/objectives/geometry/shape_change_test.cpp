#include "objectives/geometry/shape_change.hpp"

#include "ask.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <numbers>

using namespace strake;

namespace {

/// Orders of the remainder at a shape that is away from the start, with the exact gradient and a wrong one.
void expect_exact(const Quantity& quantity, const TriMesh& start, double size) {
    const TriMesh other = with_vertices(start, start.vertices + size * points(random_vector(start.vertices.size(), 9)));
    const auto J = [&](const Eigen::VectorXd& x) { return value(quantity, with_vertices(start, points(x))); };
    const Eigen::VectorXd g = flat(ask(quantity, other, true).dJ_dv.at(0));
    const Eigen::VectorXd p = 0.3 * random_vector(g.size(), 4) + 0.5 / g.cwiseAbs().maxCoeff() * g;
    EXPECT_NEAR(taylor_order(J, flat(other.vertices), g, p, 0.1 * size), 2, 0.15) << quantity.names[0];
    EXPECT_NEAR(taylor_order(J, flat(other.vertices), 2 * g, p, 1e-3 * size), 1, 0.2) << quantity.names[0];
}

}  // namespace

TEST(Displacement, IsTheMeanSquare) {
    const TriMesh mesh = icosphere(2);
    const Quantity d = displacement("d", mesh);
    EXPECT_EQ(value(d, mesh), 0);
    EXPECT_NEAR(value(d, moved(mesh, 1, {0.3, 0, 0.4})), 0.25, 1e-14);
    EXPECT_NEAR(value(d, moved(mesh, 1.1, {0, 0, 0})), 0.01, 1e-14);
    expect_exact(d, mesh, 0.02);
}

TEST(Creases, OfAHinge) {
    TriMesh mesh = hinge(1, 1);
    mesh.vertices.col(2) = -mesh.vertices.col(0).cwiseAbs();  // a ridge of 90 degrees
    const Quantity c = creases("c", mesh, 0.5);
    EXPECT_EQ(value(c, mesh), 0);
    TriMesh other = mesh;
    other.vertices.col(2) *= std::tan(std::numbers::pi / 3);  // of 120
    EXPECT_NEAR(value(c, other), std::pow(std::numbers::pi / 6, 2), 1e-12);
    other.vertices.col(2) *= -1;  // a valley of 120
    EXPECT_NEAR(value(c, other), std::pow(std::numbers::pi * 210 / 180 - 2 * std::numbers::pi, 2), 1e-12);
    expect_exact(c, mesh, 0.02);
    EXPECT_TRUE(has(refusal([&] { creases("c", icosphere(3), 0.6); }), "c: no edge is as sharp as"));
}

TEST(Creases, OfABoxDoNotSeeRigidMotions) {
    const TriMesh box = box_surface({1, 2, 3}, 2);
    const Quantity c = creases("c", box, 0.5);
    EXPECT_NEAR(value(c, moved(box, 3, {1, 2, 3})), 0, 1e-28);
    expect_exact(c, box, 0.02);
}

TEST(Planarity, OfAWavyPlate) {
    TriMesh plate = strip(8 * std::numbers::pi, 1, 400, 10);
    const Quantity p = planarity("p", plate);
    EXPECT_NEAR(value(p, plate), 0, 1e-28);
    TriMesh wavy = plate;
    wavy.vertices.col(2) = 0.1 * plate.vertices.col(0).array().sin();
    wavy.vertices.col(2) += 0.3 * plate.vertices.col(1) + 0.2 * plate.vertices.col(0);  // tilted, too
    EXPECT_NEAR(value(p, wavy), 0.5 * 0.01 / (1 + 0.09 + 0.04), 3e-4);
    const TriMesh small = strip(2, 1, 8, 4);
    expect_exact(planarity("p", small), small, 0.02);
}

TEST(SymmetryError, OfAnEllipsoid) {
    const TriMesh mesh = ellipsoid({2, 1, 0.5}, 2);
    const SymmetryPlane plane{Eigen::Vector3d::UnitY(), 0};
    const Quantity s = symmetry_error("s", mesh, plane);
    EXPECT_NEAR(value(s, mesh), 0, 1e-20);
    EXPECT_NEAR(value(s, moved(mesh, 1, {0.1, 0, 0.3})), 0, 1e-20);
    EXPECT_NEAR(value(s, moved(mesh, 1, {0, 0.1, 0})), 0.04, 1e-12);  // both move away from each other's image
    expect_exact(s, mesh, 0.02);
}
