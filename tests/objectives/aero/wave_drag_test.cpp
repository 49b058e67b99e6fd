#include "objectives/aero/wave_drag.hpp"

#include "ask.hpp"
#include "cases/geometry/slender_body.hpp"
#include "core/mesh/geometry.hpp"
#include "objectives/aero/area_distribution.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <numbers>

using namespace strake;

namespace {

constexpr double pi = std::numbers::pi;

/// P_ij = sum over n >= 2 of g_n(k_i) g_n(k_j) / n, by which a series of sines gives the integral.
double series(double a, double b) {
    const auto g = [](int n, double k) {
        const double theta = std::acos(1 - 2 * k);
        return std::sin((n - 1) * theta) / (n - 1) - std::sin((n + 1) * theta) / (n + 1);
    };
    double sum = 0;
    for (int n = 2; n < 4000; ++n) sum += g(n, a) * g(n, b) / n;
    return sum;
}

/// Body of revolution of the same sectional areas as the circles, from a point (x, 0) on, with a flat base.
TriMesh lathe(const std::vector<Eigen::Vector2d>& meridian, int facets) {
    const int rings = static_cast<int>(meridian.size()) - 1, last = rings * facets + 1;
    const double polygon = std::sqrt(2 * pi / (facets * std::sin(2 * pi / facets)));
    TriMesh mesh;
    mesh.vertices = Points::Zero(last + 1, 3);
    mesh.triangles.resize(2 * rings * facets, 3);
    mesh.vertices(0, 0) = meridian.front()[0];
    mesh.vertices(last, 0) = meridian.back()[0];
    int t = 0;
    for (int i = 0; i < rings; ++i)
        for (int j = 0; j < facets; ++j) {
            const double a = 2 * pi * j / facets, r = meridian[i + 1][1] * polygon;
            const int v = 1 + i * facets + j, w = 1 + i * facets + (j + 1) % facets;
            mesh.vertices.row(v) << meridian[i + 1][0], r * std::cos(a), r * std::sin(a);
            if (i == 0) mesh.triangles.row(t++) << 0, w, v;
            if (i > 0) mesh.triangles.row(t++) << v - facets, w - facets, v;
            if (i > 0) mesh.triangles.row(t++) << w - facets, w, v;
            if (i + 1 == rings) mesh.triangles.row(t++) << last, v, w;
        }
    return mesh;
}

/// Marks of the triangles that lie in the plane x = at.
std::vector<char> base_at(const TriMesh& mesh, double at) {
    std::vector<char> base(mesh.num_triangles(), 0);
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        base[t] = 1;
        for (int k = 0; k < 3; ++k) base[t] &= std::abs(mesh.vertices(mesh.triangles(t, k), 0) - at) < 1e-9;
    }
    return base;
}

}  // namespace

TEST(AreaDistribution, EqualsTheSectionsOfABox) {
    const TriMesh box = box_surface({2, 3, 4}, 3);
    const AreaDistribution at =
        area_distribution(box, {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitX(), {0.25, 0.5, 0.75}});
    EXPECT_NEAR((at.area.array() - 12).abs().maxCoeff(), 0, 1e-12);
    EXPECT_NEAR(at.by_position.cwiseAbs().maxCoeff(), 0, 1e-12);
    // Oblique: projected along x it is still 12 where the section meets only the long sides.
    const AreaDistribution oblique = area_distribution(box, {Eigen::Vector3d::UnitX(), {1, 0.1, 0.1}, {0.5}});
    EXPECT_NEAR(oblique.area[0], 12, 1e-12);
}

TEST(WaveDrag, TheMatrixIsTheSeriesOfSines) {
    const std::vector<double> k{0.1, 0.45, 0.5, 0.93};
    const Eigen::MatrixXd P = eminton_matrix(k);
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) EXPECT_NEAR(P(i, j), series(k[i], k[j]), 1e-6) << i << j;
}

TEST(WaveDrag, SearsHaack) {
    const double L = 10, R = 0.5;
    const TriMesh mesh = example::wavy_body(20000, {L, R, 0, 0});
    const double V = 3 * pi * pi / 16 * R * R * L;
    const double D = value(wave_drag("w", mesh, {}), mesh);
    EXPECT_NEAR(D / (pi * R * R), 24 * V / (L * L * L), 0.01 * 24 * V / (L * L * L));
    EXPECT_NEAR(D / (pi * R * R), 4.5 * pi * pi * (R / L) * (R / L), 0.01 * 4.5 * pi * pi * (R / L) * (R / L));
    // Slender: the Mach number hardly matters.
    WaveDrag oblique;
    oblique.mach = 1.5;
    EXPECT_NEAR(value(wave_drag("w", mesh, oblique), mesh), D, 0.03 * D);
    const TriMesh wavy = example::wavy_body(20000, {L, R, 0.3, 2.5});
    EXPECT_GT(value(wave_drag("w", wavy, {}), wavy), 1.5 * D);
}

TEST(WaveDrag, VonKarmanOgive) {
    // Least drag at given length and base area: D/q = 4/pi (B/L)^2, the first term alone.
    const double L = 5, R = 0.3;
    WaveDrag flow;
    flow.stations = 30;
    const int rings = 400;
    std::vector<Eigen::Vector2d> meridian;
    for (int i = 0; i <= rings; ++i) {
        const double k = 0.5 * (1 - std::cos(pi * i / rings));
        meridian.push_back({L * k, R * std::sqrt(eminton_base(k))});
    }
    const TriMesh mesh = lathe(meridian, 64);
    const double wanted = 4 / pi * std::pow(pi * R * R / L, 2);
    EXPECT_NEAR(value(wave_drag("w", mesh, flow), mesh), wanted, 0.01 * wanted);
}

/// What a body does in the last thousandth of its length counts where its base is stated, and only there.
TEST(WaveDrag, TheAreaOfAStatedBaseIsThatAtTheEnd) {
    const double L = 5, R = 0.3, flare = 1.2;
    std::vector<Eigen::Vector2d> meridian;
    for (int i = 0; i <= 400; ++i) {
        const double k = 0.5 * (1 - std::cos(pi * i / 400));
        if (k < 1 - 5e-4) meridian.push_back({L * k, R * std::sqrt(eminton_base(k))});
    }
    meridian.push_back({L, flare * R});
    const TriMesh mesh = lathe(meridian, 64);
    WaveDrag flow;
    flow.stations = 30;
    const double unseen = value(wave_drag("w", mesh, flow), mesh);
    flow.base = base_at(mesh, L);
    const double seen = value(wave_drag("w", mesh, flow), mesh), wanted = 4 / pi * std::pow(pi * R * R / L, 2);
    EXPECT_NEAR(unseen, wanted, 0.01 * wanted);
    EXPECT_GT(seen, std::pow(flare, 4) * wanted) << "no less than the ogive of the larger base";
}

TEST(WaveDrag, ConeCylinderAgreesWithSlenderBodyTheory) {
    // Ward: C_D = d^2 (2 ln(2 / (beta d)) - 1) on the cone's base, d = tan of the half angle, none behind the shoulder.
    const double d = 0.08, beta = 1;
    std::vector<Eigen::Vector2d> meridian;
    for (int i = 0; i <= 300; ++i) meridian.push_back({0.01 * i, d * std::min(1.0, 0.01 * i)});
    const TriMesh mesh = lathe(meridian, 64);
    WaveDrag flow;
    flow.mach = std::sqrt(1 + beta * beta);
    flow.stations = 120;
    flow.angles = 4;
    flow.base = base_at(mesh, 3);
    const double wanted = d * d * (2 * std::log(2 / (beta * d)) - 1);
    const double found = value(wave_drag("w", mesh, flow), mesh) / (pi * d * d);
    EXPECT_NEAR(found, wanted, 0.06 * wanted);
}

TEST(WaveDrag, DerivativesAreExact) {
    const TriMesh mesh = ellipsoid({3, 0.6, 0.4}, 3);
    WaveDrag flow;
    flow.stations = 12;
    for (const double mach : {1.0, 1.7}) {
        flow.mach = mach;
        flow.angles = 3;
        const Quantity drag = wave_drag("w", mesh, flow);
        EXPECT_NEAR(order(drag, mesh, 1, 0, 1e-4), 2, 0.15) << mach;
        EXPECT_NEAR(order(drag, mesh, 1.1, 0, 1e-4), 1, 0.1) << mach;
    }
}

TEST(WaveDrag, AHalfModelHasHalfOfItAndScales) {
    const TriMesh mesh = example::wavy_body(2000, {4, 0.4, 0.2, 1.5}), even = half_above(mesh);
    WaveDrag flow;
    flow.mach = 1.6;
    const SymmetryPlane symmetry{Eigen::Vector3d::UnitY(), 0};
    const double D = value(wave_drag("w", mesh, flow), mesh);
    EXPECT_NEAR(value(wave_drag("w", even, flow, symmetry), even), 0.5 * D, 1e-9 * D);
    // Along directions that keep the vertices of the plane in it, from a shape without equal ends.
    TriMesh half = even;
    Points p = points(random_vector(half.vertices.size(), 3));
    for (int v = 0; v < half.num_vertices(); ++v)
        if (half.vertices(v, 1) == 0) p(v, 1) = 0;
    half.vertices += 1e-3 * p;
    const Quantity of_half = wave_drag("w", half, flow, symmetry);
    const auto J = [&](const Eigen::VectorXd& x) { return value(of_half, with_vertices(half, points(x))); };
    const Eigen::VectorXd g = flat(ask(of_half, half, true).dJ_dv.at(0));
    EXPECT_NEAR(taylor_order(J, flat(half.vertices), g, flat(p), 1e-4), 2, 0.2);
    EXPECT_NEAR(taylor_order(J, flat(half.vertices), 1.1 * g, flat(p), 1e-4), 1, 0.2);
    const TriMesh large = moved(mesh, 100, {5, -3, 1});
    EXPECT_NEAR(value(wave_drag("w", large, flow), large), 1e4 * D, 1e-6 * 1e4 * D);
}

TEST(WaveDrag, AreasOfASurfaceBesideAreAdded) {
    const TriMesh body = ellipsoid({3, 0.4, 0.4}, 3), fin = moved(ellipsoid({0.8, 0.05, 0.5}, 2), 1, {0.7, 0, 1.2});
    TriMesh turned = fin, both = body;
    turned.triangles.col(0).swap(turned.triangles.col(1));
    both.vertices.conservativeResize(body.num_vertices() + fin.num_vertices(), 3);
    both.vertices.bottomRows(fin.num_vertices()) = fin.vertices;
    both.triangles.conservativeResize(body.num_triangles() + fin.num_triangles(), 3);
    both.triangles.bottomRows(fin.num_triangles()) = fin.triangles.array() + body.num_vertices();
    WaveDrag flow, with_fin;
    flow.stations = with_fin.stations = 16;
    flow.mach = with_fin.mach = 1.3;
    with_fin.beside = fin;
    const double alone = value(wave_drag("w", body, flow), body), wanted = value(wave_drag("w", both, flow), both);
    const Quantity drag = wave_drag("w", body, with_fin);
    EXPECT_NEAR(value(drag, body), wanted, 1e-12 * wanted);
    EXPECT_GT(std::abs(wanted - alone), 0.01 * alone);
    with_fin.beside = turned;  // whichever way its triangles run
    EXPECT_NEAR(value(wave_drag("w", body, with_fin), body), wanted, 1e-12 * wanted);
    EXPECT_NEAR(order(drag, body, 1, 0, 1e-4), 2, 0.15);
    EXPECT_NEAR(order(drag, body, 1.1, 0, 1e-4), 1, 0.1);
    // Half of both has half of the drag; marks of a base count triangles of the body alone.
    const SymmetryPlane symmetry{Eigen::Vector3d::UnitY(), 0};
    const TriMesh wavy = example::wavy_body(2000, {4, 0.4, 0.2, 1.5}), half = half_above(wavy);
    const TriMesh store = moved(example::wavy_body(500, {2, 0.2, 0.1, 1.5}), 1, {0.5, 0, 1});
    with_fin.beside = store;
    const double whole = value(wave_drag("w", wavy, with_fin), wavy);
    with_fin.beside = half_above(store);
    EXPECT_NEAR(value(wave_drag("w", half, with_fin, symmetry), half), 0.5 * whole, 1e-9 * whole);
    with_fin.base.assign(static_cast<std::size_t>(half.num_triangles()), 0);
    EXPECT_NO_THROW(value(wave_drag("w", half, with_fin, symmetry), half));
    with_fin.base.clear();
    EXPECT_TRUE(has(refusal([&] { wave_drag("w", body, with_fin); }), "w: the surface beside it: the surface is open"));
}

TEST(WaveDrag, WhatCannotBeIsRefused) {
    const TriMesh mesh = icosphere(1);
    WaveDrag flow;
    flow.mach = 0.8;
    EXPECT_TRUE(has(refusal([&] { wave_drag("w", mesh, flow); }), "w: mach = 0.8 must be >= 1"));
    flow = {};
    flow.stations = 2;
    EXPECT_TRUE(has(refusal([&] { wave_drag("w", mesh, flow); }), "stations"));
    EXPECT_TRUE(has(refusal([&] { wave_drag("w", half_above(mesh), {}); }), "w: the surface is open"));
    EXPECT_TRUE(has(refusal([&] { wave_drag("w", mesh, {}, SymmetryPlane{Eigen::Vector3d::UnitX(), 0}); }), "crosses"));
}
