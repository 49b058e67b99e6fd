#include "core/patches/features.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "core/patches/segmentation.hpp"
#include "shapes.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>

using namespace strake;

namespace {
constexpr double deg = std::numbers::pi / 180;
}

TEST(Features, ThetaIsTheDihedralOfAStraightCreaseInsideAndAtTheBoundary) {
    for (const double t : {0.5, 5.0, 45.0, 89.0, 91.0, 135.0, 164.0, 172.0}) {
        const int cells = 4;
        const TriMesh mesh = two_plates(t, cells);
        const auto features = quadric_metric_tensor(mesh, adjacency(mesh));
        for (int j = 0; j <= cells; ++j) {
            const VertexFeature& f = features[cells * (cells + 1) + j];
            EXPECT_NEAR(f.theta, t * deg, 1e-7) << t << " vertex " << j;
            EXPECT_NEAR(f.angle_defect, 0, 1e-9);
            EXPECT_NEAR(f.psi, 0, 1e-6);
        }
        EXPECT_NEAR(features[0].theta, 0, 1e-7);
    }
}

TEST(Features, CubeHasCornersAndABoxHasRidges) {
    const TriMesh mesh = box_surface({1, 1, 1}, 4);
    const auto features = quadric_metric_tensor(mesh, adjacency(mesh));
    std::map<VertexClass, int> count;
    for (const VertexFeature& f : features) ++count[classify(f, 20 * deg)];
    EXPECT_EQ(count[VertexClass::corner], 8);
    EXPECT_EQ(count[VertexClass::ridge], 12 * 3);
    EXPECT_EQ(count[VertexClass::smooth], 6 * 9);
    EXPECT_THROW(classify(features[0], 0), InvalidInput);
    EXPECT_THROW(classify(features[0], 91 * deg), InvalidInput);
}

TEST(Features, ThresholdEqualToTheCreaseCounts) {
    const TriMesh mesh = two_plates(20, 4);
    const auto features = quadric_metric_tensor(mesh, adjacency(mesh));
    const VertexFeature& f = features[4 * 5 + 2];
    EXPECT_EQ(classify(f, 20 * deg), VertexClass::ridge);
    EXPECT_EQ(classify(f, 20 * deg + 1e-6), VertexClass::smooth);
}

TEST(Features, AcuteCreaseIsNonsmoothAtEveryThreshold) {
    const TriMesh mesh = two_plates(164, 3);
    const auto features = quadric_metric_tensor(mesh, adjacency(mesh));
    const VertexFeature& f = features[3 * 4 + 1];
    EXPECT_LT(f.eigenvalue_ratio, std::pow(std::tan(10 * deg), 2));  // what the plain ratio makes of it: 16 degrees
    for (const double tau : {90.0, 60.0, 20.0, 1.0}) EXPECT_TRUE(is_nonsmooth(f, tau * deg));
}

TEST(Features, TrianglesOfZeroAreaCarryNoWeight) {
    TriMesh mesh = mesh_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.5, 0, 0}}, {{0, 1, 2}, {0, 3, 1}});
    for (const VertexFeature& f : quadric_metric_tensor(mesh, adjacency(mesh))) {
        EXPECT_TRUE(std::isfinite(f.theta + f.psi + f.angle_defect + f.mean_normal_squared));
        EXPECT_FALSE(is_nonsmooth(f, 1 * deg));
    }
}

TEST(Features, VerdictsAreTheSameWhereSmoothVerticesArePassedOver) {
    int smooth = 0, sharp = 0;
    for (const TriMesh& mesh : {icosphere(2), box_surface({1, 2, 3}, 3), capped_cylinder(9, 4)}) {
        const Adjacency adjacent = adjacency(mesh);
        const Points normals = triangle_normals(mesh), angles = corner_angles(mesh);
        const auto exact = quadric_metric_tensor(mesh, adjacent, normals, angles);
        for (const double tau : {0.05, 0.2, 0.5, 0.7, 1.2}) {
            const auto quick = quadric_metric_tensor(mesh, adjacent, normals, angles, tau);
            for (int v = 0; v < mesh.num_vertices(); ++v) {
                EXPECT_EQ(classify(quick[v], tau), classify(exact[v], tau));
                EXPECT_GE(quick[v].eigenvalue_ratio, exact[v].eigenvalue_ratio * (1 - 1e-9) - 1e-12);
                ++(is_nonsmooth(exact[v], tau) ? sharp : smooth);
            }
        }
    }
    EXPECT_GT(smooth, 100);
    EXPECT_GT(sharp, 100);
}

TEST(Features, TrailingEdgeOfAWingIsABarrier) {
    const int panels = 20, strips = 10;
    const TriMesh mesh = naca0012_wing(panels, strips);
    const Adjacency adjacent = adjacency(mesh);
    const SurfaceFeatures features = surface_features(mesh, adjacent);
    for (const double tau : {20.0, 2.5, 1.0}) {
        const std::vector<char> barrier = nonsmooth_edges(features, tau * deg);
        int trailing = 0;
        for (int e = 0; e < adjacent.num_edges(); ++e) {
            const auto [a, b] = adjacent.edges[e];
            if (a % (2 * panels) || b % (2 * panels)) continue;
            ++trailing;
            EXPECT_TRUE(barrier[e]);
        }
        EXPECT_EQ(trailing, strips);
    }
}
