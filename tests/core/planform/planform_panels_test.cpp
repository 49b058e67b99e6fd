#include "core/error.hpp"
#include "core/planform/planform_motion.hpp"
#include "derivatives.hpp"
#include "wing_bodies.hpp"

#include <gtest/gtest.h>

/// Sweep and dihedral from station to station.
namespace strake {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double degree = std::numbers::pi / 180;

/// Its rows of vertices lie half a row farther outboard at the leading edge than at the trailing edge, and stations
/// between them.
WingBody oblique() {
    Loft loft;
    loft.panels = 60;
    loft.cells = 50;
    const TriMesh even = lofted(loft);
    WingBody body{"oblique rows", even, wing_bodies()[0].declared};
    body.declared.stations = {0, 0.335, 0.71, 1};
    constexpr int around = 120, rows = 51;
    for (int r = 2; r + 2 < rows; ++r)
        for (int k = 0; k < around; ++k) {
            const double aft = 0.5 * (1 + std::cos(2 * std::numbers::pi * k / around));
            const int v = r * around + k;
            body.mesh.vertices.row(v) += 0.5 * (1 - aft) * (even.vertices.row(v + around) - even.vertices.row(v));
        }
    return body;
}

/// Of all kinds; the winglet has a bend: beyond a sharp corner there are no sections.
std::vector<WingBody> bodies() {
    std::vector<WingBody> all = wing_bodies();
    for (WingBody& body : all)
        if (body.name == "winglet") body = bent_up();
    all.push_back(oblique());
    return all;
}

std::vector<PlanformRange> by_panel(double sweep = 8 * degree, double dihedral = 6 * degree) {
    return {{.change = PlanformChange::sweep, .by_station = true, .lower = -sweep, .upper = sweep},
            {.change = PlanformChange::dihedral, .by_station = true, .lower = -dihedral, .upper = dihedral}};
}

/// With all else that a wing may change.
std::vector<PlanformRange> beside_others(bool is_joined) {
    std::vector<PlanformRange> all = by_panel();
    all.push_back({.change = PlanformChange::span, .lower = -0.1, .upper = 0.1});
    for (const PlanformChange change : {PlanformChange::chord, PlanformChange::twist})
        all.push_back({.change = change, .by_station = true, .root_held = is_joined, .lower = -0.1, .upper = 0.1});
    return all;
}

PlanformMotion motion_of(const WingBody& body, const std::vector<PlanformRange>& ranges) {
    return {body.mesh, {std::make_shared<const Wing>(body.mesh, body.declared)}, ranges};
}

TriMesh moved(const WingBody& body, const PlanformMotion& motion, const VectorXd& z) {
    return with_vertices(body.mesh, body.mesh.vertices + motion.displacement(z));
}

Points random_points(Eigen::Index n, unsigned seed) {
    const VectorXd flat = random_vector(3 * n, seed);
    return Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>>(flat.data(), n, 3);
}

TEST(PlanformPanels, LieBetweenStationsRootAndTip) {
    WingBody body = bodies()[4];  // kinked
    body.declared.stations = {0.4, 0.8};
    const Wing wing(body.mesh, body.declared);
    EXPECT_EQ(wing.panel_ends(), (std::vector<double>{0, 0.4, 0.8, 1}));
    for (const auto& [at, from, to] : {std::array{0.0, 0.0, 0.4}, std::array{0.3, 0.0, 0.4}, std::array{0.4, 0.4, 0.8},
                                       std::array{0.9, 0.8, 1.0}, std::array{1.0, 0.8, 1.0}}) {
        EXPECT_EQ(wing.panel(body.mesh, at).from, from) << at;
        EXPECT_EQ(wing.panel(body.mesh, at).to, to) << at;
    }
    // Of the loft: quarter chord 0.35 + 2 s, then 1.15 + 1.2 (s - 0.4); height 0.3 s; semispan 3.
    EXPECT_NEAR(wing.panel(body.mesh, 0).sweep.value, std::atan(2.0 / 3), 1e-4);
    EXPECT_NEAR(wing.panel(body.mesh, 0.4).sweep.value, std::atan(1.2 / 3), 1e-4);
    EXPECT_NEAR(wing.panel(body.mesh, 0).dihedral.value, std::atan(0.1), 1e-4);
    EXPECT_NEAR(wing.panel(body.mesh, 0.4).width.value, 1.2, 1e-9);
}

/// Each by itself: the others, and chord, twist, t/c and camber, stay.
void expect_measured(const WingBody& body, const PlanformMotion& motion, const Wing& wing, int j, double value) {
    const PlanformMotion::Variable& v = motion.variables()[static_cast<std::size_t>(j)];
    SCOPED_TRACE(v.name + " = " + std::to_string(value / degree));
    const TriMesh now = moved(body, motion, value * VectorXd::Unit(motion.size(), j));
    const std::vector<double> ends = wing.panel_ends();
    for (std::size_t k = 0; k + 1 < ends.size(); ++k) {
        const PanelFacts before = wing.panel(body.mesh, ends[k]), after = wing.panel(now, ends[k]);
        const bool is_this = ends[k] == v.station;
        const double sweep = is_this && v.change == PlanformChange::sweep ? value : 0;
        const double dihedral = is_this && v.change == PlanformChange::dihedral ? value : 0;
        EXPECT_NEAR(after.sweep.value, before.sweep.value + sweep, 0.05 * degree) << ends[k];
        EXPECT_NEAR(after.dihedral.value, before.dihedral.value + dihedral, 0.05 * degree) << ends[k];
        EXPECT_NEAR(after.width.value, before.width.value, 0.005 * before.width.value);
    }
    for (const double station : wing.stations()) {
        const StationFacts before = wing.station(body.mesh, station), after = wing.station(now, station);
        EXPECT_NEAR(after.chord.value, before.chord.value, 0.005 * before.chord.value) << station;
        EXPECT_NEAR(after.twist.value, before.twist.value, 0.05 * degree) << station;
        EXPECT_NEAR(after.thickness_to_chord.value, before.thickness_to_chord.value,
                    0.005 * before.thickness_to_chord.value)
            << station;
        EXPECT_NEAR(after.camber.value, before.camber.value, body.name == "three elements" ? 4e-3 : 2e-4) << station;
    }
}

TEST(PlanformPanels, AreMeasuredBackAtTheirLimits) {
    for (const WingBody& body : bodies()) {
        SCOPED_TRACE(body.name);
        const auto wing = std::make_shared<const Wing>(body.mesh, body.declared);
        const PlanformMotion motion(body.mesh, {wing}, by_panel());
        EXPECT_EQ(motion.displacement(VectorXd::Zero(motion.size())).cwiseAbs().maxCoeff(), 0);
        const int panels = static_cast<int>(wing->panel_ends().size()) - 1;
        EXPECT_EQ(motion.size(), 2 * panels - (body.name == "winglet" ? 1 : 0)) << "an upright panel has no dihedral";
        for (int j = 0; j < motion.size(); ++j)
            for (const double sign : {-1.0, 1.0})
                expect_measured(body, motion, *wing, j, sign * motion.variables()[static_cast<std::size_t>(j)].upper);
    }
}

/// Largest of what should stay at the stations under any variable at its limits: shares of chord and t/c, degrees.
std::array<double, 3> off_elsewhere(const WingBody& body, StationCorners corners) {
    const auto wing = std::make_shared<const Wing>(body.mesh, body.declared);
    std::vector<PlanformRange> ranges = by_panel();
    for (const auto& [change, range] : {std::pair{PlanformChange::chord, 0.1},
                                        {PlanformChange::twist, 5 * degree},
                                        {PlanformChange::thickness, 0.15}})
        ranges.push_back({.change = change, .by_station = true, .lower = -range, .upper = range});
    const PlanformMotion motion(body.mesh, {wing}, ranges, {}, corners);
    std::array<double, 3> off{};
    for (int j = 0; j < motion.size(); ++j)
        for (const double sign : {-1.0, 1.0}) {
            const auto& v = motion.variables()[static_cast<std::size_t>(j)];
            const TriMesh now = moved(body, motion, sign * v.upper * VectorXd::Unit(motion.size(), j));
            for (const double station : wing->stations()) {
                const StationFacts a = wing->station(body.mesh, station), b = wing->station(now, station);
                const auto count = [&](PlanformChange change, std::size_t k, double by) {
                    if (v.change != change) off[k] = std::max(off[k], std::abs(by));
                };
                count(PlanformChange::chord, 0, b.chord.value / a.chord.value - 1);
                count(PlanformChange::thickness, 1, b.thickness_to_chord.value / a.thickness_to_chord.value - 1);
                count(PlanformChange::twist, 2, (b.twist.value - a.twist.value) / degree);
            }
        }
    return off;
}

/// Triangles cut a kink's corner, at the leading edge otherwise than at the trailing edge. Where changes are level as
/// far as those triangles reach, the section at the station shows its own.
TEST(PlanformPanels, ObliqueRowsShowWhatStationsHave) {
    const auto now = off_elsewhere(oblique(), StationCorners::level),
               before = off_elsewhere(oblique(), StationCorners::kinked);
    EXPECT_LT(now[0], 1e-4);
    EXPECT_LT(now[1], 5e-4);
    EXPECT_LT(now[2], 2e-3);
    EXPECT_GT(before[0], 10 * now[0]);
    EXPECT_GT(before[1], 2 * now[1]);
    EXPECT_GT(before[2], 5 * now[2]);
    const WingBody along = bodies()[2];  // stations between rows that follow the sections
    EXPECT_EQ(off_elsewhere(along, StationCorners::level), off_elsewhere(along, StationCorners::kinked));
}

/// The line along which planes lie ended wherever a step along it did, and some went around the edge of the tip.
TEST(PlanformPanels, SectionsOfAWingletAreThoseOfItsTip) {
    const auto off = [](WingRules rules) {
        std::array<double, 2> worst{};  // of its distance from the tip, over the semispan; of its plane, degrees
        for (int i = 1; i < 4; ++i) {
            WingBody body = bent_up();
            body.mesh.vertices.col(0) += 0.1 * i * body.mesh.vertices.col(2);
            body.declared.rules = rules;
            const Wing wing(body.mesh, body.declared);
            const Vector3d end = wing.station(body.mesh, 1).trailing_edge, up = wing.up_at(0, wing.place(0, 1));
            const double from_tip =
                (body.mesh.vertices.bottomRows(120).rowwise() - end.transpose()).rowwise().norm().minCoeff();
            worst[0] = std::max(worst[0], std::abs(from_tip / 3 - 0.002));
            worst[1] = std::max(worst[1], std::abs(std::atan2(-up[1], up[2]) / degree - 80));
        }
        return worst;
    };
    const auto now = off(WingRules::latest), before = off(WingRules::earlier);
    EXPECT_LT(now[0], 3e-4);
    EXPECT_LT(now[1], 0.5);
    EXPECT_GT(before[1], 3);
}

/// What the sections of a wing with winglet show that should have stayed, largest under any change at its limits:
/// panels in degrees, chords in shares; and how far the span is from what was asked for, in shares.
std::array<double, 3> off_beside_winglet(WingRules rules) {
    WingBody body = bent_up();
    body.declared.rules = rules;
    body.declared.stations = {0, 0.38, 0.7, 1};
    const auto wing = std::make_shared<const Wing>(body.mesh, body.declared);
    std::vector<PlanformRange> ranges = by_panel(8 * degree, 5 * degree);
    ranges.push_back({.change = PlanformChange::span, .lower = -0.1, .upper = 0.1});
    for (const auto& [change, range] : {std::pair{PlanformChange::chord, 0.1},
                                        {PlanformChange::twist, 5 * degree},
                                        {PlanformChange::thickness, 0.15},
                                        {PlanformChange::camber, 0.01}})
        ranges.push_back({.change = change, .by_station = true, .lower = -range, .upper = range});
    const PlanformMotion motion(body.mesh, {wing}, ranges);
    std::array<double, 3> off{};
    for (int j = 0; j < motion.size(); ++j)
        for (const double sign : {-1.0, 1.0}) {
            const auto& v = motion.variables()[static_cast<std::size_t>(j)];
            const double value = sign * v.upper;
            const TriMesh now = moved(body, motion, value * VectorXd::Unit(motion.size(), j));
            for (const double from : {0.0, 0.38, 0.7}) {
                const PanelFacts a = wing->panel(body.mesh, from), b = wing->panel(now, from);
                const auto asked = [&](PlanformChange change) {
                    return v.change == change && v.station == from ? value : 0;
                };
                off[0] = std::max(
                    {off[0], std::abs(b.sweep.value - a.sweep.value - asked(PlanformChange::sweep)) / degree,
                     std::abs(b.dihedral.value - a.dihedral.value - asked(PlanformChange::dihedral)) / degree});
            }
            for (const double at : wing->stations())
                if (v.change != PlanformChange::chord)
                    off[1] = std::max(
                        off[1],
                        std::abs(wing->station(now, at).chord.value / wing->station(body.mesh, at).chord.value - 1));
            if (v.change == PlanformChange::span)
                off[2] = std::max(
                    off[2], std::abs(wing->facts(now).span.value / wing->facts(body.mesh).span.value - 1 - value));
        }
    return off;
}

/// Planes at fractions of an extent that the change itself moves (that of a winglet along its normal, or where its
/// thickness is outermost) show other sections than before.
TEST(PlanformPanels, SectionsOfAWingletGoWithIt) {
    const auto now = off_beside_winglet(WingRules::latest), before = off_beside_winglet(WingRules::sliding);
    EXPECT_LT(now[0], 0.05);
    EXPECT_LT(now[1], 5e-4);
    EXPECT_LT(now[2], 1e-6);
    EXPECT_GT(before[0], 0.1) << now[0];
    EXPECT_GT(before[1], 2 * now[1]);
    EXPECT_GT(before[2], 1e-4);
}

TEST(PlanformPanels, DihedralTakesAWingletAlong) {
    const WingBody body = bent_up();
    PlanformRange dihedral = by_panel()[1];
    dihedral.only = {0};
    const Wing wing(body.mesh, body.declared);
    const double before = wing.panel(body.mesh, 0).dihedral.value, width = wing.panel(body.mesh, 0).width.value;
    const Points u = motion_of(body, {dihedral}).displacement(VectorXd::Constant(1, 6 * degree));
    const double rise = width * (std::tan(before + 6 * degree) - std::tan(before));
    // What lies outboard moves as one, but for what triangles cut of the corner at the station.
    EXPECT_LT((u.col(2).bottomRows(u.rows() - 120 * 11).array() - rise).abs().maxCoeff(), 2e-4 * rise);
    EXPECT_EQ(u.leftCols(2).cwiseAbs().maxCoeff(), 0);
}

/// The quarter chord by the rows of vertices themselves: nothing of what moves or measures wings.
TEST(PlanformPanels, RowsOfVerticesShowThem) {
    WingBody body = bodies()[4];  // kinked; rows at k / 25 of the semispan, their first vertex behind
    body.declared.stations = {0, 0.4, 0.8, 1};
    const PlanformMotion motion = motion_of(body, by_panel());
    const auto quarter = [](const TriMesh& mesh, int row) -> Vector3d {
        return 0.25 * mesh.vertices.row(120 * row) + 0.75 * mesh.vertices.row(120 * row + 60);
    };
    const auto slope = [&](const TriMesh& mesh, int from, int to, int c) {
        const Vector3d way = quarter(mesh, to) - quarter(mesh, from);
        return std::atan(way[c] / way[1]);
    };
    ASSERT_EQ(motion.variables()[1].name, "wing.delta_sweep@0.4");
    ASSERT_EQ(motion.variables()[4].name, "wing.delta_dihedral@0.4");
    VectorXd z = VectorXd::Zero(6);
    z[1] = -7 * degree;
    z[4] = 5 * degree;
    const TriMesh now = moved(body, motion, z);
    EXPECT_NEAR(slope(now, 10, 20, 0) - slope(body.mesh, 10, 20, 0), z[1], 0.01 * degree);
    EXPECT_NEAR(slope(now, 10, 20, 2) - slope(body.mesh, 10, 20, 2), z[4], 0.01 * degree);
    const Points u = now.vertices - body.mesh.vertices;
    EXPECT_LT(u.topRows(120 * 10).cwiseAbs().maxCoeff(), 1e-4) << "what lies inboard stays";
    const Points beyond = u.bottomRows(u.rows() - 120 * 21);
    EXPECT_LT((beyond.rowwise() - beyond.row(0)).cwiseAbs().maxCoeff(), 1e-4) << "what lies outboard moves as one";
    EXPECT_LT(beyond(0, 0), -0.1);
    EXPECT_GT(beyond(0, 2), 0.1);
    EXPECT_EQ(u.col(1).cwiseAbs().maxCoeff(), 0);
}

TEST(PlanformPanels, DerivativesAreExactBesideOtherChanges) {
    for (const WingBody& body : bodies()) {
        SCOPED_TRACE(body.name);
        const PlanformMotion motion = motion_of(body, beside_others(body.is_joined));
        const Points w = random_points(body.mesh.num_vertices(), 7), more = random_points(body.mesh.num_vertices(), 8);
        VectorXd at = random_vector(motion.size(), 3);
        for (int j = 0; j < motion.size(); ++j) at[j] *= 0.4 * motion.variables()[static_cast<std::size_t>(j)].upper;
        const auto J = [&](const VectorXd& z) {
            const Points u = motion.displacement(z);
            return u.cwiseProduct(w).sum() + u.array().square().cwiseProduct(more.array()).sum();
        };
        const Points slope = w + 2 * motion.displacement(at).cwiseProduct(more);
        const VectorXd g = motion.gradient(at, slope);
        for (int j = 0; j < motion.size(); ++j) {
            const PlanformMotion::Variable& v = motion.variables()[static_cast<std::size_t>(j)];
            EXPECT_NEAR(motion.derivative(at, j).cwiseProduct(slope).sum(), g[j], 1e-10 * g.norm());
            const VectorXd p = v.upper * VectorXd::Unit(motion.size(), j);
            EXPECT_NEAR(taylor_order(J, at, g, p, 0.2), 2, 0.15) << v.name;
            EXPECT_NEAR(taylor_order(J, at, 1.1 * g, p, 1e-3), 1, 0.1) << "the control must fail";
        }
    }
}

/// All at once: panels keep what they are asked for while span, chord and twist change.
TEST(PlanformPanels, OtherChangesLeaveThemAlone) {
    for (const WingBody& body : bodies()) {
        if (body.name == "three elements" || body.name == "winglet") continue;  // the span turns what stands upright
        SCOPED_TRACE(body.name);
        const auto wing = std::make_shared<const Wing>(body.mesh, body.declared);
        const PlanformMotion motion(body.mesh, {wing}, beside_others(body.is_joined));
        VectorXd z(motion.size());
        for (int j = 0; j < z.size(); ++j)
            z[j] = (j % 2 ? -1 : 1) * motion.variables()[static_cast<std::size_t>(j)].upper;
        const TriMesh now = moved(body, motion, z);
        for (int j = 0; j < z.size(); ++j) {
            const PlanformMotion::Variable& v = motion.variables()[static_cast<std::size_t>(j)];
            if (!has_panels(v.change)) continue;
            const PanelFacts before = wing->panel(body.mesh, v.station), after = wing->panel(now, v.station);
            const double change = v.change == PlanformChange::sweep ? after.sweep.value - before.sweep.value
                                                                    : after.dihedral.value - before.dihedral.value;
            EXPECT_NEAR(change, z[j], 0.05 * degree) << v.name;
        }
    }
}

TEST(PlanformPanels, HalfIsWholeAndPairsStaySymmetric) {
    const std::vector<WingBody> all = bodies();
    const PlanformMotion half = motion_of(all[0], by_panel()), whole = motion_of(all[1], by_panel());
    ASSERT_EQ(half.size(), whole.size());
    const VectorXd z = 0.1 * random_vector(half.size(), 5);
    const Points a = half.displacement(z), b = whole.displacement(z);
    EXPECT_LT((b.bottomRows(a.rows()) - a).cwiseAbs().maxCoeff(), 1e-10);
    const Eigen::Index around = 120, right = b.rows() - a.rows();
    for (Eigen::Index row = 1; row * around <= right; ++row) {
        const Points pair = b.middleRows(right + row * around, around) - b.middleRows(right - row * around, around);
        EXPECT_LT(pair.cwiseAbs().maxCoeff(), 1e-13) << row;
    }
}

TEST(PlanformPanels, TheRootIsHeldWhereAsked) {
    const WingBody body = bodies()[4];
    PlanformRange sweep = by_panel()[0];
    sweep.root_held = true;
    const PlanformMotion held = motion_of(body, {sweep});
    ASSERT_EQ(held.size(), 1);
    EXPECT_EQ(held.variables()[0].name, "wing.delta_sweep@0.4");
    const Points u = held.displacement(VectorXd::Constant(1, 0.1));
    EXPECT_EQ(u.topRows(120 * 10).cwiseAbs().maxCoeff(), 0) << "to the last bit";
    sweep.root_held = false;
    sweep.only = {0.4};
    EXPECT_EQ(motion_of(body, {sweep}).displacement(VectorXd::Constant(1, 0.1)), u);
}

TEST(PlanformPanels, BodiesStayToTheLastBit) {
    for (const WingBody& body : bodies()) {
        if (body.name != "body" && !body.is_joined) continue;
        SCOPED_TRACE(body.name);
        const PlanformMotion motion = motion_of(body, by_panel());
        const Points u = motion.displacement(VectorXd::Constant(motion.size(), 0.1));
        std::vector<char> of_wing(static_cast<std::size_t>(body.mesh.num_vertices()), 0);
        for (const int t : body.declared.triangles)
            for (const int v : body.mesh.triangles.row(t)) of_wing[static_cast<std::size_t>(v)] = 1;
        for (int v = 0; v < u.rows(); ++v)
            if (!of_wing[static_cast<std::size_t>(v)] || (body.is_joined && body.mesh.vertices(v, 1) <= 0.36)) {
                EXPECT_EQ(u.row(v).cwiseAbs().maxCoeff(), 0) << v;
            }
        EXPECT_GT(u.cwiseAbs().maxCoeff(), 0.1);
    }
}

std::string refused(const WingBody& body, const std::vector<PlanformRange>& ranges) {
    try {
        motion_of(body, ranges);
    } catch (const InvalidInput& error) {
        return error.what();
    }
    return "";
}

bool contains(const std::string& all, const std::string& part) { return all.find(part) != all.npos; }

/// The station 1 of a rounded tip lies inboard of stations on it.
TEST(PlanformPanels, EndBeforeARoundedTip) {
    Loft loft;
    loft.panels = 60;
    loft.cells = 100;
    loft.chord = [](double s) {
        return (1 - 0.5 * s) * (s < 0.9 ? 1 : std::sqrt(std::max(0.01, 1 - std::pow((s - 0.9) / 0.1, 2))));
    };
    WingBody body{"rounded", lofted(loft), wing_bodies()[0].declared};
    body.declared.stations = {0, 0.5, 0.97, 1};
    const Wing wing(body.mesh, body.declared);
    ASSERT_LT(wing.place(0, 1), 0.96) << "the chord falls";
    EXPECT_EQ(wing.panel_ends(), (std::vector<double>{0, 0.5, 1}));
    const PanelFacts last = wing.panel(body.mesh, 0.97);
    EXPECT_EQ(last.from, 0.5);
    EXPECT_NEAR(last.sweep.value, std::atan(0.4), 1e-3);
    const PlanformMotion motion = motion_of(body, by_panel());
    ASSERT_EQ(motion.size(), 4);
    const TriMesh now = moved(body, motion, 0.1 * VectorXd::Unit(4, 1));
    EXPECT_NEAR(wing.panel(now, 0.5).sweep.value - last.sweep.value, 0.1, 1e-3);
    // Changes of sections vary between stations one after the other.
    const PlanformRange twist{.change = PlanformChange::twist, .by_station = true, .lower = -0.1, .upper = 0.1};
    EXPECT_TRUE(contains(refused(body, {twist}), "wing.twist: the station 0.97 lies on the rounded tip, beyond 0.9"))
        << refused(body, {twist});
    body.declared.stations = {0, 0.5, 0.97};
    EXPECT_EQ(refused(body, {twist}), "");
    EXPECT_EQ(Wing(body.mesh, body.declared).panel_ends(), (std::vector<double>{0, 0.5, 1}));
}

TEST(PlanformPanels, WhatCannotBeIsRefused) {
    const std::vector<WingBody> all = bodies();
    PlanformRange sweep = by_panel()[0], dihedral = by_panel()[1];
    sweep.only = {1};
    EXPECT_TRUE(contains(refused(all[0], {sweep}), "wing.sweep@1: there is no panel that begins there; panels: 0, 0.4"))
        << refused(all[0], {sweep});
    dihedral.only = {0.92};
    EXPECT_TRUE(contains(refused(all[5], {dihedral}), "wing.dihedral@0.92: the panel is upright"))
        << refused(all[5], {dihedral});
    sweep.only = {0.4}, sweep.upper = 1.2;
    EXPECT_TRUE(contains(refused(all[0], {sweep}), "wing.sweep@0.4 would reach 9"));
    sweep = by_panel()[0];
    PlanformRange whole{.change = PlanformChange::sweep, .lower = -0.1, .upper = 0.1};
    EXPECT_TRUE(contains(refused(all[0], {sweep, whole}), "has a range already"));
    EXPECT_TRUE(contains(refused(all[0], {whole, sweep}), "has a range already"));
    whole.root_held = true;
    EXPECT_TRUE(contains(refused(all[0], {whole}), "root: held belongs to by: station"));
    WingBody one = all[0];
    one.declared.stations = {0, 1};
    sweep.root_held = true;
    EXPECT_TRUE(contains(refused(one, {sweep}), "no panel is left"));
    for (const PlanformChange change : {PlanformChange::sweep, PlanformChange::twist}) {
        sweep.change = change, sweep.only = {0};
        EXPECT_TRUE(contains(refused(all[0], {sweep}), "@0: root: held leaves the root no variable"));
    }
}

}  // namespace
}  // namespace strake
