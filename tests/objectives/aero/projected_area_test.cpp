#include "objectives/aero/projected_area.hpp"

#include "ask.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <numbers>

using namespace strake;

TEST(ProjectedArea, Boxes) {
    const TriMesh box = box_surface({2, 3, 4}, 2);
    EXPECT_NEAR(value(projected_area("p", box, {}), box), 12, 1e-12);
    Stream down;
    down.forward = {0, 0, -1};
    down.up = {1, 0, 0};
    EXPECT_NEAR(value(projected_area("p", box, down), box), 6, 1e-12);
    Stream oblique;
    oblique.alpha.value = 0.4;
    EXPECT_NEAR(value(projected_area("p", box, oblique), box), 12 * std::cos(0.4) + 6 * std::sin(0.4), 1e-12);
}

TEST(ProjectedArea, HiddenPartsCountOnce) {
    // Two boxes, one half behind the other.
    TriMesh both = box_surface({1, 2, 2}, 3);
    const int nv = both.num_vertices(), nt = both.num_triangles();
    both.vertices.conservativeResize(2 * nv, 3);
    both.triangles.conservativeResize(2 * nt, 3);
    both.vertices.bottomRows(nv) = both.vertices.topRows(nv).rowwise() + Eigen::RowVector3d(3, 0.7, 1);
    both.triangles.bottomRows(nt) = both.triangles.topRows(nt).array() + nv;
    EXPECT_NEAR(value(projected_area("p", both, {}), both), 8 - 1.3 * 1, 1e-12);
    Stream oblique;  // no face edge-on
    oblique.alpha.value = 0.21;
    oblique.beta.value = 0.13;
    const Quantity area = projected_area("p", both, oblique);
    EXPECT_NEAR(order(area, both, 1, 0, 1e-3), 2, 0.2);
    EXPECT_NEAR(order(area, both, 1.1, 0, 1e-3), 1, 0.1);
}

TEST(ProjectedArea, DerivativeByTheAngle) {
    const TriMesh mesh = ellipsoid({2, 1, 0.4}, 3);
    Stream stream;
    stream.alpha.variable = "a";
    const Quantity p = projected_area("p", mesh, stream);
    const auto at = [&](double a) {
        QuantityRequest request{mesh, true, 1, 0, {}};
        request.parameters = {{"a", a}};
        return p.evaluate(request);
    };
    EXPECT_NEAR(at(0.3).dJ_dp[0][0], (at(0.3 + 1e-6).values[0] - at(0.3 - 1e-6).values[0]) / 2e-6, 1e-5);
}
