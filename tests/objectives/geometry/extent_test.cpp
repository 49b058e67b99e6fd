#include "objectives/geometry/extent.hpp"

#include "ask.hpp"
#include "objectives/aero/area_distribution.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <numbers>

using namespace strake;

TEST(Extent, ExactAndSmooth) {
    const TriMesh mesh = moved(ellipsoid({3, 1, 0.5}, 3), 1, {1, 0, 0});
    const Quantity exact = extent("e", mesh, {2, 0, 0}), smooth = extent("e", mesh, {2, 0, 0}, 0.01);
    EXPECT_NEAR(value(exact, mesh, 0), 6, 0.02);
    EXPECT_NEAR(value(exact, mesh, 1), -2, 0.02);
    EXPECT_NEAR(value(exact, mesh, 2), 4, 0.02);
    EXPECT_GE(value(smooth, mesh, 0), value(exact, mesh, 0));
    EXPECT_LE(value(smooth, mesh, 0), value(exact, mesh, 0) + 2 * 0.01 * std::log(mesh.num_vertices()));
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_NEAR(order(smooth, mesh, 1, i, 1e-4), 2, 0.1);
        EXPECT_NEAR(order(smooth, mesh, 1.2, i, 1e-4), 1, 0.1);
    }
    const QuantityResult at = ask(exact, mesh, true);
    EXPECT_NEAR(at.dJ_dv[2].sum(), 1, 1e-15);
    EXPECT_EQ(at.dJ_dv[2].rowwise().norm().maxCoeff(), 1);
}

TEST(Extent, WhatCannotBeIsRefused) {
    const TriMesh mesh = icosphere(1);
    EXPECT_TRUE(has(refusal([&] { extent("e", mesh, {0, 0, 0}); }), "e: the direction"));
    EXPECT_TRUE(has(refusal([&] { extent("e", mesh, {1, 0, 0}, -1); }), "smoothing = -1"));
}

TEST(SectionAreas, OfAnEllipsoid) {
    const TriMesh mesh = ellipsoid({3, 1, 0.5}, 5);
    const Quantity areas = section_areas("s", mesh, {1, 0, 0}, 3);
    EXPECT_EQ(areas.names.back(), "s.3");
    EXPECT_NEAR(value(areas, mesh, 1), 0.5 * std::numbers::pi, 2e-3);
    EXPECT_NEAR(value(areas, mesh, 0), 0.5 * std::numbers::pi * 0.75, 2e-3);
    const TriMesh coarse = ellipsoid({3, 1, 0.5}, 3);
    const Quantity s = section_areas("s", coarse, {1, 0.1, 0.2}, 3);
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_NEAR(order(s, coarse, 1, i, 1e-4), 2, 0.15) << i;
        EXPECT_NEAR(order(s, coarse, 1.2, i, 1e-4), 1, 0.1) << i;
    }
    EXPECT_TRUE(has(refusal([&] { section_areas("s", coarse, {1, 0, 0}, 0); }), "stations = 0"));
}
