#include "objectives/aero/newtonian.hpp"

#include "ask.hpp"
#include "objectives/aero/pressure.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <Eigen/Geometry>
#include <numbers>

using namespace strake;

namespace {

constexpr double pi = std::numbers::pi;
enum { drag, lift, side, lift_to_drag, roll, pitch, yaw };

NewtonianFlow plain(double alpha = 0) {
    NewtonianFlow flow;
    flow.cp_max = 2;
    flow.stream.alpha.value = alpha;
    return flow;
}

/// Open cone, apex at the origin, axis x, half angle delta, length 1.
TriMesh cone(double delta, int facets) {
    TriMesh mesh;
    mesh.vertices = Points::Zero(facets + 1, 3);
    mesh.triangles.resize(facets, 3);
    for (int k = 0; k < facets; ++k) {
        const double a = 2 * pi * k / facets, r = std::tan(delta);
        mesh.vertices.row(k + 1) << 1, r * std::cos(a), r * std::sin(a);
        mesh.triangles.row(k) << 0, (k + 1) % facets + 1, k + 1;
    }
    return mesh;
}

/// Two unit spheres; the second at `at`.
TriMesh two_spheres(const Eigen::RowVector3d& at, int subdivisions) {
    TriMesh mesh = icosphere(subdivisions);
    const int nv = mesh.num_vertices(), nt = mesh.num_triangles();
    mesh.vertices.conservativeResize(2 * nv, 3);
    mesh.triangles.conservativeResize(2 * nt, 3);
    mesh.vertices.bottomRows(nv) = mesh.vertices.topRows(nv).rowwise() + at;
    mesh.triangles.bottomRows(nt) = mesh.triangles.topRows(nt).array() + nv;
    return mesh;
}

double drag_coefficient(const TriMesh& mesh, double frontal = pi) {
    return value(newtonian("n", mesh, plain()), mesh, drag) / frontal;
}

}  // namespace

TEST(Newtonian, StagnationPressureByThePitotFormula) {
    EXPECT_NEAR(stagnation_cp(5, 1.4), 1.8088, 5e-5);
    EXPECT_NEAR(stagnation_cp(1e6, 1.4), 1.8394, 5e-5);
    EXPECT_NEAR(stagnation_cp(1, 1.4), (std::pow(1.2, 3.5) - 1) / 0.7, 1e-12);
    EXPECT_THROW(stagnation_cp(0.9, 1.4), InvalidInput);
    EXPECT_THROW(stagnation_cp(NAN, 1.4), InvalidInput);
}

TEST(Newtonian, ExpansionIsIsentropicAndEndsInTheVacuum) {
    EXPECT_NEAR(prandtl_meyer_angle(2, 1.4) * 180 / pi, 26.3798, 1e-4);  // NACA 1135
    const double turn = prandtl_meyer_angle(3, 1.4) - prandtl_meyer_angle(2, 1.4);
    const double ratio = std::pow(1.8 / 2.8, 3.5);
    EXPECT_NEAR(expanded_cp(2, 1.4, turn).cp, 2 / (1.4 * 4) * (ratio - 1), 1e-12);
    EXPECT_NEAR(expanded_cp(2, 1.4, 3).cp, -2 / (1.4 * 4), 1e-15);
    for (const double mach : {1.001, 1.3, 10.0})
        EXPECT_NEAR(expanded_cp(mach, 1.4, 0.05).by_angle,
                    (expanded_cp(mach, 1.4, 0.05 + 1e-6).cp - expanded_cp(mach, 1.4, 0.05 - 1e-6).cp) / 2e-6, 1e-6);
}

TEST(Newtonian, SphereAndSpheroidsConvergeWithTheSquareOfTheEdge) {
    const std::pair<double, double> known[] = {{1, 1}, {2, 0.565595}, {0.5, 1.434405}};
    for (const auto& [k, cd] : known) {
        double error[2];
        for (int level = 0; level < 2; ++level)
            error[level] = std::abs(drag_coefficient(ellipsoid({k, 1, 1}, 3 + level)) - cd);
        EXPECT_NEAR(std::log2(error[0] / error[1]), 2, 0.15) << k;
        EXPECT_LT(error[1], 2e-2) << k;
    }
}

TEST(Newtonian, Cones) {
    const double delta = 10 * pi / 180, t = std::tan(delta), alpha = 5 * pi / 180;
    const TriMesh mesh = cone(delta, 2000);
    EXPECT_NEAR(drag_coefficient(mesh, pi * t * t), 2 * std::pow(std::sin(delta), 2), 1e-6);
    // Below the cone's angle all of it is windward: C_N = cos^2 d sin 2a, C_A = 2 sin^2 d + sin^2 a (1 - 3 sin^2 d).
    const Quantity at = newtonian("n", mesh, plain(alpha));
    const double cn = std::pow(std::cos(delta), 2) * std::sin(2 * alpha), sd = std::sin(delta), sa = std::sin(alpha);
    const double ca = 2 * sd * sd + sa * sa * (1 - 3 * sd * sd);
    const double L = value(at, mesh, lift) / (pi * t * t), D = value(at, mesh, drag) / (pi * t * t);
    EXPECT_NEAR(L, cn * std::cos(alpha) - ca * sa, 1e-6);
    EXPECT_NEAR(D, cn * sa + ca * std::cos(alpha), 1e-6);
    EXPECT_NEAR(value(at, mesh, lift_to_drag), L / D, 1e-12);
    EXPECT_NEAR(value(at, mesh, side), 0, 1e-9);
    // The centre of pressure of a cone: 2/3 of the length over cos^2 d from the apex; lift behind it is nose down.
    EXPECT_NEAR(value(at, mesh, pitch) / (pi * t * t), -cn * 2 / 3 / std::pow(std::cos(delta), 2), 1e-5);
}

TEST(Newtonian, SideslipIsAttackOnItsSide) {
    const TriMesh mesh = ellipsoid({2, 1, 0.5}, 3);
    TriMesh turned = mesh;
    turned.vertices.col(1) = mesh.vertices.col(2);
    turned.vertices.col(2) = -mesh.vertices.col(1);  // what was left is up
    NewtonianFlow slip = plain();
    slip.stream.beta.value = 0.3;
    slip.moment_center << 0.3, 0.1, 0;
    NewtonianFlow attack = plain(0.3);
    attack.moment_center << 0.3, 0, -0.1;
    const Quantity a = newtonian("n", turned, attack), b = newtonian("n", mesh, slip);
    EXPECT_NEAR(value(b, mesh, side), -value(a, turned, lift), 1e-12);  // wind from the right pushes to the left
    EXPECT_NEAR(value(b, mesh, drag), value(a, turned, drag), 1e-12);
    EXPECT_NEAR(value(b, mesh, yaw), -value(a, turned, pitch), 1e-12);
}

TEST(Newtonian, WhatLiesBehindFeelsNothing) {
    const TriMesh hidden = two_spheres({3, 0, 0}, 3), beside = two_spheres({3, 0, 2.5}, 3);
    const double one = value(newtonian("n", icosphere(3), plain()), icosphere(3), drag);
    EXPECT_NEAR(value(newtonian("n", hidden, plain()), hidden, drag), one, 1e-9 * one);
    EXPECT_NEAR(value(newtonian("n", beside, plain()), beside, drag), 2 * one, 1e-12);
    NewtonianFlow see_through = plain();
    see_through.shadows = false;
    EXPECT_NEAR(value(newtonian("n", hidden, see_through), hidden, drag), 2 * one, 1e-12);
    // Half behind: drag of the part of a sphere outside of the other's shadow, int 2 (1 - r^2) over that part.
    const TriMesh half = two_spheres({3, 0, 1}, 4);
    double wanted = 0;
    const int n = 1000;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            const double y = -1 + (2 * i + 1.0) / n, z = -1 + (2 * j + 1.0) / n, r2 = y * y + z * z;
            if (r2 < 1 && y * y + (z + 1) * (z + 1) > 1) wanted += 2 * (1 - r2) * 4 / (n * n);
        }
    const double found = value(newtonian("n", half, plain()), half, drag) -
                         value(newtonian("n", icosphere(4), plain()), icosphere(4), drag);
    EXPECT_NEAR(found, wanted, 0.01 * wanted);
}

TEST(Newtonian, GradientsAreExactAlsoAtTheRimOfAShadow) {
    const TriMesh mesh = two_spheres({2.6, 0.3, 0.8}, 2);
    NewtonianFlow flow = plain(0.1);
    flow.moment_center << 1, 0.2, -0.3;
    for (const LeewardPressure leeward : {LeewardPressure::zero, LeewardPressure::prandtl_meyer}) {
        flow.leeward = leeward;
        flow.mach = 3;
        const Quantity n = newtonian("n", mesh, flow);
        for (std::size_t i = 0; i < n.names.size(); ++i) {
            EXPECT_NEAR(order(n, mesh, 1, i, 1e-4), 2, 0.15) << n.names[i] << " leeward " << static_cast<int>(leeward);
            EXPECT_NEAR(order(n, mesh, 1.1, i, 1e-4), 1, 0.1) << n.names[i];
        }
    }
}

TEST(Newtonian, AFlatBaseAcrossTheStreamHasNoSpuriousGradients) {
    // Below Mach 2.56 a base square to the stream is not in the vacuum: its pressure still changes with the angle, by
    // the same amount whichever way it tilts.
    NewtonianFlow flow = plain();
    flow.leeward = LeewardPressure::prandtl_meyer;
    flow.mach = 2;
    for (const double turned : {0.0, 0.3}) {  // the second one's base is square to the stream up to round-off
        TriMesh box = box_surface(Eigen::Vector3d::Ones(), 4);
        const Eigen::Matrix3d turn = Eigen::AngleAxisd(turned, Eigen::Vector3d(0.2, 1, 0.5).normalized()).matrix();
        box.vertices = box.vertices * turn.transpose();
        flow.stream.forward = turn.col(0);
        flow.stream.up = turn.col(2);
        const Quantity n = newtonian("n", box, flow);
        const Points g = ask(n, box, true).dJ_dv[drag];
        const Points local = box.vertices * turn;
        int inside = 0;
        for (int v = 0; v < box.num_vertices(); ++v) {
            const bool is_base = local(v, 0) > 1 - 1e-9;
            if (!is_base || local.row(v).tail<2>().minCoeff() < 1e-9 || local.row(v).tail<2>().maxCoeff() > 1 - 1e-9)
                continue;
            ++inside;
            EXPECT_LT(g.row(v).norm(), 1e-9) << "turned by " << turned << ", vertex " << v << ": " << g.row(v);
        }
        EXPECT_EQ(inside, 9);
    }
    // A base at a slant has its gradient.
    TriMesh slanted = box_surface(Eigen::Vector3d::Ones(), 2);
    for (int v = 0; v < slanted.num_vertices(); ++v)
        slanted.vertices(v, 0) *= 1 + 0.2 * slanted.vertices(v, 1) + 0.1 * slanted.vertices(v, 2);
    flow.stream = {};
    const Quantity n = newtonian("n", slanted, flow);
    EXPECT_NEAR(order(n, slanted, 1, drag, 1e-4), 2, 0.15);
    EXPECT_NEAR(order(n, slanted, 1.1, drag, 1e-4), 1, 0.1);
}

TEST(Newtonian, DerivativesByTheAngles) {
    const TriMesh mesh = two_spheres({2.6, 0.3, 0.8}, 2);
    NewtonianFlow flow = plain();
    flow.stream.alpha.variable = "a";
    flow.stream.beta.variable = "b";
    flow.moment_center << 1, 0.2, -0.3;
    const Quantity n = newtonian("n", mesh, flow);
    const auto at = [&](double a, double b, bool want) {
        QuantityRequest request{mesh, want, 1, 0, {}};
        request.parameters = {{"mach", 3}, {"b", b}, {"a", a}};
        return n.evaluate(request);
    };
    const QuantityResult here = at(0.1, 0.05, true);
    for (std::size_t i = 0; i < n.names.size(); ++i) {
        const double h = 1e-5;
        ASSERT_EQ(here.dJ_dp[i].size(), 3);
        EXPECT_EQ(here.dJ_dp[i][0], 0);
        const double by_a = (at(0.1 + h, 0.05, false).values[i] - at(0.1 - h, 0.05, false).values[i]) / (2 * h);
        const double by_b = (at(0.1, 0.05 + h, false).values[i] - at(0.1, 0.05 - h, false).values[i]) / (2 * h);
        EXPECT_NEAR(here.dJ_dp[i][2], by_a, 1e-6) << n.names[i];
        EXPECT_NEAR(here.dJ_dp[i][1], by_b, 1e-6) << n.names[i];
    }
    EXPECT_EQ(ask(n, mesh).failure->kind, "undefined");  // without the variables
}

TEST(Newtonian, OnlyWantedSensitivitiesAreMade) {
    const TriMesh mesh = icosphere(1);
    QuantityRequest request{mesh, true, 1, 0, {}};
    request.wanted = {0, 1, 0, 0, 0, 0, 0};
    const QuantityResult result = newtonian("n", mesh, plain()).evaluate(request);
    EXPECT_EQ(result.dJ_dv[0].rows(), 0);
    EXPECT_EQ(result.dJ_dv[1].rows(), mesh.num_vertices());
}

TEST(Newtonian, WhatCannotBeIsRefused) {
    const TriMesh mesh = icosphere(1);
    const auto refused = [&](auto change) {
        NewtonianFlow flow;
        change(flow);
        return refusal([&] { newtonian("aero", mesh, flow); });
    };
    EXPECT_TRUE(has(refused([](auto& f) { f.mach = 0.5; }), "aero: mach = 0.5 must be >= 1"));
    EXPECT_TRUE(has(refused([](auto& f) { f.gamma = 1; }), "gamma = 1 must be in (1, 2]"));
    EXPECT_TRUE(has(refused([](auto& f) { f.reference_area = -1; }), "reference_area"));
    EXPECT_TRUE(has(refused([](auto& f) { f.stream.up = {2, 0, 0}; }), "not parallel"));
    EXPECT_TRUE(has(refused([](auto& f) { f.mach = 1, f.leeward = LeewardPressure::prandtl_meyer; }), "> 1"));
    TriMesh turned = mesh;
    turned.triangles.col(0).swap(turned.triangles.col(1));
    EXPECT_TRUE(has(refusal([&] { newtonian("aero", turned, {}); }), "inside out"));
    TriMesh mixed = mesh;
    std::swap(mixed.triangles(7, 0), mixed.triangles(7, 1));
    EXPECT_TRUE(
        has(refusal([&] { newtonian("aero", mixed, {}); }), "disagree in orientation; set repair: {orient: true}"));
}

TEST(Newtonian, FieldIsThePressureThatEachVertexFeels) {
    const TriMesh ball = icosphere(4);
    const Quantity flow = newtonian("aero", ball, plain());
    const std::vector<SurfaceField> fields = flow.fields(QuantityRequest{ball, false, 1, 0, {}});
    ASSERT_EQ(fields.size(), 1U);
    EXPECT_EQ(fields[0].name, "aero.cp");
    ASSERT_EQ(fields[0].values.size(), ball.num_vertices());
    // 2 cos^2 of the angle from the nose at -x; nothing behind.
    for (int v = 0; v < ball.num_vertices(); ++v) {
        const double cosine = std::max(0.0, -ball.vertices(v, 0));
        EXPECT_NEAR(fields[0].values[v], 2 * cosine * cosine, 0.02) << v;
    }
    // A ball in the wind's shadow of another feels nothing.
    const TriMesh two = two_spheres({3, 0, 0}, 3);
    const Eigen::VectorXd cp = newtonian("aero", two, plain()).fields(QuantityRequest{two, false, 1, 0, {}})[0].values;
    const int first = two.num_vertices() / 2;
    EXPECT_GT(cp.head(first).maxCoeff(), 1.9);
    EXPECT_LT(cp.tail(first).maxCoeff(), 1e-9);
}

TEST(Newtonian, FieldFollowsAParameter) {
    const TriMesh ball = icosphere(3);
    NewtonianFlow flow = plain();
    flow.stream.alpha.variable = "alpha";
    const Quantity aero = newtonian("aero", ball, flow);
    const auto pressures = [&](double alpha) {
        QuantityRequest request{ball, false, 1, 0, {}};
        request.parameters = {{"alpha", alpha}};
        return Eigen::VectorXd(aero.fields(request)[0].values);
    };
    // At 90 degrees the flow comes from below: the lowest vertex is the nose.
    Eigen::Index lowest = 0, most = 0;
    ball.vertices.col(2).minCoeff(&lowest);
    pressures(pi / 2).maxCoeff(&most);
    EXPECT_LT((ball.vertices.row(most) - ball.vertices.row(lowest)).norm(), 0.2);
    EXPECT_GT((pressures(0) - pressures(pi / 2)).norm(), 1);
}
