#include "core/planform/section_motion.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "core/mesh/surface_map.hpp"
#include "core/planform/planform_motion.hpp"
#include "wing_bodies.hpp"

#include <gtest/gtest.h>
#include <random>

/// The motion of a wing's sections in the space around it.
namespace strake {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double degree = std::numbers::pi / 180;

WingBody body_named(const std::string& name) {
    for (WingBody& body : wing_bodies())
        if (body.name == name) return body;
    throw std::logic_error(name);
}

/// A wing that its sections move: what a mesh has to follow.
struct Moved {
    TriMesh start;
    std::optional<SymmetryPlane> symmetry;
    Points u;
    double reach;  ///< length
    std::shared_ptr<const SectionMotion> space;

    /// @param share of span by 10 %, sweep, dihedral and twist of all stations by 5 degrees, chord by 10 %
    Moved(const WingBody& body, double share, double diagonals = 1)
        : start(body.mesh), symmetry(body.declared.symmetry), reach(diagonals * box_diagonal(body.mesh)) {
        const auto wing = std::make_shared<const Wing>(start, body.declared);
        const auto by = [&](PlanformChange change, double limit) {
            const bool has_stations = change >= PlanformChange::chord;
            return PlanformRange{.change = change,
                                 .by_station = has_stations,
                                 .root_held = has_stations && body.is_joined,
                                 .lower = -limit,
                                 .upper = limit};
        };
        const PlanformMotion motion(start, {wing},
                                    {by(PlanformChange::span, 0.1), by(PlanformChange::sweep, 5 * degree),
                                     by(PlanformChange::dihedral, 5 * degree), by(PlanformChange::twist, 5 * degree),
                                     by(PlanformChange::chord, 0.1)});
        VectorXd z(motion.size());
        for (int j = 0; j < motion.size(); ++j) z[j] = share * motion.variables()[static_cast<std::size_t>(j)].upper;
        u = motion.displacement(z);
        space = std::make_shared<const SectionMotion>(start, std::vector<std::shared_ptr<const Wing>>{wing}, reach,
                                                      symmetry);
    }
    SurfaceMap map(const Points& points) const {
        return {start, points, {reach / box_diagonal(start), symmetry, space}};
    }
    double largest() const { return u.rowwise().norm().maxCoeff(); }
};

Points random_points(int count, unsigned seed, const Vector3d& low, const Vector3d& high) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> number(0, 1);
    Points points(count, 3);
    for (int i = 0; i < count; ++i)
        for (int c = 0; c < 3; ++c) points(i, c) = low[c] + number(random) * (high[c] - low[c]);
    return points;
}

double inner(const Points& a, const Points& b) { return a.cwiseProduct(b).sum(); }

TEST(SectionMotion, HoldsWhatThePlanformDoes) {
    for (const WingBody& body : wing_bodies()) {
        SCOPED_TRACE(body.name);
        const Moved wing(body, 1);
        if (body.name == "winglet") {
            EXPECT_EQ(wing.space->fitted(wing.u).size(), 0);
            continue;
        }
        const Points left = wing.u - wing.space->at(wing.start.vertices)->displacement(wing.space->fitted(wing.u));
        const double least = body.name == "whole" ? 0.02 : 2e-3;  // of the former, near the plane between its sides
        EXPECT_LT(left.rowwise().norm().maxCoeff(), least * wing.largest());
        EXPECT_GT(wing.largest(), 0.2);
    }
}

TEST(SectionMotion, MovesNeitherWhatIsFarNorBodies) {
    const Moved wing(body_named("body"), 1, 0.7);
    const Points far = random_points(200, 1, {-20, 0, -20}, {20, 20, 20});
    const SurfaceMap map = wing.map(far);
    const Points moved = map.moved(wing.start.vertices + wing.u);
    int beyond = 0;
    for (int p = 0; p < far.rows(); ++p)
        if (map.distances()[p] >= wing.reach) {
            ++beyond;
            EXPECT_EQ(moved.row(p), far.row(p)) << far.row(p);
        }
    EXPECT_GT(beyond, 150);
    Points box(40, 3);  // on the sides of the body
    for (int i = 0; i < 40; ++i) box.row(i) << -1 + 3.5 * i / 39, 0.4 * (i % 5) / 4, (i % 2 ? 0.5 : -0.5);
    EXPECT_EQ(wing.space->at(box)->displacement(wing.space->fitted(wing.u)).cwiseAbs().maxCoeff(), 0);
    EXPECT_LT((wing.map(box).moved(wing.start.vertices + wing.u) - box).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(SectionMotion, LeavesThePlaneOfSymmetryAPlane) {
    const Moved wing(body_named("half"), 1);
    Points points = random_points(400, 2, {-2, 0, -2}, {3, 0, 2});
    const Points u = wing.space->at(points)->displacement(wing.space->fitted(wing.u));
    EXPECT_LT(u.col(1).cwiseAbs().maxCoeff(), 1e-9 * wing.largest());
    EXPECT_GT(u.cwiseAbs().maxCoeff(), 0.01) << "sections turn at the root, too";
    points = random_points(100, 3, {-2, 0.1, -2}, {3, 4, 2});
    Points image = points;
    image.col(1) *= -1;
    Points mirrored = wing.map(image).apply(wing.u);
    mirrored.col(1) *= -1;
    EXPECT_LT((mirrored - wing.map(points).apply(wing.u)).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(SectionMotion, VerticesGetTheirBits) {
    for (const char* name : {"half", "whole", "body", "winglet"}) {
        const Moved wing(body_named(name), 1);
        EXPECT_EQ(wing.map(wing.start.vertices).moved(wing.start.vertices + wing.u), wing.start.vertices + wing.u);
    }
}

/// Largest |u(a) - u(b)| / |a - b| over neighbours on a line of `count` points.
double steepest(const Moved& wing, const Vector3d& from, const Vector3d& to, int count) {
    Points line(count, 3);
    for (int i = 0; i < count; ++i) line.row(i) = from + (to - from) * i / (count - 1.0);
    const Points u = wing.map(line).apply(wing.u);
    return (u.bottomRows(count - 1) - u.topRows(count - 1)).rowwise().norm().maxCoeff() /
           ((to - from).norm() / (count - 1));
}

TEST(SectionMotion, HasNoJumps) {
    for (const char* name : {"half", "whole", "kinked", "joined"}) {
        SCOPED_TRACE(name);
        const Moved wing(body_named(name), 1);
        for (const auto& [from, to] : {std::pair{Vector3d(-1, 0.01, 0.3), Vector3d(3, 5, 0.9)},
                                       {Vector3d(1.5, -2, 1), Vector3d(1, 2.9, 1.2)},
                                       {Vector3d(1.3, 1.5, 0.7), Vector3d(1.8, 3.4, 0.6)}}) {
            const double coarse = steepest(wing, from, to, 201), fine = steepest(wing, from, to, 5001);
            EXPECT_LT(coarse, 1);
            EXPECT_LT(fine, 1.1 * coarse + 0.05) << "a jump would be thirty times steeper";
        }
    }
}

TEST(SectionMotion, TurnsNoCellInsideOut) {
    for (const char* name : {"half", "whole", "three elements", "joined"})
        for (const double share : {-1.0, 1.0}) {
            SCOPED_TRACE(name);
            const Moved wing(body_named(name), share, 2);
            const Points at = random_points(200, 4, {-2, 0, -2}, {4, 5, 2.5});
            constexpr double h = 1e-3;
            std::array<Points, 6> u;
            for (int k = 0; k < 6; ++k)
                u[static_cast<std::size_t>(k)] =
                    wing.map(at.rowwise() + (k % 2 ? h : -h) * Eigen::RowVector3d::Unit(k / 2)).apply(wing.u);
            double least = 1;
            const Eigen::VectorXd distance = wing.map(at).distances();
            for (int p = 0; p < at.rows(); ++p) {
                if (distance[p] < 0.1) continue;  // inside, or so near that the surface's own map rules
                Eigen::Matrix3d slope = Eigen::Matrix3d::Identity();
                for (int c = 0; c < 3; ++c)
                    slope.col(c) +=
                        (u[static_cast<std::size_t>(2 * c + 1)].row(p) - u[static_cast<std::size_t>(2 * c)].row(p))
                            .transpose() /
                        (2 * h);
                least = std::min(least, slope.determinant());
            }
            EXPECT_GT(least, 0.3);
        }
}

TEST(SectionMotion, TransposeIsExact) {
    for (const char* name : {"half", "whole", "body"}) {
        SCOPED_TRACE(name);
        const Moved wing(body_named(name), 1);
        const Points points = random_points(300, 5, {-2, -1, -2}, {4, 5, 2.5});
        const Points g = random_points(300, 6, {-1, -1, -1}, {1, 1, 1});
        const Points u = random_points(wing.start.num_vertices(), 7, {-1, -1, -1}, {1, 1, 1});
        const SurfaceMap map = wing.map(points);
        const Points moved = map.apply(u);
        EXPECT_NEAR(inner(g, moved), inner(map.transpose(g), u), 1e-11 * g.norm() * moved.norm());
        // Without the motion of space it is another map.
        const SurfaceMap plain(wing.start, points, {wing.reach / box_diagonal(wing.start), wing.symmetry, nullptr});
        EXPECT_GT(std::abs(inner(g, moved) - inner(plain.transpose(g), u)), 1e-6 * g.norm() * moved.norm());
    }
}

TEST(SectionMotion, WhatCannotBeIsRefused) {
    const WingBody body = body_named("half");
    const auto wing = std::make_shared<const Wing>(body.mesh, body.declared);
    EXPECT_THROW(SectionMotion(body.mesh, {wing}, 0), InvalidInput);
    const auto space = std::make_shared<const SectionMotion>(body.mesh, std::vector{wing}, 1.0);
    const WingBody other = body_named("blunt");
    EXPECT_THROW(SurfaceMap(other.mesh, other.mesh.vertices, {1, {}, space}), InvalidInput);
}

}  // namespace
}  // namespace strake
