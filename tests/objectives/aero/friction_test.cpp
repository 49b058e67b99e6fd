#include "objectives/aero/friction.hpp"

#include "ask.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>

using namespace strake;

namespace {

FrictionFlow flow_of(bool turbulent, double reynolds = 1e6) {
    FrictionFlow flow;
    flow.reynolds_per_length = reynolds;
    flow.turbulent = turbulent;
    return flow;
}

}  // namespace

TEST(Friction, FlatPlate) {
    const TriMesh plate = strip(2, 0.5, 160, 40);
    const double re = 2e6;  // of the plate's length
    const double laminar = value(friction("f", plate, flow_of(false)), plate);
    const double turbulent = value(friction("f", plate, flow_of(true)), plate);
    EXPECT_NEAR(laminar, 1.328 / std::sqrt(re), 0.02 * laminar);
    EXPECT_NEAR(turbulent, 0.074 * std::pow(re, -0.2), 0.005 * turbulent);
    const TriMesh fine = strip(2, 0.5, 640, 160);
    EXPECT_LT(std::abs(value(friction("f", fine, flow_of(false)), fine) - 1.328 / std::sqrt(re)),
              0.7 * std::abs(laminar - 1.328 / std::sqrt(re)));
}

TEST(Friction, ASweptPlateHasItsLocalLength) {
    // Every chord is 1 long, wherever it begins.
    TriMesh plate = strip(1, 4, 60, 60);
    const double straight = value(friction("f", plate, flow_of(true)), plate);
    for (int v = 0; v < plate.num_vertices(); ++v) plate.vertices(v, 0) += 2 * plate.vertices(v, 1);
    EXPECT_NEAR(value(friction("f", plate, flow_of(true)), plate), straight, 0.03 * straight);
}

TEST(Friction, ReferenceTemperature) {
    EXPECT_DOUBLE_EQ(plate_law(flow_of(false)).scale, 0.664);
    FrictionFlow hot = flow_of(false);
    hot.mach = 5;
    // Adiabatic laminar wall, by hand: r = sqrt(0.72), T*/T = 1 + 0.72 * 0.2 * 25 * r.
    const double ratio = 1 + 0.72 * 5 * std::sqrt(0.72);
    const double mu = std::pow(ratio, 1.5) * (216.65 + 110.4) / (ratio * 216.65 + 110.4);
    EXPECT_NEAR(plate_law(hot).scale, 0.664 * std::sqrt(mu / ratio), 1e-12);
    FrictionFlow cold = hot;
    cold.wall_temperature = 1;
    EXPECT_GT(plate_law(cold).scale, plate_law(hot).scale);
}

TEST(Friction, DerivativesAreExact) {
    const TriMesh mesh = ellipsoid({2, 1, 0.4}, 2);
    for (const bool turbulent : {false, true}) {
        FrictionFlow flow = flow_of(turbulent, 1e5);
        flow.stream.alpha.value = 0.05;
        const Quantity f = friction("f", mesh, flow);
        // Lengths change sign at the leading line within this: the rounding keeps the order, from short steps on.
        EXPECT_NEAR(order(f, mesh, 1, 0, 1e-6), 2, 0.3) << turbulent;
        EXPECT_NEAR(order(f, mesh, 1.1, 0, 1e-6), 1, 0.1) << turbulent;
    }
    FrictionFlow flow = flow_of(true, 1e5);
    flow.stream.alpha.variable = "a";
    const Quantity f = friction("f", mesh, flow);
    const auto at = [&](double a) {
        QuantityRequest request{mesh, true, 1, 0, {}};
        request.parameters = {{"a", a}};
        return f.evaluate(request);
    };
    EXPECT_NEAR(at(0.1).dJ_dp[0][0], (at(0.1 + 1e-6).values[0] - at(0.1 - 1e-6).values[0]) / 2e-6, 1e-6);
}

TEST(Friction, AHalfModelHasHalfOfTheWholes) {
    const auto [half, whole] = crooked_box(6);
    const SymmetryPlane plane{Eigen::Vector3d::UnitY(), 1};
    for (const bool turbulent : {false, true}) {
        FrictionFlow flow = flow_of(turbulent, 1e5);
        flow.stream.alpha.value = 0.1;
        const double all = value(friction("f", whole, flow), whole);
        const Quantity of_half = friction("f", half, flow, plane);
        EXPECT_NEAR(value(of_half, half), 0.5 * all, 1e-12 * all) << turbulent;
        EXPECT_NEAR(order_in_plane(of_half, half, 1, 1, 0, 1e-6), 2, 0.3) << turbulent;
        EXPECT_NEAR(order_in_plane(of_half, half, 1, 1.1, 0, 1e-6), 1, 0.1) << turbulent;
    }
    EXPECT_TRUE(has(refusal([&] {
                        friction("f", half, flow_of(true), SymmetryPlane{Eigen::Vector3d::UnitX(), 0});
                    }),
                    "f: the flow crosses the plane of symmetry"));
}

TEST(Friction, WhatCannotBeIsRefused) {
    const TriMesh mesh = icosphere(1);
    FrictionFlow flow;
    flow.reynolds_per_length = 0;
    EXPECT_TRUE(has(refusal([&] { friction("f", mesh, flow); }), "f: reynolds = 0 must be > 0"));
    flow = {};
    flow.wall_temperature = -1;
    EXPECT_TRUE(has(refusal([&] { friction("f", mesh, flow); }), "wall_temperature"));
}

TEST(Friction, FieldIsTheLocalCoefficient) {
    const TriMesh plate = strip(2, 0.5, 40, 10);
    const std::vector<SurfaceField> fields =
        friction("f", plate, flow_of(true)).fields(QuantityRequest{plate, false, 1, 0, {}});
    ASSERT_EQ(fields.size(), 1U);
    EXPECT_EQ(fields[0].name, "f.cf");
    const double foremost = plate.vertices.col(0).minCoeff();
    for (int v = 0; v < plate.num_vertices(); ++v) {
        const double along = plate.vertices(v, 0) - foremost;
        if (along < 0.2) continue;
        EXPECT_NEAR(fields[0].values[v], 0.0592 * std::pow(1e6 * along, -0.2), 1e-5) << along;
    }
}
