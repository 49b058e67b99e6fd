#include "objectives/geometry/measures.hpp"

#include "ask.hpp"
#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <numbers>

using namespace strake;

namespace {

const SymmetryPlane y_is_one{Eigen::Vector3d::UnitY(), 1};

}  // namespace

TEST(Volume, ClosedForms) {
    const TriMesh box = box_surface({2, 3, 4}, 3), sphere = icosphere(5);
    EXPECT_NEAR(value(volume(box), box), 24, 1e-12);
    EXPECT_NEAR(value(volume(sphere), sphere), 4 * std::numbers::pi / 3, 1e-2);
    EXPECT_NEAR(value(volume(sphere), sphere), enclosed_volume(sphere), 1e-13);
    EXPECT_EQ(volume(box).names, std::vector<std::string>{"volume"});
}

TEST(Volume, IsPositiveAtTheStartWhicheverWayTheTrianglesRun) {
    TriMesh box = box_surface({2, 3, 4}, 2);
    box.triangles.col(0).swap(box.triangles.col(1));
    EXPECT_NEAR(value(volume(box), box), 24, 1e-12);
    EXPECT_NEAR(order(volume(box), box), 2, 0.1);
}

TEST(Volume, SensitivitiesHaveSecondOrderRemainder) {
    for (const TriMesh& mesh : {icosphere(2), moved(icosphere(2), 0.5, {30, -20, 10})}) {
        EXPECT_NEAR(order(volume(mesh), mesh), 2, 0.1);
        EXPECT_NEAR(order(volume(mesh), mesh, 2), 1, 0.1);
    }
}

TEST(Volume, HalfModelIsHalfWithExactSensitivities) {
    const TriMesh box = box_surface({2, 2, 4}, 2), half = half_above(box, 1);
    const Quantity of_half = volume(half, y_is_one);
    EXPECT_NEAR(value(of_half, half), 8, 1e-12);
    EXPECT_NEAR(order(of_half, half), 2, 0.1);
    EXPECT_NEAR(order(of_half, half, 2), 1, 0.1);
    // A point of the plane that is not the origin: the whole box is half of a taller one.
    const TriMesh far = moved(half, 1, {1e7, 1e7, 1e7});
    EXPECT_NEAR(value(volume(far, SymmetryPlane{Eigen::Vector3d::UnitY(), 1e7 + 1}), far), 8, 1e-6);
}

TEST(Volume, SensitivitiesOfTheHalfAreThoseOfTheWhole) {
    const TriMesh box = box_surface({2, 2, 4}, 2), half = half_above(box, 1);
    const Points whole = ask(volume(box), box, true).dJ_dv[0], part = ask(volume(half, y_is_one), half, true).dJ_dv[0];
    for (int v = 0; v < box.num_vertices(); ++v)
        if (box.vertices(v, 1) > 1) {
            EXPECT_LT((whole.row(v) - part.row(v)).norm(), 1e-14);
        }
}

TEST(Volume, OpenSurfaceIsRefusedWithTheEdgeAndItsPlace) {
    TriMesh open = icosphere(1);
    const Eigen::RowVector3i last = open.triangles.row(open.num_triangles() - 1);
    open.triangles.conservativeResize(open.num_triangles() - 1, 3);
    const std::string message = refusal([&] { volume(open); });
    EXPECT_TRUE(has(message, text("vertex ", last.minCoeff()))) << message;
    EXPECT_TRUE(has(message, "first of 3 open edges")) << message;
    EXPECT_TRUE(has(message, text(open.vertices(last.minCoeff(), 0)))) << message;
}

TEST(Volume, HalfModelWithoutItsPlaneIsToldAboutSymmetry) {
    const TriMesh half = half_above(box_surface({2, 2, 4}, 2), 1);
    const std::string message = refusal([&] { volume(half); });
    EXPECT_TRUE(has(message, "symmetry: {plane: y, at: 1}")) << message;
    const std::string off = refusal([&] { volume(half, SymmetryPlane{Eigen::Vector3d::UnitY(), 0.9}); });
    EXPECT_TRUE(has(off, "0.1 away from it")) << off;
    EXPECT_TRUE(has(off, "limit")) << off;
}

TEST(Volume, HalfModelWithAHoleIsToldAboutBoth) {
    TriMesh half = half_above(box_surface({2, 2, 4}, 2), 1);
    const Points centroids = triangle_centroids(half);
    int hole = 0;  // a triangle of the far side
    while (centroids(hole, 1) < 2) ++hole;
    half.triangles.row(hole) = half.triangles.row(half.num_triangles() - 1);
    half.triangles.conservativeResize(half.num_triangles() - 1, 3);
    const std::string message = refusal([&] { volume(half); });
    EXPECT_TRUE(has(message, "8 of them lie in the plane y = 1 ")) << message;
    EXPECT_TRUE(has(message, "the other 3 are holes")) << message;
    EXPECT_TRUE(has(refusal([&] { volume(half, y_is_one); }), "first of 3 open edges that are not on")) << message;
}

TEST(Volume, BoundaryWithinAMillionthOfTheDiagonalIsOnThePlane) {
    TriMesh half = half_above(box_surface({2, 2, 4}, 2), 1);
    const double diagonal = box_diagonal(half);
    EXPECT_EQ(refusal([&] { volume(half, SymmetryPlane{Eigen::Vector3d::UnitY(), 1 + 0.9e-6 * diagonal}); }), "");
    EXPECT_NE(refusal([&] { volume(half, SymmetryPlane{Eigen::Vector3d::UnitY(), 1 + 1.1e-6 * diagonal}); }), "");
}

TEST(Volume, FlippedTriangleAndFlatSurfaceAreRefused) {
    TriMesh flipped = icosphere(1);
    std::swap(flipped.triangles(5, 0), flipped.triangles(5, 1));
    EXPECT_TRUE(has(refusal([&] { volume(flipped); }), "disagree in orientation"));
    TriMesh sheet = box_surface({2, 3, 1}, 1);
    sheet.vertices.col(2).setZero();
    EXPECT_TRUE(has(refusal([&] { volume(sheet); }), "no volume"));
    EXPECT_NE(refusal([&] { volume(TriMesh()); }), "");
}

TEST(Volume, ScalesWithTheCubeAndIgnoresTranslation) {
    const TriMesh mesh = icosphere(2);
    const double V = value(volume(mesh), mesh);
    for (const double scale : {1e-9, 2.0, 1e12}) {
        const TriMesh other = moved(mesh, scale, scale * Eigen::RowVector3d(5, -3, 1));
        EXPECT_NEAR(value(volume(other), other) / (scale * scale * scale * V), 1, 1e-12);
    }
    const TriMesh far = moved(box_surface(), 1, {1e7, 1e7, 1e7});
    EXPECT_NEAR(value(volume(far), far), 1, 1e-6);
}

TEST(Area, ClosedForms) {
    EXPECT_NEAR(value(area(), box_surface({2, 3, 4}, 3)), 52, 1e-12);
    EXPECT_NEAR(value(area(), icosphere(5)), 4 * std::numbers::pi, 2e-2);
    EXPECT_NEAR(value(area(), strip(3, 2, 4, 5)), 6, 1e-12);
}

TEST(Area, SensitivitiesHaveSecondOrderRemainder) {
    const TriMesh mesh = ellipsoid({1, 2, 0.5}, 2);
    EXPECT_NEAR(order(area(), mesh), 2, 0.1);
    EXPECT_NEAR(order(area(), mesh, 2), 1, 0.1);
}

TEST(Area, ScalesWithTheSquareAndIgnoresTranslation) {
    const TriMesh mesh = icosphere(2);
    const double A = value(area(), mesh);
    EXPECT_NEAR(value(area(), moved(mesh, 3, {5, -3, 1})), 9 * A, 1e-12 * 9 * A);
    const Points dA_dv = ask(area(), mesh, true).dJ_dv[0];
    EXPECT_LT(dA_dv.colwise().sum().norm(), 1e-12);                        // translation
    EXPECT_NEAR((dA_dv.cwiseProduct(mesh.vertices)).sum(), 2 * A, 1e-12);  // Euler's theorem, degree two
}

TEST(Measures, NothingThatIsNotFiniteLeaves) {
    const TriMesh mesh = icosphere(1);
    TriMesh broken = mesh;
    broken.vertices(3, 1) = std::numeric_limits<double>::quiet_NaN();
    for (const Quantity& quantity : {volume(mesh), area()}) {
        const QuantityResult result = ask(quantity, broken, true);
        ASSERT_TRUE(result.failure);
        EXPECT_EQ(result.failure->kind, "undefined");
        EXPECT_TRUE(has(result.failure->message, "vertex 3")) << result.failure->message;
        EXPECT_TRUE(result.values.empty() && result.dJ_dv.empty());
        const QuantityResult large = ask(quantity, moved(mesh, 1e200, {0, 0, 0}), true);
        ASSERT_TRUE(large.failure) << large.values[0];
        EXPECT_EQ(large.failure->kind, "undefined");
    }
    TriMesh pinched = mesh;
    pinched.vertices.row(mesh.triangles(4, 1)) = pinched.vertices.row(mesh.triangles(4, 0));
    EXPECT_TRUE(ask(area(), pinched, true).failure);
    EXPECT_FALSE(ask(area(), pinched, false).failure);
    EXPECT_THROW(ask(volume(mesh), icosphere(2)), InvalidInput);
}
