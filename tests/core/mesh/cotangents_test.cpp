#include "core/mesh/cotangents.hpp"

#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <numbers>

using namespace strake;

namespace {

/// A square of side 1 with a point off its middle.
TriMesh square() {
    TriMesh mesh;
    mesh.vertices.resize(5, 3);
    mesh.vertices << 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0.4, 0.3, 0;
    mesh.triangles.resize(4, 3);
    mesh.triangles << 0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4;
    return mesh;
}

}  // namespace

/// grad u is constant: its square times the area, and no Laplacian inside, on any triangulation.
TEST(Cotangents, LinearValuesOnAPlane) {
    const TriMesh mesh = square();
    const auto L = cotangent_matrix(mesh);
    const Eigen::VectorXd u = mesh.vertices * Eigen::Vector3d(2, -3, 0);
    EXPECT_NEAR(u.dot(L * u), 13, 1e-13);
    EXPECT_NEAR((L * u)[4], 0, 1e-14);
    EXPECT_GT((L * Eigen::VectorXd(u.cwiseAbs2()))[4] * -1, 0.1) << "else this says nothing";
    EXPECT_LT((L * Eigen::VectorXd::Ones(5)).norm(), 1e-14);
}

TEST(Cotangents, RowsAreThoseOfTheMatrix) {
    const TriMesh mesh = square();
    const Eigen::MatrixXd all = cotangent_matrix(mesh), rows = cotangent_rows(mesh, {4, 1});
    ASSERT_EQ(rows.rows(), 2);
    EXPECT_EQ(rows.row(0), all.row(4));
    EXPECT_EQ(rows.row(1), all.row(1));
}

/// The Laplacian of the position is -2 x on the unit sphere; its triangles lie within by some 0.1 %.
TEST(Cotangents, PositionsOnASphere) {
    const TriMesh mesh = icosphere(4);
    const Points integrals = cotangent_matrix(mesh) * mesh.vertices;
    double along = 0;
    for (int v = 0; v < mesh.num_vertices(); ++v) along += integrals.row(v).dot(mesh.vertices.row(v));
    EXPECT_NEAR(along, 8 * std::numbers::pi, 0.01 * 8 * std::numbers::pi);
}

TEST(Cotangents, TrianglesWithoutAreaHaveNoPart) {
    TriMesh mesh = square();
    const Eigen::MatrixXd before = cotangent_matrix(mesh);
    mesh.triangles.conservativeResize(5, Eigen::NoChange);
    mesh.triangles.row(4) << 0, 0, 1;
    const Eigen::MatrixXd after = cotangent_matrix(mesh);
    EXPECT_EQ(after, before);
    EXPECT_TRUE(after.allFinite());
}
