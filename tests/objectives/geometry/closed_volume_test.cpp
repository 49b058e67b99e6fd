#include "objectives/geometry/measures.hpp"

#include "ask.hpp"
#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "core/mesh/weld.hpp"
#include "objectives/quantity/closed.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>

using namespace strake;

namespace {

const SymmetryPlane y_is_one{Eigen::Vector3d::UnitY(), 1};

/// Without the triangles whose centroid is nearer to `at` than `radius`.
TriMesh with_hole(const TriMesh& mesh, const Eigen::RowVector3d& at, double radius) {
    const Points centre = triangle_centroids(mesh);
    TriMesh out = mesh;
    int count = 0;
    for (int t = 0; t < mesh.num_triangles(); ++t)
        if ((centre.row(t) - at).norm() >= radius) out.triangles.row(count++) = mesh.triangles.row(t);
    out.triangles.conservativeResize(count, 3);
    return out;
}

TriMesh joined(const TriMesh& a, const TriMesh& b) {
    TriMesh out;
    out.vertices.resize(a.num_vertices() + b.num_vertices(), 3);
    out.vertices << a.vertices, b.vertices;
    out.triangles.resize(a.num_triangles() + b.num_triangles(), 3);
    out.triangles << a.triangles, Triangles(b.triangles.array() + a.num_vertices());
    return out;
}

}  // namespace

TEST(ClosedVolume, IsTheVolumeWhereThatIsDefined) {
    for (const TriMesh& mesh : {icosphere(2), moved(box_surface({2, 3, 4}, 3), 0.5, {30, -20, 10})})
        EXPECT_NEAR(value(closed_volume(mesh), mesh), value(volume(mesh), mesh), 1e-13 * value(volume(mesh), mesh));
    const TriMesh half = half_above(box_surface({2, 2, 4}, 2), 1);
    EXPECT_NEAR(value(closed_volume(half, y_is_one), half), 8, 1e-12);
}

TEST(ClosedVolume, OfABoxWithoutALidIsThatOfTheBox) {
    // The lid is flat, and the cone over its rim lies in it.
    const TriMesh box = box_surface({2, 3, 4}, 3), open = with_hole(box, {1, 1.5, 4}, 0.95);
    ASSERT_LT(open.num_triangles(), box.num_triangles());
    EXPECT_NEAR(value(closed_volume(open), open), 24, 1e-12);
    const TriMesh shut = moved(open, 1, {5, 1, -7});
    EXPECT_NEAR(value(closed_volume(shut), shut), 24, 1e-11) << "no point is special";
}

TEST(ClosedVolume, CountsWhatIsEnclosedTwiceTwice) {
    const TriMesh box = box_surface({2, 3, 4}, 2), two = joined(box, moved(box, 1, {1, 0, 0}));
    EXPECT_NEAR(value(closed_volume(two), two), 48, 1e-12);
    TriMesh other = moved(box, 0.5, {10, 0, 0});
    other.triangles.col(0).swap(other.triangles.col(1));
    const TriMesh inward = joined(box, other);
    EXPECT_NEAR(value(closed_volume(inward), inward), 24 - 3, 1e-12) << "what faces inward counts negatively";
}

TEST(ClosedVolume, SensitivitiesHaveSecondOrderRemainder) {
    TriMesh open = with_hole(with_hole(icosphere(3), {0, 0, 1}, 0.5), {1, 0, 0}, 0.3);
    EXPECT_NEAR(order(closed_volume(open), open), 2, 0.1);
    EXPECT_NEAR(order(closed_volume(open), open, 2), 1, 0.1);
}

TEST(ClosedVolume, HolesAcrossThePlaneOfAHalfAreThoseOfTheWhole) {
    const TriMesh whole = with_hole(box_surface({2, 2, 4}, 4), {2, 1, 2}, 0.8), half = half_above(whole, 1);
    ASSERT_NEAR(value(closed_volume(whole), whole), 16, 1e-12);
    EXPECT_NEAR(value(closed_volume(half, y_is_one), half), 8, 1e-12);
    EXPECT_NEAR(order_in_plane(closed_volume(half, y_is_one), half, 1), 2, 0.1);
    EXPECT_NEAR(order_in_plane(closed_volume(half, y_is_one), half, 1, 2), 1, 0.1);
    // The hole no longer flat: half of what the mirrored whole has.
    TriMesh bent = half;
    for (int v = 0; v < bent.num_vertices(); ++v) {
        const double y = std::abs(bent.vertices(v, 1) - 1);
        bent.vertices(v, 0) += 0.2 * std::cos(1.3 * bent.vertices(v, 2)) * (1 - y * y);
    }
    const TriMesh rest = welded(whole_of(half, y_is_one)), both = welded(whole_of(bent, y_is_one));
    ASSERT_EQ(rest.triangles, both.triangles);
    EXPECT_NEAR(2 * value(closed_volume(half, y_is_one), bent), value(closed_volume(rest), both), 1e-11);
}

TEST(ClosedVolume, ASheetAndNothingAreRefused) {
    const TriMesh flat = strip(2, 1, 4, 2);
    EXPECT_TRUE(has(refusal([&] { closed_volume(flat); }), "encloses no volume"));
    EXPECT_TRUE(has(refusal([&] { closed_volume(TriMesh{}); }), "at least one triangle"));
}

TEST(Area, OfTrianglesWithoutAreaHasASubgradientWhereThatIsAsked) {
    TriMesh mesh = icosphere(1);
    const int n = mesh.num_vertices();
    mesh.vertices.conservativeResize(n + 1, 3);
    mesh.vertices.row(n) = 0.5 * (mesh.vertices.row(0) + mesh.vertices.row(1));
    mesh.triangles.conservativeResize(mesh.num_triangles() + 1, 3);
    mesh.triangles.bottomRows(1) << 0, 1, 0;
    EXPECT_TRUE(ask(area(), mesh, true).failure.has_value());
    const QuantityResult at = ask(area(true), mesh, true);
    ASSERT_FALSE(at.failure.has_value());
    EXPECT_NEAR(at.values[0], surface_area(icosphere(1)), 1e-13);
    EXPECT_TRUE(at.dJ_dv[0].allFinite());
}
