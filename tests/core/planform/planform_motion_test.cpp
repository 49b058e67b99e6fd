#include "core/planform/planform_motion.hpp"

#include "core/error.hpp"
#include "derivatives.hpp"
#include "lofted_wing.hpp"

#include <gtest/gtest.h>

namespace strake {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double degree = std::numbers::pi / 180;

struct Body {
    std::string name;
    TriMesh mesh;
    WingDeclaration declared;
    bool is_joined = false;
};

TriMesh both(const TriMesh& a, const TriMesh& b) {
    TriMesh all;
    all.vertices.resize(a.vertices.rows() + b.vertices.rows(), 3);
    all.vertices << a.vertices, b.vertices;
    all.triangles.resize(a.triangles.rows() + b.triangles.rows(), 3);
    all.triangles << a.triangles, Triangles(b.triangles.array() + static_cast<int>(a.vertices.rows()));
    return all;
}

/// A box across the plane y = 0, half of it, that holds the root of a wing.
TriMesh fuselage() {
    TriMesh box;
    box.vertices.resize(8, 3);
    for (int k = 0; k < 8; ++k) box.vertices.row(k) << (k & 1 ? 2.5 : -1), (k & 2 ? 0.4 : 0), (k & 4 ? 0.5 : -0.5);
    box.triangles.resize(10, 3);  // open at y = 0
    box.triangles << 2, 6, 3, 3, 6, 7, 0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5;
    return box;
}

std::vector<Body> bodies() {
    WingDeclaration half;
    half.symmetry = SymmetryPlane{Vector3d::UnitY(), 0};
    half.stations = {0, 0.4, 1};
    WingDeclaration whole = half;
    whole.symmetry.reset();
    std::vector<Body> all;
    Loft loft;
    loft.panels = 60;
    loft.cells = 25;
    all.push_back({"half", lofted(loft), half});
    all.push_back({"whole", lofted(loft, true), whole});
    all.push_back({"between rows", lofted(loft), half});
    all.back().declared.stations = {0, 0.33, 0.71, 1};
    Loft blunt = loft;
    blunt.blunt = 0.004;
    all.push_back({"blunt", lofted(blunt), half});
    Loft kinked = loft;
    kinked.chord = [](double s) { return s < 0.4 ? 1.4 - s : 1 - 0.5 * (s - 0.4); };
    kinked.quarter = [](double s) { return s < 0.4 ? 0.35 + 2 * s : 1.15 + 1.2 * (s - 0.4); };
    kinked.twist = [](double) { return 0.03; };  // its edges are straight
    all.push_back({"kinked", lofted(kinked), half});
    Loft upright = loft;
    upright.winglet = 0.2;
    upright.height = [](double) { return 0.0; };
    upright.cells = 50;
    all.push_back({"winglet", lofted(upright), half});
    all.back().declared.stations = {0, 0.4, 0.9};  // the tip's plane leaves the tip when this turns
    all.push_back({"body", both(fuselage(), lofted(loft)), half});
    for (int t = 0; t < all[0].mesh.num_triangles(); ++t) all.back().declared.triangles.push_back(10 + t);
    Loft slat = loft, flap = loft;
    slat.chord = [](double s) { return 0.15 * (1 - 0.5 * s); };
    slat.quarter = [](double s) { return -0.16 + 1.2 * s + 0.1 * s; };
    slat.height = [](double s) { return 0.3 * s - 0.02; };
    flap.chord = [](double s) { return 0.25 * (1 - 0.5 * s); };
    flap.quarter = [](double s) { return 1.1 + 0.76 * s; };
    flap.height = [](double s) { return 0.3 * s - 0.06; };
    all.push_back({"three elements", both(both(lofted(slat), lofted(loft)), lofted(flap)), half});
    // Joined: what lies within 12 % of the span is a body.
    Body joined{"joined", lofted(loft), half, true};
    for (int t = 0; t < joined.mesh.num_triangles(); ++t) {
        double low = 3;
        for (const int v : joined.mesh.triangles.row(t)) low = std::min(low, joined.mesh.vertices(v, 1));
        if (low > 0.36 - 1e-9) joined.declared.triangles.push_back(t);
    }
    joined.declared.stations = {0, 0.5, 1};  // on rows of the mesh
    all.push_back(joined);
    return all;
}

std::vector<PlanformRange> all_ranges(bool is_joined) {
    std::vector<PlanformRange> all{{.change = PlanformChange::span, .lower = -0.05, .upper = 0.05},
                                   {.change = PlanformChange::sweep, .lower = -5 * degree, .upper = 5 * degree},
                                   {.change = PlanformChange::dihedral, .lower = -3 * degree, .upper = 3 * degree}};
    for (const PlanformChange change :
         {PlanformChange::chord, PlanformChange::twist, PlanformChange::thickness, PlanformChange::camber}) {
        const double limit = change == PlanformChange::twist    ? 4 * degree
                             : change == PlanformChange::camber ? 0.01
                                                                : 0.1;
        all.push_back({.change = change, .by_station = true, .root_held = is_joined, .lower = -limit, .upper = limit});
    }
    return all;
}

PlanformMotion motion_of(const Body& body, const std::vector<PlanformRange>& ranges) {
    return {body.mesh, {std::make_shared<const Wing>(body.mesh, body.declared)}, ranges};
}

/// Values of all variables' places, of the moved surface; those of the whole wing only where asked.
std::vector<double> measured(const TriMesh& now, const Wing& wing, const PlanformMotion& motion, bool with_facts) {
    WingFacts facts;
    if (with_facts) facts = wing.facts(now);
    std::vector<double> all;
    for (const PlanformMotion::Variable& v : motion.variables()) {
        if (v.station < 0) {
            all.push_back(v.change == PlanformChange::span    ? facts.span.value
                          : v.change == PlanformChange::sweep ? facts.sweep.value
                                                              : facts.dihedral.value);
            continue;
        }
        const StationFacts at = wing.station(now, v.station);
        all.push_back(v.change == PlanformChange::chord       ? at.chord.value
                      : v.change == PlanformChange::twist     ? at.twist.value
                      : v.change == PlanformChange::thickness ? at.thickness_to_chord.value
                                                              : at.camber.value);
    }
    return all;
}

void expect_measured(const Body& body, const PlanformMotion& motion, const Wing& wing, std::size_t j, double value) {
    const auto& variables = motion.variables();
    const PlanformMotion::Variable& v = variables[j];
    SCOPED_TRACE(v.name + " = " + std::to_string(value));
    const VectorXd z = value * VectorXd::Unit(motion.size(), static_cast<Eigen::Index>(j));
    const bool with_facts = v.station < 0 || v.station == 0.4 || v.station == 0.33;
    const TriMesh now = with_vertices(body.mesh, body.mesh.vertices + motion.displacement(z));
    const std::vector<double> before = measured(body.mesh, wing, motion, with_facts),
                              after = measured(now, wing, motion, with_facts);
    for (std::size_t k = 0; k < variables.size(); ++k) {
        const double change = k == j ? value : 0;
        double tolerance = 0.005 * std::abs(before[k]), expected = before[k] * (1 + change);
        if (is_angle(variables[k].change)) tolerance = 0.05 * degree, expected = before[k] + change;
        // The mean line of several elements ends at each gap.
        if (body.name == "three elements" && v.change == PlanformChange::camber) tolerance *= 2;
        if (variables[k].change == PlanformChange::camber) {
            tolerance = body.name == "three elements" ? 4e-3 : 1e-4;
            expected = before[k] + change;
        }
        EXPECT_NEAR(after[k], expected, tolerance) << variables[k].name;
    }
}

TEST(PlanformMotion, IsMeasuredBackAtItsLimits) {
    for (const Body& body : bodies()) {
        SCOPED_TRACE(body.name);
        const auto wing = std::make_shared<const Wing>(body.mesh, body.declared);
        const PlanformMotion motion(body.mesh, {wing}, all_ranges(body.is_joined));
        EXPECT_EQ(motion.displacement(VectorXd::Zero(motion.size())).cwiseAbs().maxCoeff(), 0);
        for (std::size_t j = 0; j < motion.variables().size(); ++j)
            for (const double value : {motion.variables()[j].lower, motion.variables()[j].upper})
                expect_measured(body, motion, *wing, j, value);
    }
}

TEST(PlanformMotion, DerivativesAreExact) {
    for (const Body& body : bodies()) {
        SCOPED_TRACE(body.name);
        const PlanformMotion motion = motion_of(body, all_ranges(body.is_joined));
        const Eigen::Index n = body.mesh.num_vertices();
        const VectorXd by = random_vector(3 * n, 7), more = random_vector(3 * n, 8);
        const auto points = [&](const VectorXd& flat) {
            return Points(
                Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>>(flat.data(), n, 3));
        };
        const Points w = points(by);
        VectorXd at = random_vector(motion.size(), 3);
        for (int j = 0; j < motion.size(); ++j) at[j] *= 0.4 * motion.variables()[static_cast<std::size_t>(j)].upper;
        // A cubic of the positions, so that linear variables have a remainder, too.
        const Points start = body.mesh.vertices;
        const auto J = [&](const VectorXd& z) {
            const Points u = motion.displacement(z);
            return u.cwiseProduct(w).sum() + u.array().square().cwiseProduct(points(more).array()).sum();
        };
        const Points u = motion.displacement(at);
        const Points slope = w + 2 * u.cwiseProduct(points(more));
        const VectorXd g = motion.gradient(at, slope);
        for (int j = 0; j < motion.size(); ++j) {
            EXPECT_NEAR(motion.derivative(at, j).cwiseProduct(slope).sum(), g[j], 1e-10 * g.norm());
            const double range = motion.variables()[static_cast<std::size_t>(j)].upper;
            const VectorXd p = range * VectorXd::Unit(motion.size(), j);
            EXPECT_NEAR(taylor_order(J, at, g, p, 0.2), 2, 0.15)
                << motion.variables()[static_cast<std::size_t>(j)].name;
            EXPECT_NEAR(taylor_order(J, at, 1.1 * g, p, 1e-3), 1, 0.1) << "the control must fail";
        }
    }
}

TEST(PlanformMotion, HalfIsWholeAndPairsStaySymmetric) {
    const std::vector<Body> all = bodies();
    const PlanformMotion half = motion_of(all[0], all_ranges(false)), whole = motion_of(all[1], all_ranges(false));
    ASSERT_EQ(half.size(), whole.size());
    VectorXd z = random_vector(half.size(), 5);
    for (int j = 0; j < z.size(); ++j) z[j] *= half.variables()[static_cast<std::size_t>(j)].upper;
    const Points a = half.displacement(z), b = whole.displacement(z);
    const TriMesh &one = all[0].mesh, &two = all[1].mesh;
    const Eigen::Index around = 2 * 60, right = two.num_vertices() - one.num_vertices();
    EXPECT_LT((b.bottomRows(one.num_vertices()) - a).cwiseAbs().maxCoeff(), 1e-10);
    EXPECT_LT(a.topRows(around).col(1).cwiseAbs().maxCoeff(), 1e-15) << "the plane of symmetry";
    for (Eigen::Index row = 1; row * around <= right; ++row) {
        const auto plus = b.middleRows(right + row * around, around),
                   minus = b.middleRows(right - row * around, around);
        EXPECT_LT((plus.col(0) - minus.col(0)).cwiseAbs().maxCoeff(), 1e-13);
        EXPECT_LT((plus.col(1) + minus.col(1)).cwiseAbs().maxCoeff(), 1e-13);
        EXPECT_LT((plus.col(2) - minus.col(2)).cwiseAbs().maxCoeff(), 1e-13);
    }
}

TEST(PlanformMotion, BodiesStayToTheLastBit) {
    for (const Body& body : bodies()) {
        if (body.name != "body" && !body.is_joined) continue;
        SCOPED_TRACE(body.name);
        const PlanformMotion motion = motion_of(body, all_ranges(body.is_joined));
        VectorXd z(motion.size());
        for (int j = 0; j < z.size(); ++j) z[j] = motion.variables()[static_cast<std::size_t>(j)].upper;
        const Points u = motion.displacement(z);
        std::vector<char> of_wing(static_cast<std::size_t>(body.mesh.num_vertices()), 0);
        for (const int t : body.declared.triangles)
            for (const int v : body.mesh.triangles.row(t)) of_wing[static_cast<std::size_t>(v)] = 1;
        for (int v = 0; v < u.rows(); ++v) {
            const bool stays =
                !of_wing[static_cast<std::size_t>(v)] || (body.is_joined && body.mesh.vertices(v, 1) <= 0.36);
            if (stays) {
                EXPECT_EQ(u.row(v).cwiseAbs().maxCoeff(), 0) << v;
            }
        }
        EXPECT_GT(u.cwiseAbs().maxCoeff(), 0.1);
    }
}

/// What is straight between stations stays straight: second differences of the edges over the rows.
TEST(PlanformMotion, EdgesStayStraight) {
    const Body body = bodies()[4];
    const PlanformMotion motion = motion_of(body, all_ranges(false));
    VectorXd z = random_vector(motion.size(), 11);
    for (int j = 0; j < z.size(); ++j) z[j] *= motion.variables()[static_cast<std::size_t>(j)].upper;
    const Points now = body.mesh.vertices + motion.displacement(z);
    for (const int k : {0, 60})
        for (int row = 1; row < 24; ++row) {
            if (row == 10) continue;  // the kink
            const Vector3d bend =
                now.row((row - 1) * 120 + k) - 2 * now.row(row * 120 + k) + now.row((row + 1) * 120 + k);
            EXPECT_LT(bend.norm(), 1e-4) << (k == 0 ? "trailing" : "leading") << " edge, row " << row;
        }
}

TEST(PlanformMotion, TrailingEdgesKeepTheirThickness) {
    const Body body = bodies()[3];
    const auto wing = std::make_shared<const Wing>(body.mesh, body.declared);
    const PlanformMotion motion(body.mesh, {wing},
                                {{.change = PlanformChange::thickness, .lower = -0.2, .upper = 0.2}});
    const TriMesh now = with_vertices(body.mesh, body.mesh.vertices + motion.displacement(VectorXd::Constant(1, 0.2)));
    EXPECT_NEAR(wing->station(now, 0.4).trailing_edge_thickness.value,
                wing->station(body.mesh, 0.4).trailing_edge_thickness.value, 1e-6);
}

TEST(PlanformMotion, ChordMayKeepTheThickness) {
    const Body body = bodies()[0];
    const auto wing = std::make_shared<const Wing>(body.mesh, body.declared);
    const PlanformMotion motion(
        body.mesh, {wing}, {{.change = PlanformChange::chord, .keeps_thickness = true, .lower = -0.2, .upper = 0.2}});
    const TriMesh now = with_vertices(body.mesh, body.mesh.vertices + motion.displacement(VectorXd::Constant(1, 0.2)));
    const StationFacts before = wing->station(body.mesh, 0.4), after = wing->station(now, 0.4);
    EXPECT_NEAR(after.chord.value, 1.2 * before.chord.value, 1e-3);
    EXPECT_NEAR(after.chord.value * after.thickness_to_chord.value,
                before.chord.value * before.thickness_to_chord.value, 5e-4);
}

/// The linear part of the map turns edges into what they are in the end.
TEST(PlanformMotion, LocalMapsAreThoseOfTheSurface) {
    const Body body = bodies()[1];
    const PlanformMotion motion = motion_of(body, all_ranges(false));
    VectorXd z(motion.size());
    for (int j = 0; j < z.size(); ++j) z[j] = 0.5 * motion.variables()[static_cast<std::size_t>(j)].upper;
    const auto maps = motion.local_maps(z);
    const Points now = body.mesh.vertices + motion.displacement(z);
    double worst = 0;
    for (int t = 0; t < body.mesh.num_triangles(); ++t) {
        const auto c = body.mesh.triangles.row(t);
        const Vector3d edge = body.mesh.vertices.row(c[1]) - body.mesh.vertices.row(c[0]);
        const Vector3d moved = now.row(c[1]) - now.row(c[0]);
        worst = std::max(worst, (maps[static_cast<std::size_t>(t)] * edge - moved).norm() / edge.norm());
    }
    EXPECT_LT(worst, 0.05);
}

TEST(PlanformMotion, WhatCannotBeIsRefused) {
    const std::vector<Body> all = bodies();
    const auto refused = [&](const Body& body, const PlanformRange& range) {
        try {
            motion_of(body, {range});
        } catch (const InvalidInput& error) {
            return std::string(error.what());
        }
        return std::string();
    };
    const PlanformRange good{.change = PlanformChange::twist, .lower = -0.05, .upper = 0.05};
    EXPECT_EQ(refused(all[0], good), "");
    PlanformRange bad = good;
    bad.lower = 0.01;
    EXPECT_NE(refused(all[0], bad).find("contain 0"), std::string::npos);
    bad = good, bad.wing = 1;
    EXPECT_NE(refused(all[0], bad).find("must be in [0, 1)"), std::string::npos);
    bad = good, bad.change = PlanformChange::span, bad.by_station = true;
    EXPECT_NE(refused(all[0], bad).find("no stations"), std::string::npos);
    bad = good, bad.change = PlanformChange::sweep, bad.upper = 1.3;
    EXPECT_NE(refused(all[0], bad).find("within 80"), std::string::npos);
    bad = good, bad.change = PlanformChange::chord, bad.lower = -1;
    EXPECT_NE(refused(all[0], bad).find("-90 %"), std::string::npos);
    EXPECT_NE(refused(all.back(), good).find("root: held"), std::string::npos);
    EXPECT_THROW(motion_of(all[0], {good, good}), InvalidInput);
    EXPECT_THROW(motion_of(all[0], {good}).displacement(VectorXd::Zero(2)), InvalidInput);
}

}  // namespace
}  // namespace strake
