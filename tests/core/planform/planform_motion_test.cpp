#include "core/planform/planform_motion.hpp"

#include "cases/geometry/dirty_body.hpp"
#include "core/error.hpp"
#include "core/mesh/adjacency.hpp"
#include "derivatives.hpp"
#include "wing_bodies.hpp"

#include <gtest/gtest.h>
#include <numeric>

namespace strake {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double degree = std::numbers::pi / 180;

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

PlanformMotion motion_of(const WingBody& body, const std::vector<PlanformRange>& ranges) {
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

void expect_measured(const WingBody& body, const PlanformMotion& motion, const Wing& wing, std::size_t j,
                     double value) {
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
    for (const WingBody& body : wing_bodies()) {
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
    for (const WingBody& body : wing_bodies()) {
        SCOPED_TRACE(body.name);
        std::vector<PlanformRange> ranges = all_ranges(body.is_joined);
        for (const PlanformChange change : {PlanformChange::aft, PlanformChange::up})
            if (!body.is_joined) ranges.push_back({.change = change, .lower = -0.1, .upper = 0.1});
        const PlanformMotion motion = motion_of(body, ranges);
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

/// A flap behind the wing of Loft, 12 % of the chord below its trailing edge at the tip as at the root.
struct Slotted {
    Loft main, flap;
    TriMesh mesh;
    std::shared_ptr<const Wing> of_main, of_flap;

    explicit Slotted(bool whole = false) {
        main.panels = flap.panels = 60;
        main.cells = flap.cells = 20;
        flap.chord = [](double s) { return 0.25 * (1 - 0.5 * s); };
        flap.quarter = [](double s) { return 1.1 + 0.76 * s; };
        flap.height = [](double s) { return 0.3 * s - 0.06; };
        mesh = both(lofted(main, whole), lofted(flap, whole));
        WingDeclaration declared;
        declared.stations = {0, 0.5, 1};
        if (!whole) declared.symmetry = SymmetryPlane{Vector3d::UnitY(), 0};
        const int half = mesh.num_triangles() / 2;
        for (int part = 0; part < 2; ++part) {
            declared.name = part == 0 ? "main" : "flap";
            declared.triangles.resize(static_cast<std::size_t>(half));
            std::iota(declared.triangles.begin(), declared.triangles.end(), part * half);
            (part == 0 ? of_main : of_flap) = std::make_shared<const Wing>(mesh, declared);
        }
    }
};

TEST(PlanformMotion, GapAndOverlapAreThoseOfTheSection) {
    const Slotted slotted;
    for (const double s : {0.25, 0.5, 0.75}) {
        const SlotFacts slot = slotted.of_flap->slot(slotted.mesh, *slotted.of_main, s);
        // By the lofts: the trailing edge of the one, and points of the other.
        const auto at = [&](const Loft& loft, double x, double side) {
            const double c = loft.chord(s), a = loft.twist(s), dx = (x - 0.25) * c;
            const double half = example::naca_half_thickness(loft.thickness(s), x);
            const double dz = (4 * loft.camber(s) * x * (1 - x) + side * half) * c;
            return Eigen::Vector2d(loft.quarter(s) + std::cos(a) * dx + std::sin(a) * dz,
                                   loft.height(s) - std::sin(a) * dx + std::cos(a) * dz);
        };
        const Eigen::Vector2d edge = at(slotted.main, 1, 0);
        double gap = 9, nose = 9;
        for (int i = 0; i <= 20000; ++i)
            for (const double side : {-1.0, 1.0}) {
                const double x = 0.5 * (1 - std::cos(std::numbers::pi * i / 20000));
                gap = std::min(gap, (at(slotted.flap, x, side) - edge).norm());
                nose = std::min(nose, at(slotted.flap, x, side)[0]);
            }
        EXPECT_NEAR(slot.gap.value, gap, 2e-4) << s;
        EXPECT_NEAR(slot.overlap.value, edge[0] - nose, 3e-4) << s;
        EXPECT_GT(gap, 0.01);
    }
    const Slotted whole(true);
    EXPECT_NEAR(whole.of_flap->slot(whole.mesh, *whole.of_main, 0.5).gap.value,
                slotted.of_flap->slot(slotted.mesh, *slotted.of_main, 0.5).gap.value, 1e-9);
}

TEST(PlanformMotion, AFlapMovesAftAndUpAsItIs) {
    const Slotted slotted;
    PlanformMotion motion(slotted.mesh, {slotted.of_main, slotted.of_flap},
                          {{.wing = 1, .change = PlanformChange::aft, .lower = -0.2, .upper = 0.2},
                           {.wing = 1, .change = PlanformChange::up, .lower = -0.2, .upper = 0.2}});
    EXPECT_EQ(motion.variables()[0].name, "flap.delta_aft");
    EXPECT_EQ(motion.variables()[1].name, "flap.delta_up");
    const double chord = slotted.of_flap->facts(slotted.mesh).mean_chord.value;
    const VectorXd z = Eigen::Vector2d(0.1, -0.05);
    const Points u = motion.displacement(z);
    const int half = slotted.mesh.num_vertices() / 2;
    EXPECT_EQ(u.topRows(half).cwiseAbs().maxCoeff(), 0) << "the main wing stays, to the last bit";
    const Eigen::RowVector3d way(0.1 * chord, 0, -0.05 * chord);
    EXPECT_LT((u.bottomRows(half).rowwise() - way).cwiseAbs().maxCoeff(), 1e-14);
    const auto slot = [&](const TriMesh& of) { return slotted.of_flap->slot(of, *slotted.of_main, 0.5); };
    const SlotFacts before = slot(slotted.mesh), after = slot(with_vertices(slotted.mesh, slotted.mesh.vertices + u));
    EXPECT_NEAR(after.overlap.value, before.overlap.value - 0.1 * chord, 1e-12);
    EXPECT_GT(after.gap.value, before.gap.value + 0.01);
    // Over the main wing's edge: what pierces has a gap below zero.
    const Vector3d nose = slotted.of_flap->station(slotted.mesh, 0.5).leading_edge,
                   edge = slotted.of_main->station(slotted.mesh, 0.5).trailing_edge;
    const Eigen::Vector2d over((edge[0] - nose[0]) / chord - 0.25, (edge[2] - nose[2]) / chord);
    const TriMesh pierced = with_vertices(slotted.mesh, slotted.mesh.vertices + motion.displacement(over));
    EXPECT_LT(slot(pierced).gap.value, 0);
    EXPECT_GT(slot(pierced).gap.value, -0.1 * chord);
}

TEST(PlanformMotion, HalfIsWholeAndPairsStaySymmetric) {
    const std::vector<WingBody> all = wing_bodies();
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
    for (const WingBody& body : wing_bodies()) {
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
    const WingBody body = wing_bodies()[4];
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
    const WingBody body = wing_bodies()[3];
    const auto wing = std::make_shared<const Wing>(body.mesh, body.declared);
    const PlanformMotion motion(body.mesh, {wing},
                                {{.change = PlanformChange::thickness, .lower = -0.2, .upper = 0.2}});
    const TriMesh now = with_vertices(body.mesh, body.mesh.vertices + motion.displacement(VectorXd::Constant(1, 0.2)));
    EXPECT_NEAR(wing->station(now, 0.4).trailing_edge_thickness.value,
                wing->station(body.mesh, 0.4).trailing_edge_thickness.value, 1e-6);
}

TEST(PlanformMotion, ChordMayKeepTheThickness) {
    const WingBody body = wing_bodies()[0];
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
    const WingBody body = wing_bodies()[1];
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
    const std::vector<WingBody> all = wing_bodies();
    const auto refused = [&](const WingBody& body, const PlanformRange& range) {
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

/// A wing of one section all along the span, open at the root, whose trailing edge is a half circle of `radius`.
TriMesh rounded_behind(double radius) {
    constexpr int rows = 13, end = 8, panels = 60;
    std::vector<std::array<double, 2>> section;  // from the trailing edge over the top
    const auto mean = [](double x) { return 0.08 * x * (1 - x); };
    for (int k = -end; k <= end; ++k) {
        const double angle = 0.5 * std::numbers::pi * k / end;
        section.push_back({1 - radius + radius * std::cos(angle), mean(1 - radius) + radius * std::sin(angle)});
    }
    const auto half = [&](double x) { return example::naca_half_thickness(0.12, x) + radius * x / (1 - radius); };
    for (const int side : {1, -1})
        for (int i = 1; i < panels; ++i) {
            const double along = static_cast<double>(side > 0 ? i : panels - i) / panels;
            const double x = (1 - radius) * 0.5 * (1 + std::cos(std::numbers::pi * along));
            section.push_back({x, mean(x) + side * half(x)});
            if (side > 0 && i == panels - 1) section.push_back({0, 0});
        }
    const int around = static_cast<int>(section.size());
    TriMesh mesh;
    mesh.vertices.resize(rows * around, 3);
    std::vector<Eigen::RowVector3i> triangles;
    for (int r = 0; r < rows; ++r)
        for (int k = 0; k < around; ++k) {
            const int next = (k + 1) % around, a = r * around + k, b = r * around + next;
            mesh.vertices.row(a) << section[static_cast<std::size_t>(k)][0], 3.0 * r / (rows - 1),
                section[static_cast<std::size_t>(k)][1];
            if (r + 1 == rows) continue;
            triangles.emplace_back(a, a + around, b), triangles.emplace_back(b, a + around, b + around);
        }
    mesh.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
    for (std::size_t t = 0; t < triangles.size(); ++t) mesh.triangles.row(static_cast<Eigen::Index>(t)) = triangles[t];
    return mesh;
}

/// Its trailing edge was one corner of the circle or another: camber by -1 % moved it by 2e-3 of the chord.
/// Its vertices beyond the last row but one are a point, which no change of a section moves: a variable of that
/// station would be a direction of nothing, with a slope of rounding errors.
TEST(PlanformMotion, StationsOfAPointedTipAreNoVariables) {
    const TriMesh mesh = example::dirty_body("wing_through_body", 7);
    WingDeclaration declared;
    declared.stations = {0.3, 0.6, 0.95, 1};
    const std::vector<int> part = edge_components(mesh, adjacency(mesh));
    int tip = 0;
    for (int t = 0; t < mesh.num_triangles(); ++t)
        if (mesh.vertices(mesh.triangles(t, 0), 1) > mesh.vertices(mesh.triangles(tip, 0), 1)) tip = t;
    for (int t = 0; t < mesh.num_triangles(); ++t)
        if (part[static_cast<std::size_t>(t)] == part[static_cast<std::size_t>(tip)]) declared.triangles.push_back(t);
    const auto wing = std::make_shared<const Wing>(mesh, declared);
    PlanformRange twist{.change = PlanformChange::twist, .by_station = true, .lower = -0.05, .upper = 0.05};
    const PlanformMotion motion(mesh, {wing}, {twist});
    ASSERT_EQ(motion.size(), 3);
    for (int j = 0; j < 3; ++j) {
        EXPECT_EQ(motion.variables()[static_cast<std::size_t>(j)].station,
                  declared.stations[static_cast<std::size_t>(j)]);
        EXPECT_GT(motion.displacement(0.05 * VectorXd::Unit(3, j)).cwiseAbs().maxCoeff(), 1e-4) << j;
    }
    twist.only = {1};
    try {
        PlanformMotion(mesh, {wing}, {twist});
        ADD_FAILURE() << "taken";
    } catch (const InvalidInput& refused) {
        EXPECT_NE(std::string(refused.what()).find("@1: no vertex of the wing moves"), std::string::npos)
            << refused.what();
    }
}

TEST(PlanformMotion, EdgesOfARoundedWingDoNotJump) {
    const TriMesh mesh = rounded_behind(0.002);
    WingDeclaration half;
    half.symmetry = SymmetryPlane{Vector3d::UnitY(), 0};
    half.stations = {0, 0.5, 1};
    const auto wing = std::make_shared<const Wing>(mesh, half);
    const PlanformMotion motion(
        mesh, {wing}, {{.change = PlanformChange::camber, .by_station = true, .lower = -0.02, .upper = 0.02}});
    const StationFacts before = wing->station(mesh, 0.5);
    EXPECT_LT(before.trailing_edge_thickness.value, 1e-9) << "no corner";
    for (int k = -8; k <= 8; ++k) {
        const double camber = 0.002 * k;  // less than there is: of none the largest would be anywhere
        const VectorXd z = camber * VectorXd::Ones(motion.size());
        const StationFacts after = wing->station(with_vertices(mesh, mesh.vertices + motion.displacement(z)), 0.5);
        EXPECT_LT((after.trailing_edge - before.trailing_edge).norm(), 1e-4) << camber;
        EXPECT_LT((after.leading_edge - before.leading_edge).norm(), 1e-4) << camber;
        EXPECT_NEAR(after.camber.value, before.camber.value + camber, 1e-4) << camber;
    }
}

}  // namespace
}  // namespace strake
