#include "core/planform/wing.hpp"

#include "core/error.hpp"
#include "core/mesh/adjacency.hpp"
#include "core/mesh/geometry.hpp"
#include "derivatives.hpp"
#include "lofted_wing.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <map>

namespace strake {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double degree = std::numbers::pi / 180;

WingDeclaration half_wing() {
    WingDeclaration declared;
    declared.symmetry = SymmetryPlane{Vector3d::UnitY(), 0};
    return declared;
}

/// What the lofted wing has at a station; the surface is faceted, so that chords of arcs are what is measured.
void expect_station(const Loft& loft, const StationFacts& at, double s, double chord_tolerance = 1e-3) {
    const double c = loft.chord(s);
    EXPECT_NEAR(at.chord.value, c, chord_tolerance * c) << s;
    EXPECT_NEAR(at.twist.value, loft.twist(s), 0.05 * degree) << s;
    EXPECT_NEAR(at.thickness_to_chord.value, loft.thickness(s) + 0.3 * loft.blunt, 0.005 * loft.thickness(s)) << s;
    EXPECT_NEAR(at.camber.value, loft.camber(s), 2e-4) << s;
    EXPECT_NEAR(at.trailing_edge_thickness.value, loft.blunt * c, 1e-6 + 0.01 * loft.blunt * c) << s;
}

TEST(Wing, IsMeasuredAsItWasMade) {
    for (const double blunt : {0.0, 0.004}) {
        Loft loft;
        loft.blunt = blunt;
        const TriMesh mesh = lofted(loft);
        const Wing wing(mesh, half_wing());
        EXPECT_EQ(wing.num_sides(), 1);
        EXPECT_FALSE(wing.has_winglet());
        const WingFacts facts = wing.facts(mesh);
        EXPECT_NEAR(facts.span.value, 6, 0.006) << "the cambered tip leans by its dihedral";
        EXPECT_NEAR(facts.area.value, 2 * 3 * 0.75, 0.005 * 4.5);
        EXPECT_NEAR(facts.aspect_ratio.value, 8, 0.04);
        EXPECT_NEAR(facts.taper.value, 0.5, 0.0025);
        EXPECT_NEAR(facts.sweep.value, std::atan(0.4), 0.05 * degree);
        EXPECT_NEAR(facts.dihedral.value, std::atan(0.1), 0.05 * degree);
        EXPECT_NEAR(facts.mean_chord.value, 7.0 / 9, 0.005);  // 2/3 c (1 + t + t^2) / (1 + t)
        for (const double s : {0.0, 0.13, 0.5, 0.777}) expect_station(loft, wing.station(mesh, s), s);
        expect_station(loft, wing.station(mesh, 1), 0.998);  // where the station 1 lies
        // Radius of the four-digit form, 1.1019 t^2; the angle at the end of a sharp one, by the last 5 %.
        const StationFacts at = wing.station(mesh, 0.5);
        ASSERT_TRUE(at.leading_edge_radius);
        EXPECT_NEAR(at.leading_edge_radius->value, 1.1019 * 0.0144, 0.06 * 1.1019 * 0.0144);
        const double end = 2 * std::atan(example::naca_half_thickness(0.12, 0.95) / 0.05);
        if (blunt == 0) {
            EXPECT_NEAR(at.trailing_edge_angle.value, end, 0.02 * end);
        }
    }
}

TEST(Wing, StationsAreAtKinks) {
    Loft loft;
    loft.cells = 40;
    loft.chord = [](double s) { return s < 0.4 ? 2 - 2 * s : 1.2 - 0.7 * (s - 0.4); };
    loft.quarter = [](double s) { return s < 0.4 ? 0.5 + s : 0.9 + 0.5 * (s - 0.4); };
    const TriMesh mesh = lofted(loft);
    const Wing wing(mesh, half_wing());
    ASSERT_EQ(wing.stations().size(), 3u);
    EXPECT_NEAR(wing.stations()[1], 0.4, 0.013);
    WingDeclaration declared = half_wing();
    declared.stations = {0, 0.37, 1};
    EXPECT_EQ(Wing(mesh, declared).stations(), declared.stations);
}

/// All numbers of a wing by name: in the whole model, of both sides.
std::map<std::string, Varying> all_of(const Wing& wing, const TriMesh& mesh, bool sensitivities) {
    const WingFacts f = wing.facts(mesh, sensitivities);
    std::map<std::string, Varying> all{
        {"span", f.span},   {"area", f.area},         {"aspect ratio", f.aspect_ratio}, {"taper", f.taper},
        {"sweep", f.sweep}, {"dihedral", f.dihedral}, {"mean chord", f.mean_chord}};
    for (const double s : {0.0, 0.43, 1.0}) {
        const StationFacts at = wing.station(mesh, s, sensitivities);
        const std::string end = text("@", s);
        all["chord" + end] = at.chord, all["twist" + end] = at.twist, all["camber" + end] = at.camber;
        all["t/c" + end] = at.thickness_to_chord, all["radius" + end] = at.leading_edge_radius.value();
        all["te angle" + end] = at.trailing_edge_angle, all["te thickness" + end] = at.trailing_edge_thickness;
        Varying thick;
        for (const Airfoil& airfoil : wing.sections(mesh, s, sensitivities)) thick = thick + airfoil.thickness(0.4);
        all["thickness" + end] = thick * (1.0 / wing.num_sides());
    }
    all["volume"] = wing.volume(mesh, {0.15, 0.65}, {0.1, 0.9}, sensitivities);
    return all;
}

Loft blunt_loft() {
    Loft loft;
    loft.blunt = 0.005;
    loft.cells = 10;
    loft.panels = 24;
    return loft;
}

/// @param h steps; larger ones take planes beyond vertices
void expect_exact_derivatives(const TriMesh& mesh, const Wing& wing, double h) {
    // A random smooth motion: points of the outline keep their order and their extremes.
    Points way(mesh.num_vertices(), 3);
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        const Vector3d x = mesh.vertices.row(v);
        way.row(v) << 0.3 * std::sin(1.1 * x[1] + x[0]) + 0.2 * x[2], 0.1 * x[1] * std::cos(0.7 * x[0]),
            0.3 * std::cos(0.9 * x[1]) * (x[0] + 0.5) + 0.8 * x[2];
    }
    const auto at = all_of(wing, mesh, true);
    const auto moved = [&](double h) { return all_of(wing, with_vertices(mesh, mesh.vertices + h * way), false); };
    const auto far = moved(h), near = moved(h / 10);
    for (const auto& [name, value] : at) {
        double slope = 0;
        for (const auto& [coordinate, d] : value.slope) slope += d * way(coordinate / 3, coordinate % 3);
        const auto remainder = [&](const Varying& there, double step, double factor) {
            return std::abs(there.value - value.value - factor * step * slope);
        };
        const auto order = [&](double factor) {
            return std::log10(remainder(far.at(name), h, factor) / remainder(near.at(name), h / 10, factor));
        };
        if (name.starts_with("te thickness") && value.value == 0) continue;  // sharp
        EXPECT_FALSE(value.slope.empty()) << name;
        if (remainder(near.at(name), h / 10, 1) > 1e-12 * std::abs(value.value) + 1e-14) {  // else it is linear
            EXPECT_NEAR(order(1), 2, 0.15) << name;
        }
        EXPECT_NEAR(order(1.2), 1, 0.15) << name << ": the check can fail";
    }
}

TEST(Wing, DerivativesAreExact) {
    const TriMesh mesh = lofted(blunt_loft());
    expect_exact_derivatives(mesh, Wing(mesh, half_wing()), 2e-3);
}

/// Whose planes go where their sections' edges go.
TEST(Wing, DerivativesAreExactWithAWinglet) {
    Loft loft;
    loft.winglet = 0.2;
    loft.height = [](double) { return 0.0; };
    loft.camber = [](double) { return 0.0; };
    loft.cells = 40;
    const TriMesh mesh = lofted(loft);
    const Wing wing(mesh, half_wing());
    ASSERT_TRUE(wing.has_winglet());
    expect_exact_derivatives(mesh, wing, 1e-4);
}

/// A nose of three points that turns by about 100 degrees at its foremost one, by a thickness that passes that.
TEST(Wing, NosesOfPolygonsAreNoCorners) {
    const auto jump = [](WingRules rules) {
        double worst = 0, before = 0;
        for (int i = 0; i <= 20; ++i) {
            Loft loft;
            loft.panels = 12;
            loft.cells = 6;
            loft.thickness = [&](double) { return 0.06 + 0.002 * i; };
            WingDeclaration declared = half_wing();
            declared.rules = rules;
            const TriMesh mesh = lofted(loft);
            const double leading = Wing(mesh, declared).station(mesh, 0.46).leading_x.value;
            if (i > 0) worst = std::max(worst, std::abs(leading - before));
            before = leading;
        }
        return worst;
    };
    EXPECT_LT(jump(WingRules::latest), 1e-4);
    EXPECT_GT(jump(WingRules::earlier), 4e-4);
}

TEST(Wing, HalfIsWhole) {
    const TriMesh half = lofted(blunt_loft()), whole = lofted(blunt_loft(), true);
    const Wing of_half(half, half_wing()), of_whole(whole, {});
    ASSERT_EQ(of_whole.num_sides(), 2);
    const auto a = all_of(of_half, half, false), b = all_of(of_whole, whole, false);
    for (const auto& [name, value] : a)
        EXPECT_NEAR(b.at(name).value, value.value, 1e-10 * (1 + std::abs(value.value))) << name;
    EXPECT_EQ(of_half.stations(), of_whole.stations());
    // Without a word about symmetry: open at the root, it is half a wing all the same.
    const auto c = all_of(Wing(half, {}), half, false);
    for (const auto& [name, value] : a)
        EXPECT_NEAR(c.at(name).value, value.value, 1e-10 * (1 + std::abs(value.value))) << name;
}

TEST(Wing, FollowsRigidMotionAndUnits) {
    const TriMesh mesh = lofted(blunt_loft());
    const auto before = all_of(Wing(mesh, half_wing()), mesh, false);
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.7, Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
    const double unit = 1000;
    TriMesh other = mesh;
    other.vertices = (unit * mesh.vertices * turn.transpose()).rowwise() + Eigen::RowVector3d(40, -7, 12);
    WingDeclaration declared;
    declared.span = turn * Vector3d::UnitY(), declared.downstream = turn * Vector3d::UnitX(),
    declared.up = turn * Vector3d::UnitZ();
    declared.symmetry = SymmetryPlane{declared.span, declared.span.dot(Vector3d(40, -7, 12))};
    const std::map<std::string, int> power{{"span", 1}, {"area", 2}, {"mean chord", 1}, {"volume", 3}};
    for (const auto& [name, value] : all_of(Wing(other, declared), other, false)) {
        const auto known = power.find(name);
        int exponent = known == power.end() ? 0 : known->second;
        if (name.starts_with("chord") || name.starts_with("te thick") || name.starts_with("thickness")) exponent = 1;
        const double scale = std::pow(unit, exponent);
        EXPECT_NEAR(value.value / scale, before.at(name).value, 1e-7 * (1 + std::abs(before.at(name).value))) << name;
    }
}

TEST(Wing, SectionsOfAWingletAreNormalToItsAxis) {
    Loft loft;
    loft.winglet = 0.2;
    loft.height = [](double) { return 0.0; };
    loft.camber = [](double) { return 0.0; };
    loft.twist = [](double s) { return s > 0.8 ? -0.03 : 0.0; };
    loft.cells = 40;
    const TriMesh mesh = lofted(loft);
    const Wing wing(mesh, half_wing());
    ASSERT_TRUE(wing.has_winglet());
    // Fractions of the line seen from the front, which is a little shorter than the semispan: it rounds the corner.
    for (const double s : {0.3, 0.6, 0.9, 0.95}) {
        const StationFacts at = wing.station(mesh, s);
        EXPECT_NEAR(at.chord.value, loft.chord(s), 0.02) << s;
        EXPECT_NEAR(at.twist.value, loft.twist(s), 0.05 * degree) << s;
        EXPECT_NEAR(at.thickness_to_chord.value, loft.thickness(s), 0.01 * loft.thickness(s) + 5e-4) << s;
    }
    EXPECT_NEAR(wing.facts(mesh).area.value, 4.5, 0.05);
    EXPECT_NEAR(wing.facts(mesh).span.value, 4.8, 0.1);
}

TEST(Wing, RegionsByChordAndSpan) {
    const Loft loft;
    const TriMesh mesh = lofted(loft);
    const Wing wing(mesh, half_wing());
    const auto box = wing.region(mesh, {0.15, 0.65}, {0, 0.95}, 1);
    int marked = 0;
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        bool inside = true;
        for (const int v : mesh.triangles.row(t)) {
            const Vector3d x = mesh.vertices.row(v);
            const double s = x[1] / 3, c = loft.chord(s);
            const double fraction = (x[0] - loft.quarter(s)) / c + 0.25;
            // Twist and height change the fraction along the stream by less than 1.5 % of the chord.
            if (box[static_cast<std::size_t>(t)]) {
                EXPECT_GT(fraction, 0.15 - 0.015);
                EXPECT_LT(fraction, 0.65 + 0.015);
                EXPECT_LE(s, 0.95 + 1e-6);
            }
            inside = inside && fraction > 0.165 && fraction < 0.635 && s <= 0.95;
        }
        const Vector3d normal = area_vector(mesh, t);
        const bool is_in = box[static_cast<std::size_t>(t)];
        EXPECT_TRUE(is_in || !(inside && normal[2] > 0)) << t;
        EXPECT_TRUE(normal[2] > 0 || !is_in) << t;
        marked += is_in;
    }
    EXPECT_GT(marked, 100);
    // All of it, both ends of all ranges included.
    const auto all = wing.region(mesh, {0, 1}, {0, 1});
    EXPECT_EQ(std::count(all.begin(), all.end(), 1), mesh.num_triangles());
    // Nothing is in both.
    const auto nose = wing.region(mesh, {0, 0.1}, {0, 1}), tail = wing.region(mesh, {0.9, 1}, {0, 1});
    for (std::size_t t = 0; t < nose.size(); ++t) EXPECT_FALSE(nose[t] && tail[t]);
    EXPECT_GT(std::count(nose.begin(), nose.end(), 1), 0);
}

TEST(Wing, WhatIsNoWingIsRefused) {
    const TriMesh mesh = lofted(Loft{});
    const auto refused = [&](const std::function<void(WingDeclaration&)>& change) -> std::string {
        WingDeclaration declared = half_wing();
        change(declared);
        try {
            Wing wing(mesh, declared);
        } catch (const InvalidInput& error) {
            return error.what();
        }
        return "";
    };
    EXPECT_NE(refused([](auto& d) { d.span = Vector3d(1, 1, 0).normalized(); }).find("perpendicular"),
              std::string::npos);
    EXPECT_NE(refused([](auto& d) {
                  d.stations = {0, 1.5};
              }).find("stations[1] = 1.5 must be in [0, 1]"),
              std::string::npos);
    EXPECT_NE(refused([](auto& d) { d.stations = {0.5, 0.2}; }).find("ascend"), std::string::npos);
    EXPECT_NE(refused([](auto& d) { d.axis = 3; }).find("axis = 3"), std::string::npos);
    EXPECT_NE(refused([](auto& d) { d.triangles = {99999999}; }).find("triangles must be in"), std::string::npos);
    TriMesh flat = mesh;
    flat.vertices.col(1).setZero();
    EXPECT_THROW(Wing(flat, half_wing()), InvalidInput);
    EXPECT_THROW(Wing(mesh, half_wing()).sections(flat, 0.5), InvalidInput);
}

}  // namespace
}  // namespace strake
