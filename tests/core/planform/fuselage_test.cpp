#include "core/planform/fuselage.hpp"

#include "core/error.hpp"
#include "core/planform/planform_motion.hpp"
#include "core/wrap/halves.hpp"
#include "derivatives.hpp"
#include "surfaces.hpp"
#include "wing_bodies.hpp"

#include <gtest/gtest.h>

namespace strake {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;
using enum PlanformChange;

/// A drooped ellipsoid: length 4, width 1, height 0.8; its middle rises by 0.3 x (1 - x / 4).
TriMesh drooped() {
    TriMesh mesh = ellipsoid({2, 0.5, 0.4}, 4);
    mesh.vertices.col(0).array() -= mesh.vertices.col(0).minCoeff();
    const Eigen::VectorXd x = mesh.vertices.col(0);
    mesh.vertices.col(2).array() += 0.3 * x.array() * (1 - x.array() / 4);
    return mesh;
}

double extent(const TriMesh& mesh, int c) { return mesh.vertices.col(c).maxCoeff() - mesh.vertices.col(c).minCoeff(); }

TEST(Fuselage, IsMeasuredAsItWasMade) {
    const TriMesh mesh = drooped();
    const Fuselage body(mesh, {});
    EXPECT_NEAR(body.length(mesh).value, extent(mesh, 0), 1e-12);
    for (const double s : {0.2, 0.5, 0.8}) {
        const FuselageStation at = body.station(mesh, s);
        const double share = std::sqrt(1 - (2 * s - 1) * (2 * s - 1));  // of an ellipsoid
        EXPECT_NEAR(at.width.value, share * extent(mesh, 1), 0.01);
        EXPECT_NEAR(at.height.value, share * extent(mesh, 1) * 0.8, 0.02);
        EXPECT_NEAR(at.camber.value, 0.3 * s * (1 - s), 0.003);
    }
}

/// A nacelle beside the plane of symmetry of a half model.
TEST(Fuselage, WhatEndsBesideThePlaneOfSymmetryIsWhole) {
    TriMesh mesh = drooped();
    const FuselageStation before = Fuselage(mesh, {}).station(mesh, 0.5);
    FuselageDeclaration declared;
    declared.symmetry = SymmetryPlane{Vector3d::UnitY(), 0};
    for (const double shift : {0.7, -0.7}) {
        mesh.vertices.col(1).array() += shift;
        const FuselageStation at = Fuselage(mesh, declared).station(mesh, 0.5);
        EXPECT_NEAR(at.width.value, before.width.value, 1e-10);
        EXPECT_NEAR(at.across.value, before.across.value + shift, 1e-10);
        mesh.vertices.col(1).array() -= shift;
    }
}

TEST(Fuselage, HalfIsWhole) {
    const TriMesh mesh = drooped(), half = clipped(mesh, {Vector3d::UnitY(), 0}, 1e-9);
    FuselageDeclaration declared;
    declared.symmetry = SymmetryPlane{Vector3d::UnitY(), 0};
    const Fuselage whole(mesh, {}), one(half, declared);
    for (const double s : {0.1, 0.37, 0.5, 0.9}) {
        const FuselageStation a = whole.station(mesh, s), b = one.station(half, s);
        EXPECT_NEAR(a.width.value, b.width.value, 1e-10);
        EXPECT_NEAR(a.height.value, b.height.value, 1e-10);
        EXPECT_NEAR(a.camber.value, b.camber.value, 1e-10);
    }
    const auto motion = [](const TriMesh& surface, const FuselageDeclaration& by) {
        const auto body = std::make_shared<const Fuselage>(surface, by);
        PlanformMotion all(surface, {}, {}, {body});
        for (const PlanformChange change : {length, width, height, camber})
            all.add(surface, {.change = change, .by_station = change != length, .lower = -0.1, .upper = 0.1});
        return Points(surface.vertices + all.displacement(0.05 * VectorXd::Ones(all.size())));
    };
    const Points a = motion(mesh, {}), b = motion(half, declared);
    for (int v = 0; v < half.num_vertices(); ++v) {
        Eigen::Index same = 0;
        const double off = (mesh.vertices.rowwise() - half.vertices.row(v)).rowwise().norm().minCoeff(&same);
        if (off < 1e-12) {
            EXPECT_LT((a.row(same) - b.row(v)).norm(), 1e-10);
        }
    }
}

TEST(Fuselage, DerivativesAreExact) {
    const TriMesh mesh = drooped();
    const Fuselage body(mesh, {});
    const auto values = [&](const VectorXd& x, bool wants) {
        TriMesh now = mesh;
        now.vertices = Eigen::Map<const Points>(x.data(), mesh.num_vertices(), 3);
        const FuselageStation at = body.station(now, 0.37, wants);
        return std::vector<Varying>{body.length(now, wants), at.width, at.height, at.camber};
    };
    const VectorXd x = Eigen::Map<const VectorXd>(mesh.vertices.data(), mesh.vertices.size());
    Points way(mesh.num_vertices(), 3);  // smooth: extents are those of the same points
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        const Vector3d at = mesh.vertices.row(v);
        way.row(v) << std::sin(at[0] + at[1]), at[1] * std::cos(at[0]) + 0.2 * at[2], std::cos(2 * at[0]) + at[2];
    }
    const VectorXd p = 0.1 * Eigen::Map<const VectorXd>(way.data(), way.size());
    for (std::size_t k = 0; k < 4; ++k) {
        VectorXd g = VectorXd::Zero(x.size());
        const Varying exact = values(x, true)[k];
        for (const auto& [coordinate, slope] : exact.slope) g[coordinate] = slope;
        ASSERT_GT(g.norm(), 0);
        const auto J = [&](const VectorXd& at) {
            return values(at, false)[k].value + std::pow(values(at, false)[k].value, 2);
        };
        const VectorXd slope = (1 + 2 * values(x, false)[k].value) * g;
        EXPECT_NEAR(taylor_order(J, x, slope, p, 1e-2), 2, 0.2) << k;
        EXPECT_NEAR(taylor_order(J, x, 1.1 * slope, p, 1e-3), 1, 0.2) << k << ": the control must fail";
    }
}

/// Each variable by itself at both ends of its range: what is asked for, and what stays.
TEST(Fuselage, VariablesAreMeasuredBack) {
    const TriMesh mesh = drooped();
    const auto body = std::make_shared<const Fuselage>(mesh, FuselageDeclaration{});
    PlanformMotion motion(mesh, {}, {}, {body});
    motion.add(mesh, {.change = length, .lower = -0.1, .upper = 0.1});
    for (const PlanformChange change : {width, height})
        motion.add(mesh, {.change = change, .by_station = true, .lower = -0.2, .upper = 0.2});
    motion.add(mesh, {.change = camber, .by_station = true, .lower = -0.03, .upper = 0.03});
    ASSERT_EQ(motion.size(), 10) << "the ends are points: three stations of each";
    EXPECT_EQ(motion.variables()[1].name, "body.delta_width@0.25");
    EXPECT_EQ(motion.displacement(VectorXd::Zero(10)).cwiseAbs().maxCoeff(), 0);
    for (int j = 0; j < motion.size(); ++j)
        for (const double sign : {-1.0, 1.0}) {
            const PlanformMotion::Variable& v = motion.variables()[static_cast<std::size_t>(j)];
            SCOPED_TRACE(v.name);
            const TriMesh now =
                with_vertices(mesh, mesh.vertices + motion.displacement(sign * v.upper * VectorXd::Unit(10, j)));
            const Fuselage after(now, {});
            const double asked = sign * v.upper;
            EXPECT_NEAR(after.length(now).value / body->length(mesh).value, v.change == length ? 1 + asked : 1, 1e-9);
            for (const double s : {0.25, 0.5, 0.75}) {
                const FuselageStation a = body->station(mesh, s), b = after.station(now, s);
                const auto wanted = [&](PlanformChange change) {
                    return v.change == change && v.station == s ? asked : 0.0;
                };
                EXPECT_NEAR(b.width.value / a.width.value, 1 + wanted(width), 2e-3);
                EXPECT_NEAR(b.height.value / a.height.value, 1 + wanted(height), 2e-3);
                const double shorter = v.change == length ? 1 + asked : 1;
                EXPECT_NEAR(b.camber.value * shorter, a.camber.value + wanted(camber), 3e-4);
            }
        }
}

TEST(Fuselage, GradientsOfTheMotionAreExact) {
    const TriMesh mesh = drooped();
    const auto body = std::make_shared<const Fuselage>(mesh, FuselageDeclaration{});
    PlanformMotion motion(mesh, {}, {}, {body});
    for (const PlanformChange change : {length, width, height, camber})
        motion.add(mesh, {.change = change, .by_station = change == width, .lower = -0.2, .upper = 0.2});
    const Points w =
        Eigen::Map<const Points>(random_vector(mesh.vertices.size(), 7).eval().data(), mesh.num_vertices(), 3);
    const VectorXd z = 0.1 * random_vector(motion.size(), 5), p = random_vector(motion.size(), 6);
    const auto J = [&](const VectorXd& at) {
        const Points u = mesh.vertices + motion.displacement(at);
        return (u.array().cube() * w.array()).sum();
    };
    const Points u = mesh.vertices + motion.displacement(z), slope = 3 * u.array().square() * w.array();
    const VectorXd g = motion.gradient(z, slope);
    EXPECT_NEAR(taylor_order(J, z, g, p, 0.1), 2, 0.2);
    EXPECT_NEAR(taylor_order(J, z, 1.1 * g, p, 1e-3), 1, 0.2) << "the control must fail";
    for (int j = 0; j < motion.size(); ++j)
        EXPECT_NEAR(motion.derivative(z, j).cwiseProduct(slope).sum(), g[j], 1e-9 * (1 + std::abs(g[j])));
    const std::vector<Eigen::Matrix3d> maps = motion.local_maps(z);
    for (const int t : {10, 500, 1200}) {
        const int a = mesh.triangles(t, 0), b = mesh.triangles(t, 1);
        const Vector3d edge = mesh.vertices.row(b) - mesh.vertices.row(a), now = u.row(b) - u.row(a);
        EXPECT_LT((maps[static_cast<std::size_t>(t)] * edge - now).norm(), 0.05 * edge.norm());
        EXPECT_GT((edge - now).norm(), 0.01 * edge.norm()) << "the test can fail";
    }
}

std::string refusal(const auto& work) {
    try {
        work();
    } catch (const InvalidInput& error) {
        return error.what();
    }
    return "";
}

TEST(Fuselage, WhatCannotChangeIsRefused) {
    const TriMesh mesh = drooped();
    const auto body = std::make_shared<const Fuselage>(mesh, FuselageDeclaration{});
    const auto words = [&](const PlanformRange& range) {
        return refusal([&] { PlanformMotion(mesh, {}, {range}, {body}); });
    };
    EXPECT_NE(words({.change = twist, .lower = -1, .upper = 1}).find("is a change of wings"), std::string::npos);
    EXPECT_NE(words({.change = width, .by_station = true, .only = {0.3}, .lower = -0.1, .upper = 0.1})
                  .find("no such station"),
              std::string::npos);
    EXPECT_NE(
        words({.change = width, .by_station = true, .only = {0}, .lower = -0.1, .upper = 0.1}).find("pointed there"),
        std::string::npos);
    EXPECT_NE(
        words({.change = camber, .by_station = true, .only = {1}, .lower = -0.1, .upper = 0.1}).find("nose and tail"),
        std::string::npos);
    EXPECT_NE(words({.change = width, .lower = -0.95, .upper = 0.1}).find("must not fall below"), std::string::npos);
    EXPECT_NE(words({.change = length, .by_station = true, .lower = -0.1, .upper = 0.1}).find("no stations"),
              std::string::npos);
    FuselageDeclaration part;
    for (int t = 0; t < 200; ++t) part.triangles.push_back(t);
    part.stations = {0.5};
    EXPECT_NE(refusal([&] {
                  PlanformMotion(mesh, {}, {}, {std::make_shared<const Fuselage>(mesh, part)});
              }).find("would be torn"),
              std::string::npos);
    EXPECT_NE(refusal([&] { Fuselage(mesh, {.up = Vector3d::UnitX()}); }).find("perpendicular"), std::string::npos);
    const WingBody winged = wing_bodies()[0];
    const auto wing = std::make_shared<const Wing>(winged.mesh, winged.declared);
    EXPECT_NE(refusal([&] {
                  PlanformMotion(winged.mesh, {wing}, {{.change = width, .lower = -0.1, .upper = 0.1}});
              }).find("is a change of bodies"),
              std::string::npos);
}

/// One behind the other, like a nose cone that has come off: nothing is measured between them.
TEST(Fuselage, TwoPartsWithAGapChangeByStation) {
    TriMesh behind = drooped();
    behind.vertices.col(0).array() += 5;
    const TriMesh mesh = both(drooped(), behind);
    FuselageDeclaration declared;
    declared.stations = {0.2, 0.8};
    const auto body = std::make_shared<const Fuselage>(mesh, declared);
    const PlanformMotion motion(mesh, {}, {{.change = width, .by_station = true, .lower = -0.1, .upper = 0.1}}, {body});
    ASSERT_EQ(motion.size(), 2);
    const TriMesh now = with_vertices(mesh, mesh.vertices + motion.displacement(Eigen::Vector2d(0.1, -0.05)));
    EXPECT_NEAR(body->station(now, 0.2).width.value / body->station(mesh, 0.2).width.value, 1.1, 1e-3);
    EXPECT_NEAR(body->station(now, 0.8).width.value / body->station(mesh, 0.8).width.value, 0.95, 1e-3);
}

/// A wing that pierces a body stays where it is while the body changes, and the other way round.
TEST(Fuselage, PartsOfTheirOwnStay) {
    const WingBody both = wing_bodies()[6];
    FuselageDeclaration declared;
    for (int t = 0; t < 10; ++t) declared.triangles.push_back(t);
    declared.symmetry = both.declared.symmetry;
    declared.stations = {0, 0.5, 1};
    const auto wing = std::make_shared<const Wing>(both.mesh, both.declared);
    const auto body = std::make_shared<const Fuselage>(both.mesh, declared);
    PlanformMotion motion(both.mesh, {wing}, {}, {body});
    motion.add(both.mesh, {.wing = 0, .change = sweep, .lower = -0.1, .upper = 0.1});
    motion.add(both.mesh, {.wing = 1, .change = width, .lower = -0.1, .upper = 0.1});
    const Points by_wing = motion.displacement(Eigen::Vector2d(0.1, 0)),
                 by_body = motion.displacement(Eigen::Vector2d(0, 0.1));
    EXPECT_TRUE(by_wing.topRows(8).isZero(0));
    EXPECT_TRUE(by_body.bottomRows(both.mesh.num_vertices() - 8).isZero(0));
    EXPECT_GT(by_wing.norm(), 0.1);
    EXPECT_NEAR(by_body.cwiseAbs().maxCoeff(), 0.04, 1e-12) << "a tenth of 0.4";
}

}  // namespace
}  // namespace strake
