#include "objectives/geometry/clearance.hpp"

#include "ask.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>

using namespace strake;

TEST(Clearance, OfSpheres) {
    const TriMesh inner = moved(icosphere(4), 0.5, {0.2, 0, 0}), outer = icosphere(4);
    Clearance out{"engine.stl", Side::keep_out, 0, {}}, in{"box.stl", Side::keep_in, 0, {}};
    EXPECT_NEAR(value(clearance("c", outer, inner, out), outer), 0.3, 2e-3);  // the skin around the engine
    EXPECT_NEAR(value(clearance("c", inner, outer, in), inner), 0.3, 3e-3);   // the body in its box
    const TriMesh away = moved(outer, 1, {0.8, 0, 0});
    const QuantityResult bad = ask(clearance("c", outer, inner, out), away);
    EXPECT_NEAR(bad.values[0], -0.1, 2e-3);
    ASSERT_EQ(bad.remarks.size(), 1u);
    EXPECT_TRUE(has(bad.remarks[0], "c: vertex ") && has(bad.remarks[0], "inside engine.stl")) << bad.remarks[0];
    // Orientation of the other surface does not matter.
    TriMesh turned = inner;
    turned.triangles.col(0).swap(turned.triangles.col(1));
    EXPECT_NEAR(value(clearance("c", outer, turned, out), outer), 0.3, 2e-3);
}

TEST(Clearance, TheSignIsRightAtCornersAndEdges) {
    const TriMesh box = box_surface({1, 1, 1}, 1);
    const auto at = [&](const Eigen::RowVector3d& x) {
        return value(clearance("c", moved(icosphere(0), 1e-9, x), box, {"b", Side::keep_out, 0, {}}),
                     moved(icosphere(0), 1e-9, x));
    };
    EXPECT_NEAR(at({2, 2, 2}), std::sqrt(3.0), 1e-6);
    EXPECT_NEAR(at({2, 2, 0.5}), std::sqrt(2.0), 1e-6);
    EXPECT_NEAR(at({0.9, 0.9, 0.8}), -0.1, 1e-6);
}

TEST(Clearance, SmoothingErrsOnTheSafeSide) {
    const TriMesh inner = moved(icosphere(3), 0.5, {0.2, 0.03, 0}), outer = icosphere(2);
    const double exact = value(clearance("c", outer, inner, {"e", Side::keep_out, 0, {}}), outer);
    const Quantity smooth = clearance("c", outer, inner, {"e", Side::keep_out, 0.01, {}});
    EXPECT_LT(value(smooth, outer), exact);
    EXPECT_GT(value(smooth, outer), exact - 0.01 * std::log(outer.num_vertices()));
    EXPECT_NEAR(order(smooth, outer, 1, 0, 1e-4), 2, 0.2);
    EXPECT_NEAR(order(smooth, outer, 1.2, 0, 1e-4), 1, 0.1);
}

TEST(Clearance, WhatCannotBeIsRefused) {
    const TriMesh ball = icosphere(1);
    EXPECT_TRUE(has(refusal([&] {
                        clearance("c", ball, hinge(1, 1), {"plate.stl", Side::keep_out, 0, {}});
                    }),
                    "c: plate.stl: the surface is open"));
    EXPECT_TRUE(has(refusal([&] { clearance("c", ball, ball, {"b", Side::keep_out, -1, {}}); }), "smoothing"));
}
