#include "objectives/geometry/edge_radius.hpp"

#include "ask.hpp"
#include "core/mesh/geometry.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>

using namespace strake;

namespace {

/// Triangles with their centroids at x < limit.
std::vector<char> front(const TriMesh& mesh, double limit) {
    const Points centroids = triangle_centroids(mesh);
    std::vector<char> marks;
    for (int t = 0; t < mesh.num_triangles(); ++t) marks.push_back(centroids(t, 0) < limit);
    return marks;
}

}  // namespace

TEST(EdgeRadius, NoseOfASphereAndOfAnEllipsoid) {
    const TriMesh ball = moved(icosphere(3), 0.7, {5, 2, 1});
    EXPECT_NEAR(value(edge_radius("r", ball, front(ball, 4.6)), ball), 0.7, 1e-12);
    const TriMesh body = ellipsoid({4, 1, 1}, 6);
    EXPECT_NEAR(value(edge_radius("r", body, front(body, -3.97)), body), 0.25,
                0.02);  // b^2 / a at the tip, more around it
}

TEST(EdgeRadius, LeadingEdgeInASection) {
    const TriMesh rod = capped_cylinder(64, 16, 0.3, 2);  // along x
    std::vector<char> marks(rod.num_triangles());
    for (int t = 0; t < rod.num_triangles(); ++t) {
        marks[t] = 1;
        for (int k = 0; k < 3; ++k) {
            const Eigen::Vector3d v = rod.vertices.row(rod.triangles(t, k));
            marks[t] &= v.tail<2>().norm() > 0.29 && v.y() < 0;
        }
    }
    const double middle = 0.5 * (rod.vertices.col(0).minCoeff() + rod.vertices.col(0).maxCoeff()) + 0.01;
    const Quantity r = edge_radius("r", rod, marks, SectionPlane{{1, 0, 0}, middle});
    EXPECT_NEAR(value(r, rod), 0.3, 1e-3);
}

TEST(EdgeRadius, DerivativesAreExact) {
    const TriMesh body = ellipsoid({4, 1, 1}, 4);
    for (const bool circle : {false, true}) {
        std::optional<SectionPlane> plane;
        if (circle) plane = SectionPlane{{0.1, 1, 0.2}, 0.013};
        const Quantity r = edge_radius("r", body, front(body, -3.5), plane);
        EXPECT_NEAR(order(r, body, 1, 0, 1e-4), 2, 0.1);
        EXPECT_NEAR(order(r, body, 1.2, 0, 1e-4), 1, 0.1);
    }
}

TEST(EdgeRadius, WhatHasNoneIsRefused) {
    const TriMesh box = box_surface({1, 1, 1}, 3);
    EXPECT_TRUE(has(refusal([&] { edge_radius("r", box, front(box, 0.01)); }), "lie on a plane"));
    EXPECT_TRUE(has(refusal([&] { edge_radius("r", box, front(box, -1)); }), "0 points of the region"));
    EXPECT_TRUE(has(refusal([&] { edge_radius("r", box, {}); }), "marks"));
}
