#include "objectives/fit/target_shape.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "derivatives.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>

using namespace strake;

namespace {

QuantityResult ask(const Quantity& quantity, const TriMesh& mesh, bool sensitivities = false) {
    return quantity.evaluate({mesh, sensitivities, 1, 0, {}});
}

Eigen::VectorXd flat(const Points& p) { return Eigen::Map<const Eigen::VectorXd>(p.data(), p.size()); }

Points points(const Eigen::VectorXd& x) { return Eigen::Map<const Points>(x.data(), x.size() / 3, 3); }

double order(const Quantity& quantity, const TriMesh& mesh, double factor = 1, double h = 1e-3) {
    const auto J = [&](const Eigen::VectorXd& x) { return ask(quantity, with_vertices(mesh, points(x))).values.at(0); };
    const Eigen::VectorXd g = flat(ask(quantity, mesh, true).dJ_dv.at(0));
    // Partly along g, so that a wrong factor shows.
    const Eigen::VectorXd p = 0.3 * random_vector(g.size(), 7) + 0.5 / g.cwiseAbs().maxCoeff() * g;
    return taylor_order(J, flat(mesh.vertices), factor * g, p, h);
}

Residuals residuals(const Quantity& quantity, const TriMesh& mesh) { return quantity.residuals(mesh, mesh); }

/// sum r^2 == J, dJ/dv == 2 r^T dr/dv, and the weights of the points sum to one.
void expect_consistent(const Quantity& quantity, const TriMesh& mesh) {
    const QuantityResult result = ask(quantity, mesh, true);
    const Residuals at = residuals(quantity, mesh);
    EXPECT_NEAR(at.r.squaredNorm(), result.values.at(0), 1e-13 * result.values[0]);
    EXPECT_LT((2 * (at.dr_dv.transpose() * at.r) - flat(result.dJ_dv.at(0))).norm(), 1e-14 * (1 + at.r.norm()));
    EXPECT_EQ(at.width * at.weight.size(), at.r.size());
    EXPECT_NEAR(at.weight.sum(), 1, 1e-13);
}

/// Largest difference between dr/dv and central differences of r along a few directions.
double jacobian_error(const Quantity& quantity, const TriMesh& mesh, double h) {
    const Residuals at = residuals(quantity, mesh);
    double worst = 0;
    for (unsigned seed = 1; seed <= 3; ++seed) {
        const Eigen::VectorXd p = random_vector(mesh.vertices.size(), seed), x = flat(mesh.vertices);
        const Eigen::VectorXd difference = (residuals(quantity, with_vertices(mesh, points(x + h * p))).r -
                                            residuals(quantity, with_vertices(mesh, points(x - h * p))).r) /
                                           (2 * h);
        worst = std::max(worst, (at.dr_dv * p - difference).cwiseAbs().maxCoeff());
    }
    return worst;
}

TriMesh shifted(TriMesh mesh, const Eigen::RowVector3d& by) {
    mesh.vertices.rowwise() += by;
    return mesh;
}

}  // namespace

TEST(TargetShapeSame, TranslatedTargetIsItsSquaredDistance) {
    const TriMesh mesh = icosphere(2);
    const Quantity match = target_shape_same("match", mesh, shifted(mesh, {0.1, -0.2, 0.2}));
    EXPECT_EQ(match.names, std::vector<std::string>{"match"});
    EXPECT_NEAR(ask(match, mesh).values.at(0), 0.09, 1e-14);
    EXPECT_EQ(ask(match, shifted(mesh, {0.1, -0.2, 0.2})).values.at(0), 0);
}

TEST(TargetShapeSame, DerivativesAreExactAndConsistent) {
    const TriMesh mesh = icosphere(2), target = ellipsoid({1, 1.3, 0.8}, 2);
    const Quantity match = target_shape_same("match", mesh, target);
    expect_consistent(match, mesh);
    EXPECT_NEAR(order(match, mesh), 2, 0.1);
    EXPECT_NEAR(order(match, mesh, 2), 1, 0.1);
    EXPECT_LT(jacobian_error(match, mesh, 1e-3), 1e-12);
}

TEST(TargetShapeSame, OtherConnectivityIsRefused) {
    const TriMesh mesh = icosphere(1);
    TriMesh turned = mesh;
    turned.triangles.row(7) = Eigen::RowVector3i(mesh.triangles(7, 1), mesh.triangles(7, 2), mesh.triangles(7, 0));
    EXPECT_THROW(target_shape_same("match", mesh, icosphere(2)), InvalidInput);
    try {
        target_shape_same("match", mesh, turned);
        FAIL() << "accepted";
    } catch (const InvalidInput& error) {
        EXPECT_NE(std::string(error.what()).find("triangle 7"), std::string::npos) << error.what();
    }
}

TEST(TargetShapeClosest, FaceEdgeAndVertexOfABox) {
    // Against the unit cube: a point above a face, beside an edge, beyond a corner.
    TriMesh start;
    start.vertices.resize(3, 3);
    start.vertices << 0.4, 0.3, 1.5, 0.4, 1.3, 1.4, 1.2, 1.4, 1.4;
    start.triangles.resize(1, 3);
    start.triangles << 0, 1, 2;
    const Quantity match = target_shape_closest("match", start, box_surface());
    const Residuals at = residuals(match, start);
    const double root = std::sqrt(1.0 / 3);  // equal vertex areas
    EXPECT_LT((at.r.segment<3>(0) - root * Eigen::Vector3d(0, 0, 0.5)).norm(), 1e-14);
    EXPECT_LT((at.r.segment<3>(3) - root * Eigen::Vector3d(0, 0.3, 0.4)).norm(), 1e-14);
    EXPECT_LT((at.r.segment<3>(6) - root * Eigen::Vector3d(0.2, 0.4, 0.4)).norm(), 1e-14);
    Eigen::VectorXd diagonal(9);
    diagonal << 0, 0, 1, 0, 1, 1, 1, 1, 1;  // what face, edge and corner leave
    EXPECT_LT((Eigen::MatrixXd(at.dr_dv) - root * Eigen::MatrixXd(diagonal.asDiagonal())).norm(), 1e-14);
    EXPECT_NEAR(ask(match, start).values.at(0), (0.25 + 0.25 + 0.36) / 3, 1e-14);
}

TEST(TargetShapeClosest, DerivativesAreExactAndConsistent) {
    // A sphere around the cube: its vertices see faces, edges and corners.
    TriMesh mesh = icosphere(3);
    mesh.vertices = (1.5 * mesh.vertices).rowwise() + Eigen::RowVector3d(0.51, 0.48, 0.53);
    const Quantity match = target_shape_closest("match", mesh, box_surface());
    expect_consistent(match, mesh);
    EXPECT_NEAR(order(match, mesh), 2, 0.1);
    EXPECT_NEAR(order(match, mesh, 2), 1, 0.1);
    EXPECT_LT(jacobian_error(match, mesh, 1e-6), 1e-8);
}

TEST(TargetShapeClosest, KeptMatchesAreThePlanesThatWereClosest) {
    TriMesh start;
    start.vertices.resize(3, 3);
    start.vertices << 0.4, 0.3, 1.5, 0.4, 0.8, 1.4, 0.2, 0.4, 1.4;  // all above the top of the unit cube
    start.triangles.resize(1, 3);
    start.triangles << 0, 1, 2;
    const Quantity match = target_shape_closest("match", start, box_surface());
    const TriMesh away = shifted(start, {5, 0, 0});
    EXPECT_LT((match.residuals(away, start).r - match.residuals(start, start).r).norm(), 1e-14);
    EXPECT_GT((match.residuals(away, away).r - match.residuals(start, start).r).norm(), 1);
}

TEST(TargetShapeClosest, IsZeroOnTheTargetAndIgnoresItsTriangulation) {
    const TriMesh target = ellipsoid({1, 1.3, 0.8}, 2), mesh = icosphere(2);
    EXPECT_LT(ask(target_shape_closest("match", target, target), target).values.at(0), 1e-30);
    const double J = ask(target_shape_closest("match", mesh, target), mesh).values.at(0);
    EXPECT_NEAR(ask(target_shape_closest("match", mesh, refined(target)), mesh).values.at(0), J, 1e-13 * J);
    EXPECT_NEAR(ask(target_shape_closest("match", mesh, renumbered(target, 3)), mesh).values.at(0), J, 1e-13 * J);
}

TEST(TargetShape, ScalesWithTheSquareAndIgnoresARigidShift) {
    const TriMesh mesh = icosphere(2), target = ellipsoid({1, 1.3, 0.8}, 2);
    const auto scaled = [](TriMesh m) {
        m.vertices = (1000 * m.vertices).rowwise() + Eigen::RowVector3d(50, -30, 10);
        return m;
    };
    for (const auto& make : {target_shape_same, target_shape_closest}) {
        const double J = ask(make("match", mesh, target), mesh).values.at(0);
        EXPECT_NEAR(ask(make("match", scaled(mesh), scaled(target)), scaled(mesh)).values.at(0), 1e6 * J, 1e-5 * J);
    }
}

TEST(TargetShape, WhatIsNotFiniteOrHasNoAreaIsRefused) {
    const TriMesh mesh = icosphere(1);
    TriMesh broken = mesh, point = mesh;
    broken.vertices(3, 1) = std::numeric_limits<double>::quiet_NaN();
    point.vertices.setZero();
    for (const auto& make : {target_shape_same, target_shape_closest}) {
        const QuantityResult result = ask(make("match", mesh, mesh), broken, true);
        ASSERT_TRUE(result.failure);
        EXPECT_EQ(result.failure->kind, "undefined");
        EXPECT_THROW(make("match", mesh, mesh).residuals(broken, broken), InvalidInput);
        EXPECT_THROW(make("match", mesh, broken), InvalidInput);
        EXPECT_THROW(make("match", point, mesh), InvalidInput);
    }
    EXPECT_THROW(target_shape_closest("match", mesh, TriMesh()), InvalidInput);
}
