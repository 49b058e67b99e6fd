#include "core/planform/kept_sections.hpp"

#include "core/error.hpp"
#include "core/formats/io.hpp"
#include "derivatives.hpp"
#include "wing_bodies.hpp"

#include <gtest/gtest.h>
#include <cstdlib>

namespace strake {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double degree = std::numbers::pi / 180;

/// Bends, sweeps, stretches and twists the wing, and bulges and droops its sections.
Points motion_of(const TriMesh& mesh, double amount) {
    Points motion(mesh.num_vertices(), 3);
    for (Eigen::Index v = 0; v < motion.rows(); ++v) {
        const double x = mesh.vertices(v, 0), y = std::abs(mesh.vertices(v, 1)), z = mesh.vertices(v, 2);
        const double turn = 0.05 * y, side = mesh.vertices(v, 1) < 0 ? -1 : 1;
        const double bump = std::exp(-12 * ((x - 0.8) * (x - 0.8) + (y - 1.5) * (y - 1.5)));
        motion.row(v) << 0.03 * y + turn * z + 0.004 * std::cos(3 * x + 2 * y), side * 0.02 * y * (1 + 0.2 * z),
            0.02 * y * y - turn * (x - 0.4 * y) + 0.01 * std::sin(3 * x - y) + 0.02 * bump + 0.1 * z * std::sin(2 * x);
    }
    return amount * motion;
}

KeptSections kept_of(const WingBody& body, const std::vector<int>& fixed = {}) {
    return {body.mesh, {std::make_shared<const Wing>(body.mesh, body.declared)}, fixed};
}

/// Largest of what the edges (over the chord) and the twist (degrees) are off, between the knots, too.
std::array<double, 2> off(const WingBody& body, const Points& motion) {
    const Wing wing(body.mesh, body.declared);
    const TriMesh now = with_vertices(body.mesh, body.mesh.vertices + motion);
    std::array<double, 2> worst{};
    for (const double station : {0.013, 0.1, 0.203, 0.37, 0.5, 0.61, 0.774, 0.86, 0.91}) {
        const StationFacts a = wing.station(body.mesh, station), b = wing.station(now, station);
        const double chord = a.chord.value;
        worst[0] = std::max({worst[0], (a.leading_edge - b.leading_edge).norm() / chord,
                             (a.trailing_edge - b.trailing_edge).norm() / chord});
        worst[1] = std::max(worst[1], std::abs(a.twist.value - b.twist.value) / degree);
    }
    return worst;
}

/// Three points of a nose within 4 % of the chord at a row, five or six between rows.
WingBody coarse_body() {
    WingBody body = wing_bodies()[0];
    body.name = "coarse nose";
    Loft loft;
    loft.panels = 12;
    loft.cells = 25;
    body.mesh = lofted(loft);
    return body;
}

/// Thicker, and drooped.
Points thicker(const TriMesh& mesh) {
    Points motion = Points::Zero(mesh.num_vertices(), 3);
    for (Eigen::Index v = 0; v < motion.rows(); ++v) {
        const double x = mesh.vertices(v, 0), y = mesh.vertices(v, 1), z = mesh.vertices(v, 2) - 0.1 * y;
        motion(v, 2) = 0.5 * z + 0.02 * std::sin(3 * (x - 0.4 * y));
    }
    return motion;
}

TEST(KeptSections, EdgesAndTwistStayWhereSectionsChange) {
    for (const WingBody& body : wing_bodies()) {
        SCOPED_TRACE(body.name);
        const KeptSections kept = kept_of(body);
        const Points free = motion_of(body.mesh, 1), motion = kept.kept(free);
        const auto before = off(body, free), after = off(body, motion);

        EXPECT_GT(before[0], 0.02) << "the test can fail";
        EXPECT_GT(before[1], 0.5);
        EXPECT_LT(after[0], 1e-4);
        EXPECT_LT(after[1], 0.02);
        EXPECT_GT(motion.rowwise().norm().maxCoeff(), 0.01) << "sections change";
    }
}

/// Nine points within 4 % of the chord: enough for the polynomial that sections are measured by. Runs of before kept
/// such noses by their linear motion.
TEST(KeptSections, NosesOfFewPointsAreKeptAsTheyAreMeasured) {
    WingBody body = wing_bodies()[0];
    Loft loft;
    loft.panels = 32;
    loft.cells = 25;
    body.mesh = lofted(loft);
    const std::vector<std::shared_ptr<const Wing>> wings{std::make_shared<const Wing>(body.mesh, body.declared)};
    const Points motion = thicker(body.mesh);
    const auto now = off(body, KeptSections(body.mesh, wings, {}).kept(motion)),
               before = off(body, KeptSections(body.mesh, wings, {}, KeptRules::earlier).kept(motion));
    EXPECT_LT(now[0], 2e-4) << "between rows of a coarse nose";
    EXPECT_LT(now[1], 0.02);
    EXPECT_GT(before[0], 3 * now[0]);
}

/// Which points show the edge of such a nose changes along the span, and with its shape: the shape stays.
TEST(KeptSections, CoarseNosesKeepTheirShape) {
    const WingBody body = coarse_body();
    const std::vector<std::shared_ptr<const Wing>> wings{std::make_shared<const Wing>(body.mesh, body.declared)};
    const Points motion = thicker(body.mesh), u = KeptSections(body.mesh, wings, {}).kept(motion);
    const auto now = off(body, u),
               before = off(body, KeptSections(body.mesh, wings, {}, KeptRules::coarse_noses_move).kept(motion));
    EXPECT_LT(now[0], 1e-9);
    EXPECT_LT(now[1], 1e-7);
    EXPECT_GT(before[0], 1e-3);
    EXPECT_GT(u.rowwise().norm().maxCoeff(), 0.01) << "sections change";

    Points turned(body.mesh.num_vertices(), 3);  // by 20 degrees: taken out whole, with the nose
    for (Eigen::Index v = 0; v < turned.rows(); ++v) {
        const std::complex<double> w(body.mesh.vertices(v, 0), body.mesh.vertices(v, 2));
        const std::complex<double> to = w * std::polar(1.0, -20 * degree) - w;
        turned.row(v) << to.real(), 0, to.imag();
    }
    EXPECT_LT(KeptSections(body.mesh, wings, {}).kept(turned).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(KeptSections, NosesOfManyPointsAndSharpOnesChangeTheirShape) {
    WingBody sharp = coarse_body();
    for (Eigen::Index v = 0; v < sharp.mesh.num_vertices(); ++v)  // 2.8 % thick: at the nose it turns by 150 degrees
        sharp.mesh.vertices(v, 2) =
            0.1 * sharp.mesh.vertices(v, 1) + 0.2 * (sharp.mesh.vertices(v, 2) - 0.1 * sharp.mesh.vertices(v, 1));
    for (const WingBody& body : {wing_bodies()[0], sharp}) {
        const std::vector<std::shared_ptr<const Wing>> wings{std::make_shared<const Wing>(body.mesh, body.declared)};
        const Points motion = 0.3 * thicker(body.mesh), now = KeptSections(body.mesh, wings, {}).kept(motion);
        EXPECT_EQ(now, KeptSections(body.mesh, wings, {}, KeptRules::coarse_noses_move).kept(motion));
        EXPECT_LT(off(body, now)[0], 1e-4);
    }
}

/// A mesh without rows along the span (STRAKE_DATA): with knots at all its vertices amounts grew without limit.
TEST(KeptSections, AnIrregularMeshHasFewerKnots) {
    const char* folder = std::getenv("STRAKE_DATA");
    if (!folder) GTEST_SKIP() << "STRAKE_DATA is not set";
    const TriMesh mesh = read_surface(std::string(folder) + "/three_element_wing_cpanel.tri").mesh;
    const KeptSections kept(mesh, {std::make_shared<const Wing>(mesh, WingDeclaration{})}, {});
    EXPECT_GT(kept.num_knots(), 10);
    const Points motion = motion_of(mesh, 0.2), u = kept.kept(motion);
    EXPECT_LT(u.rowwise().norm().maxCoeff(), 2 * motion.rowwise().norm().maxCoeff());
    const Points w = motion_of(mesh, 1).cwiseAbs();
    EXPECT_NEAR(kept.rate(nullptr, motion).cwiseProduct(w).sum(),
                kept.pulled_back(nullptr, w).cwiseProduct(motion).sum(), 1e-9 * motion.norm() * w.norm());
}

TEST(KeptSections, MotionsOfTheSectionsInTheirPlanesAreTakenOutWhole) {
    const WingBody body = wing_bodies()[0];
    const KeptSections kept = kept_of(body);
    EXPECT_EQ(kept.kept(Points::Zero(body.mesh.num_vertices(), 3)).cwiseAbs().maxCoeff(), 0);
    Points motion(body.mesh.num_vertices(), 3);  // turned by 20 degrees, scaled, moved
    for (Eigen::Index v = 0; v < motion.rows(); ++v) {
        const std::complex<double> w(body.mesh.vertices(v, 0), body.mesh.vertices(v, 2));
        const std::complex<double> moved = w * std::polar(1.1, -20 * degree) - w + std::complex(0.3, -0.2);
        motion.row(v) << moved.real(), 0.1 * body.mesh.vertices(v, 1), moved.imag();
    }
    EXPECT_LT(kept.kept(motion).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_LT(kept.rate(nullptr, motion).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(KeptSections, DerivativesAreExact) {
    std::vector<WingBody> bodies = wing_bodies();
    bodies.push_back(coarse_body());
    for (const WingBody& body : bodies) {
        SCOPED_TRACE(body.name);
        const KeptSections kept = kept_of(body);
        const Eigen::Index n = body.mesh.num_vertices();
        const Points one = motion_of(body.mesh, 0.5), other = motion_of(body.mesh, 1).array().square();
        Points w = Eigen::Map<const Points>(random_vector(3 * n, 7).eval().data(), n, 3);
        const Points more = Eigen::Map<const Points>(random_vector(3 * n, 8).eval().data(), n, 3);
        const auto motion = [&](const VectorXd& x) -> Points { return x[0] * one + x[1] * 20 * other; };
        const auto J = [&](const VectorXd& x) {
            const Points u = kept.kept(motion(x));
            return u.cwiseProduct(w).sum() + (u.array().square() * more.array()).sum();
        };
        const VectorXd x = Eigen::Vector2d(0.6, 0.3), p = Eigen::Vector2d(0.5, -0.4);
        const Points u = kept.kept(motion(x)), surface = body.mesh.vertices + u;
        const Points slope = w + 2 * u.cwiseProduct(more), pulled = kept.pulled_back(&surface, slope);
        const VectorXd g = Eigen::Vector2d(pulled.cwiseProduct(one).sum(), 20 * pulled.cwiseProduct(other).sum());
        EXPECT_NEAR(kept.rate(&surface, one).cwiseProduct(slope).sum(), g[0], 1e-9 * g.norm());
        EXPECT_NEAR(taylor_order(J, x, g, p, 0.1), 2, 0.2);
        EXPECT_NEAR(taylor_order(J, x, 1.1 * g, p, 1e-3), 1, 0.1) << "the control must fail";
    }
}

TEST(KeptSections, HalfIsWholeAndPairsStaySymmetric) {
    const std::vector<WingBody> all = wing_bodies();
    const WingBody &half = all[0], &whole = all[1];
    const Points a = kept_of(half).kept(motion_of(half.mesh, 1)), b = kept_of(whole).kept(motion_of(whole.mesh, 1));
    EXPECT_LT((b.bottomRows(half.mesh.num_vertices()) - a).cwiseAbs().maxCoeff(), 1e-10);
    const Eigen::Index around = 2 * 60, right = whole.mesh.num_vertices() - half.mesh.num_vertices();
    for (Eigen::Index row = 1; row * around <= right; ++row) {
        const Points plus = b.middleRows(right + row * around, around),
                     minus = b.middleRows(right - row * around, around);
        EXPECT_LT((plus.col(0) - minus.col(0)).cwiseAbs().maxCoeff(), 1e-12);
        EXPECT_LT((plus.col(1) + minus.col(1)).cwiseAbs().maxCoeff(), 1e-12);
        EXPECT_LT((plus.col(2) - minus.col(2)).cwiseAbs().maxCoeff(), 1e-12);
    }
}

TEST(KeptSections, WhatIsFixedAndOtherPartsAreLeftAlone) {
    const WingBody body = wing_bodies()[6];  // a box of ten triangles holds the root
    std::vector<int> fixed;                  // a spar box
    for (int t = 10; t < body.mesh.num_triangles(); ++t) {
        bool is_inside = true;
        for (const int v : body.mesh.triangles.row(t)) {
            const double y = body.mesh.vertices(v, 1), x = body.mesh.vertices(v, 0) - 0.4 * y;
            is_inside = is_inside && y < 1.5 && std::abs(x - 0.4 * (1 - y / 6)) < 0.15;
        }
        if (is_inside) fixed.push_back(t);
    }
    ASSERT_GT(fixed.size(), 20);
    Points motion = motion_of(body.mesh, 1);
    std::vector<char> is_fixed(static_cast<std::size_t>(body.mesh.num_vertices()), 0);
    for (const int t : fixed)
        for (const int v : body.mesh.triangles.row(t)) is_fixed[static_cast<std::size_t>(v)] = 1;
    for (int v = 0; v < body.mesh.num_vertices(); ++v) {  // as a shell does: it begins at what is fixed
        double away = 1;
        for (int w = 0; w < body.mesh.num_vertices(); ++w)
            if (is_fixed[static_cast<std::size_t>(w)])
                away = std::min(away, (body.mesh.vertices.row(v) - body.mesh.vertices.row(w)).norm() / 0.3);
        motion.row(v) *= away * away * (3 - 2 * away);
    }
    const Points kept = kept_of(body, fixed).kept(motion);
    for (const int t : fixed)
        for (const int v : body.mesh.triangles.row(t)) EXPECT_EQ(kept.row(v).norm(), 0);
    EXPECT_EQ(kept.topRows(8), motion.topRows(8)) << "the body";
    const auto after = off(body, kept);
    EXPECT_LT(after[0], 1e-4);
    EXPECT_LT(after[1], 0.02);
}

void check_maps(const WingBody& body) {
    SCOPED_TRACE(body.name);
    const KeptSections kept = kept_of(body);
    // A linear motion has the same map everywhere; what is kept of it is what the corners show, in each triangle.
    Eigen::Matrix3d slope;
    slope << 0.01, 0.02, 0.03, 0, -0.02, 0.01, 0.05, 0.03, 0.04;
    const Points motion = body.mesh.vertices * slope.transpose(), moved = kept.rate(nullptr, motion);
    std::vector<Eigen::Matrix3d> maps(static_cast<std::size_t>(body.mesh.num_triangles()),
                                      Eigen::Matrix3d::Identity() + slope);
    kept.change_maps(motion, maps);
    double worst = 0;
    for (int t = 0; t < body.mesh.num_triangles(); ++t)
        for (int k = 1; k < 3; ++k) {
            const int a = body.mesh.triangles(t, 0), b = body.mesh.triangles(t, k);
            if (body.mesh.vertices(a, 1) < 0.5 || body.mesh.vertices(b, 1) < 0.5) continue;  // where S fades
            const Vector3d edge = body.mesh.vertices.row(b) - body.mesh.vertices.row(a);
            const Vector3d wanted = (moved.row(b) - moved.row(a)).transpose() + edge;
            worst = std::max(worst, (maps[static_cast<std::size_t>(t)] * edge - wanted).norm() / edge.norm());
        }
    EXPECT_LT(worst, 1e-10);
    const auto G = random_vector(9, 4).reshaped(3, 3).eval();
    double largest = 0;
    for (int t = 3; t < body.mesh.num_triangles(); t += 97) {
        Points by_motion;
        const Eigen::Matrix3d by_map = kept.pull_map(t, G, by_motion);
        const double change = (maps[static_cast<std::size_t>(t)] - Eigen::Matrix3d::Identity()).cwiseProduct(G).sum();
        EXPECT_NEAR(by_map.cwiseProduct(slope).sum() + by_motion.cwiseProduct(motion).sum(), change, 1e-10);
        largest = std::max(largest, by_motion.norm());
    }
    EXPECT_GT(largest, 1e-6);
}

TEST(KeptSections, MapsOfTrianglesFollow) {
    check_maps(wing_bodies()[8]);  // joined to a body
    check_maps(coarse_body());
}

}  // namespace
}  // namespace strake
