#include "core/mesh/closest_point.hpp"

#include "core/error.hpp"
#include "core/mesh/point_tree.hpp"
#include "core/mesh/point_triangle.hpp"
#include "derivatives.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <xmmintrin.h>

#include <algorithm>
#include <limits>

namespace strake {
namespace {

ClosestPoint by_brute_force(const TriMesh& mesh, const Eigen::Vector3d& x) {
    ClosestPoint best;
    best.distance = std::numeric_limits<double>::infinity();
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        const ClosestPoint found = closest_point_on_triangle(mesh, t, x);
        if (found.distance < best.distance) best = found;
    }
    return best;
}

/// Random points near and far, and every third point on a vertex, an edge's middle or in a triangle.
std::vector<Eigen::Vector3d> queries(const TriMesh& mesh, const Eigen::Vector3d& centre, double size, int count) {
    const Eigen::VectorXd r = random_vector(3 * count, 11);
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i < count; ++i) {
        const int t = (i * 37) % mesh.num_triangles();
        const Eigen::Vector3d a = mesh.vertices.row(mesh.triangles(t, 0)), b = mesh.vertices.row(mesh.triangles(t, 1)),
                              c = mesh.vertices.row(mesh.triangles(t, 2));
        const Eigen::Vector3d random = r.segment<3>(3 * i);
        switch (i % 6) {
            case 0:
                points.push_back(a);
                break;
            case 1:
                points.push_back(0.5 * (a + b));
                break;
            case 2:
                points.push_back(0.5 * a + 0.25 * b + 0.25 * c);
                break;
            case 3:
                points.push_back(centre + 100 * size * random);
                break;
            default:
                points.push_back(centre + 1.5 * size * random);
        }
    }
    return points;
}

void expect_equal_to_brute_force(const TriMesh& mesh, const Eigen::Vector3d& centre, double size, int count) {
#ifdef __SANITIZE_ADDRESS__
    count /= 50;  // brute force is slow enough
#endif
    const ClosestPointTree tree(mesh);
    for (const auto& x : queries(mesh, centre, size, count)) {
        const ClosestPoint found = tree.find(x), expected = by_brute_force(mesh, x);
        ASSERT_EQ(found.triangle, expected.triangle) << x.transpose();
        ASSERT_EQ(found.distance, expected.distance);
        ASSERT_EQ(found.point, expected.point);
        ASSERT_EQ(found.corner_a, expected.corner_a);
        ASSERT_EQ(found.corner_b, expected.corner_b);
    }
}

/// Two fans of slivers askew, as CAD tessellations have them around a corner, and a box of ordinary triangles.
TEST(ClosestPoint, SliversAskewAreFoundAsByBruteForce) {
    constexpr int around = 200;
    const TriMesh box = box_surface({1, 2, 0.5}, 3);
    TriMesh mesh;
    mesh.vertices.resize(2 * (around + 1) + box.num_vertices(), 3);
    mesh.triangles.resize(2 * (around - 1) + box.num_triangles(), 3);
    int t = 0;
    for (int fan = 0; fan < 2; ++fan) {
        const int apex = fan * (around + 1);
        mesh.vertices.row(apex) << 3, 4 - 2 * fan, 5;
        for (int j = 0; j < around; ++j) {
            const double s = static_cast<double>(j) / around;
            mesh.vertices.row(apex + 1 + j) << -3 + 1e-2 * s, -4 + 2e-2 * s * s + fan * s, -5 + fan * 1e-12 * s;
            if (j > 0) mesh.triangles.row(t++) << apex, apex + j, apex + j + 1;
        }
    }
    mesh.vertices.bottomRows(box.num_vertices()) = box.vertices;
    mesh.triangles.bottomRows(box.num_triangles()) = box.triangles.array() + 2 * (around + 1);
    expect_equal_to_brute_force(mesh, Eigen::Vector3d::Zero(), 5, 600);
}

TEST(ClosestPoint, EqualsBruteForceOnASphere) {
    expect_equal_to_brute_force(icosphere(3), Eigen::Vector3d::Zero(), 1, 10000);
}

TEST(ClosestPoint, EqualsBruteForceOnABoxWithManyTies) {
    const TriMesh box = box_surface(Eigen::Vector3d::Ones(), 6);
    const ClosestPointTree tree(box);
    EXPECT_DOUBLE_EQ(tree.find({0.5, 0.5, 0.5}).distance, 0.5);
    expect_equal_to_brute_force(box, Eigen::Vector3d::Constant(0.5), 1, 3000);
}

TEST(ClosestPoint, OffsetOfTenMillionAndTinyOrHugeScaleChangeNothing) {
    for (const double scale : {1e-9, 1.0, 1e12}) {
        TriMesh mesh = icosphere(2);
        const Eigen::Vector3d centre = scale * Eigen::Vector3d(1e7, -3e6, 2e5);
        mesh.vertices = (scale * mesh.vertices).rowwise() + centre.transpose();
        expect_equal_to_brute_force(mesh, centre, scale, 1500);
    }
}

TEST(ClosestPoint, NamesTheClosestFeature) {
    TriMesh mesh;
    mesh.vertices.resize(3, 3);
    mesh.vertices << 0, 0, 0, 2, 0, 0, 0, 2, 0;
    mesh.triangles.resize(1, 3);
    mesh.triangles << 0, 1, 2;
    const ClosestPointTree tree(mesh);
    const ClosestPoint face = tree.find({0.5, 0.25, 3});
    EXPECT_EQ(face.corner_a, -1);
    EXPECT_EQ(face.distance, 3);
    EXPECT_EQ(face.point, Eigen::Vector3d(0.5, 0.25, 0));
    const ClosestPoint edge = tree.find({2, 2, 1});
    EXPECT_EQ(edge.corner_a, 1);
    EXPECT_EQ(edge.corner_b, 2);
    EXPECT_TRUE(edge.point.isApprox(Eigen::Vector3d(1, 1, 0)));
    const ClosestPoint vertex = tree.find({-3, -4, 0});
    EXPECT_EQ(vertex.corner_a, 0);
    EXPECT_EQ(vertex.corner_b, -1);
    EXPECT_EQ(vertex.distance, 5);
}

TEST(ClosestPoint, OfADegenerateTriangleLiesOnItsEdges) {
    TriMesh mesh;
    mesh.vertices.resize(3, 3);
    mesh.vertices << 0, 0, 0, 1, 0, 0, 4, 0, 0;
    mesh.triangles.resize(1, 3);
    mesh.triangles << 0, 1, 2;
    const ClosestPoint found = ClosestPointTree(mesh).find({3, 2, 0});
    EXPECT_EQ(found.distance, 2);
    EXPECT_EQ(found.point, Eigen::Vector3d(3, 0, 0));
}

TEST(ClosestPoint, KeepsTheFloatingPointMode) {
    const unsigned before = _mm_getcsr() & ~0x3Fu;  // without the sticky exception flags
    const ClosestPointTree tree(icosphere(1));
    tree.find({1, 2, 3});
    EXPECT_EQ(_mm_getcsr() & ~0x3Fu, before);
}

TEST(ClosestPoint, RefusesWhatHasNoAnswer) {
    EXPECT_THROW(ClosestPointTree{TriMesh()}, InvalidInput);
    TriMesh mesh = icosphere(0);
    EXPECT_THROW(ClosestPointTree(mesh).find({0, std::numeric_limits<double>::quiet_NaN(), 0}), InvalidInput);
    mesh.triangles(3, 1) = 99;
    EXPECT_THROW(ClosestPointTree{mesh}, InvalidInput);
}

/// Points about a segment, on it and along it, at many scales; `within` of a ball around it would look at all of them.
TEST(PointTree, OnlyWhatIsNearASegmentIsFound) {
    const Eigen::VectorXd r = random_vector(3 * 4000, 5);
    Points points(4000, 3);
    for (int i = 0; i < 4000; ++i) points.row(i) << r[3 * i], 0.3 * r[3 * i + 1], (i % 5 == 0 ? 0 : 0.1) * r[3 * i + 2];
    const PointTree tree(points);
    std::vector<int> found;
    for (const double scale : {1.0, 0.01, 0.0})
        for (int k = 0; k < 40; ++k) {
            const Eigen::Vector3d p = points.row(k), q = p + scale * (points.row(4 * k + 7).transpose() - p);
            const double radius = k % 2 == 0 ? 0.02 : 0.3;
            std::vector<int> all;
            for (int i = 0; i < 4000; ++i) {
                const Eigen::Vector3d x = points.row(i), side = q - p;
                const double along = side.norm() > 0 ? std::clamp((x - p).dot(side) / side.squaredNorm(), 0.0, 1.0) : 0;
                if ((x - p - along * side).norm() <= radius) all.push_back(i);
            }
            tree.near_segment(p, q, radius, found);
            EXPECT_EQ(found, all) << k << " " << scale;
            EXPECT_FALSE(all.empty());
        }
}

}  // namespace
}  // namespace strake
