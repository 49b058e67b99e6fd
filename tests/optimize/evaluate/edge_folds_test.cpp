#include "optimize/evaluate/edge_folds.hpp"

#include "core/mesh/geometry.hpp"
#include "evaluated.hpp"
#include "problems.hpp"

#include <gtest/gtest.h>

using namespace strake;

namespace {

/// Two triangles about the edge from 0 to 1 (the x axis), whose normals make `degrees`.
TriMesh hinge(double degrees) {
    const double a = degrees * std::numbers::pi / 180;
    TriMesh mesh;
    mesh.vertices.resize(4, 3);
    mesh.vertices << 0, 0, 0, 1, 0.1, 0, 0.4, -0.8, 0, 0.6, 0.7 * std::cos(a), 0.7 * std::sin(a);
    mesh.vertices(1, 1) = 0;
    mesh.triangles.resize(2, 3);
    mesh.triangles << 0, 2, 1, 1, 3, 0;
    return mesh;
}

EdgeFolds of(const TriMesh& rest) { return {std::make_shared<const TriMesh>(rest), adjacency(rest), {}}; }

}  // namespace

TEST(EdgeFolds, AnglesAreThoseOfTheNormals) {
    const EdgeFolds folds = of(hinge(20));
    for (const double degrees : {100.0, 150.0, 168.0, 179.0, -150.0}) {
        const auto rows = folds.rows(hinge(degrees).vertices, 95, 10);
        ASSERT_EQ(rows.size(), 1u) << degrees;
        EXPECT_NEAR(rows[0].angle, std::abs(degrees), 1e-9);
    }
    EXPECT_TRUE(folds.rows(hinge(150).vertices, 151, 10).empty());
    EXPECT_TRUE(folds.any_above(149, hinge(150).vertices));
    EXPECT_FALSE(folds.any_above(151, hinge(150).vertices));
}

/// What is sharper than 120 degrees at rest may be so.
TEST(EdgeFolds, SharpEdgesOfTheStartAreNone) {
    EXPECT_TRUE(of(hinge(121)).is_none());
    EXPECT_FALSE(of(hinge(119)).is_none());
    const TriMesh flat = hinge(0);
    EXPECT_TRUE(EdgeFolds(std::make_shared<const TriMesh>(flat), adjacency(flat), {1, 0}).is_none());
}

/// Central differences of second order: a step half as long leaves a quarter of the error.
TEST(EdgeFolds, GradientsAreThoseOfTheAngles) {
    const TriMesh rest = box_surface({1, 0.7, 0.4}, 3);
    const EdgeFolds folds = of(rest);
    Points v = rest.vertices;
    for (int i = 0; i < v.rows(); ++i) v.row(i) += 0.12 * random_vector(3, 30 + i).transpose();
    const auto rows = folds.rows(v, 60 + 31, 12);
    ASSERT_GE(rows.size(), 4u);
    const auto angle = [&](const Points& at, int edge) {
        TriMesh mesh = rest;
        mesh.vertices = at;
        const Points n = triangle_normals(mesh);
        const auto [a, b] = folds.triangles(edge);
        return dihedral(n.row(a), n.row(b)) * 180 / std::numbers::pi;
    };
    for (const EdgeFolds::Row& row : rows) {
        Points way = Points::Zero(v.rows(), 3);
        double expected = 0;
        for (int k = 0; k < 4; ++k) {
            way.row(row.vertices[k]) = random_vector(3, 90 + k).transpose();
            expected += row.gradient.row(k).dot(way.row(row.vertices[k]));
        }
        std::vector<double> error;
        for (const double h : {1e-3, 5e-4})
            error.push_back(
                std::abs((angle(v + h * way, row.edge) - angle(v - h * way, row.edge)) / (2 * h) - expected));
        EXPECT_LT(error[1], 0.3 * error[0] + 1e-8 * std::abs(expected)) << row.edge;
        EXPECT_LT(error[1], 1e-3 * std::abs(expected) + 1e-6);
        EXPECT_NEAR((row.gradient.colwise().sum()).norm(), 0, 1e-9 * row.gradient.norm())
            << "translations turn nothing";
    }
}

/// The largest first, each at vertices of its own.
TEST(EdgeFolds, RowsAreSpread) {
    const TriMesh rest = box_surface({1, 0.7, 0.4}, 3);
    const EdgeFolds folds = of(rest);
    Points v = rest.vertices;
    for (int i = 0; i < v.rows(); ++i) v.row(i) += 0.15 * random_vector(3, 50 + i).transpose();
    const auto rows = folds.rows(v, 91, 6);
    ASSERT_GE(rows.size(), 3u);
    EXPECT_LE(rows.size(), 6u);
    std::vector<int> seen;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        EXPECT_LE(rows[i].angle, rows[i > 0 ? i - 1 : 0].angle);
        seen.insert(seen.end(), rows[i].vertices.begin(), rows[i].vertices.end());
    }
    std::sort(seen.begin(), seen.end());
    EXPECT_EQ(std::unique(seen.begin(), seen.end()), seen.end());
}

namespace {

Problem loaded_body(bool lets_edges_fold) {
    Problem problem = ellipsoid_problem(2, 3);
    problem.parameters.kinds = {VariableKind::normal_load};
    problem.parameters.lets_edges_fold = lets_edges_fold;
    problem.parameters.variable_scale = 0.05;
    problem.parameters.max_displacement = 0.5;  // not what this is about
    return problem;
}

/// The largest dihedral of the shape of x, degrees; 0: it has none.
double sharpest(Evaluated& e, const Eigen::VectorXd& x) {
    const auto rows = of(e.problem.surface).rows(e.evaluator.equilibrium(x), 1, 1);
    return rows.empty() ? 0 : rows[0].angle;
}

/// A design whose shape has an edge well above those at rest, which are below 25 degrees; zero: none was found.
Eigen::VectorXd bent(Evaluated& e, unsigned seed) {
    Eigen::VectorXd x = random_vector(e.space.size(), seed);
    for (int k = 0; k < 12; ++k, x *= 1.3) {
        const double angle = sharpest(e, x);
        if (angle > 45) return x;
        if (!(angle > 0)) break;
    }
    return Eigen::VectorXd::Zero(x.size());
}

}  // namespace

TEST(EdgeFolds, ConditionsOnDesignsAreThoseOfTheAngles) {
    Evaluated e(loaded_body(false), 2);
    e.evaluator.limit_motion();
    const Eigen::VectorXd x = bent(e, 3), p = random_vector(e.space.size(), 5);
    constexpr double none = 1e9, h = 1e-4;
    constexpr EdgeFolds::Angles angle{22, 60};
    const MotionConditions at = e.evaluator.motion_conditions(x, none, angle);
    ASSERT_TRUE(at.rows.empty());
    ASSERT_GE(at.folds.size(), 3u);
    EXPECT_NEAR(at.values[0], (at.folds[0].angle - angle.aimed) * std::numbers::pi / 180, 1e-12);
    const auto angles = [&](const Eigen::VectorXd& y) {
        Eigen::VectorXd found(at.values.size());
        TriMesh mesh = e.problem.surface;
        mesh.vertices = e.evaluator.equilibrium(y);
        const Points n = triangle_normals(mesh);
        for (std::size_t i = 0; i < at.folds.size(); ++i) {
            const auto [s, t] = of(e.problem.surface).triangles(at.folds[i].edge);
            found[static_cast<Eigen::Index>(i)] = dihedral(n.row(s), n.row(t));
        }
        return found;
    };
    const Eigen::VectorXd change = (angles(x + h * p) - angles(x - h * p)) / (2 * h);
    EXPECT_LT((change - at.slopes * p).norm(), 1e-5 * change.norm());
    EXPECT_GT((change - 1.01 * at.slopes * p).norm(), 1e-3 * change.norm()) << "the test can fail";
}

/// On steps from a design that is sound, the conditions hold there, and say at the end what is true there.
TEST(EdgeFolds, ConditionsOnStepsHoldWhereTheseBegin) {
    MotionConditions at;
    at.folds.resize(2);
    at.values = Eigen::Vector2d(0.2, 0.1);
    at.slopes = (Eigen::Matrix2d() << 0.1, 0, 0.5, 0).finished();
    const Eigen::Vector2d way(1, 1);
    const MotionConditions steps = on_steps(at, way);
    EXPECT_EQ(steps.values[0], 0);
    EXPECT_NEAR((steps.values + steps.slopes * way - at.values).norm(), 0, 1e-15);
    EXPECT_NEAR(steps.values[1], -0.4, 1e-15) << "what holds there is left alone";
    EXPECT_EQ(on_steps(at, Eigen::Vector2d::Zero()).values.maxCoeff(), 0);
}

/// A design whose edges are sharper than may be becomes the nearest one whose edges are not.
TEST(EdgeFolds, DesignsAreMovedToWhereNoEdgeIsFolded) {
    Evaluated keeps(loaded_body(false), 3), lets(loaded_body(true), 3);
    int shown = 0;
    for (unsigned seed = 1; seed <= 4; ++seed) {
        for (Evaluated* e : {&keeps, &lets}) e->evaluator.limit_motion();
        const Eigen::VectorXd x = bent(keeps, seed);
        if (x.isZero(0)) continue;
        ++shown;
        const double asked = sharpest(keeps, x) - 6;
        const Eigen::VectorXd moved = keeps.evaluator.within(x, 1e-3, asked),
                              same = lets.evaluator.within(x, 1e-3, asked);
        EXPECT_LE(sharpest(keeps, moved), asked);
        EXPECT_GT(sharpest(lets, same), asked) << "the motion limit alone does not move it";
        const Eigen::VectorXd d = moved - x, whole = x;
        EXPECT_LT(d.dot(keeps.space.metric * d), 0.25 * whole.dot(keeps.space.metric * whole));
    }
    EXPECT_GE(shown, 2);
}
