#include "core/fields/invariance.hpp"

#include "core/error.hpp"
#include "core/fields/displacement_fields.hpp"
#include "core/mesh/geometry.hpp"
#include "surfaces.hpp"
#include "tests/core/fields/left_over.hpp"
#include "tests/kinds_of_shape.hpp"

#include <gtest/gtest.h>
#include <random>

namespace strake {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;
using Type = ShapeKind::Type;

Points random_points(Eigen::Index n, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-1, 1);
    Points u(n, 3);
    for (double& value : u.reshaped()) value = uniform(random);
    return u;
}

struct Example {
    TriMesh mesh;
    ShapeKind kind;
    std::optional<SymmetryPlane> cut = {};
};

/// Of every kind, also away from the coordinate axes.
std::vector<Example> examples() {
    std::vector<Example> all{{extruded_section(24, 5), {Type::extruded, Vector3d::UnitY(), Vector3d::Zero(), 1}},
                             {body_of_revolution(16, 12), {Type::revolved, Vector3d::UnitX(), Vector3d::Zero(), 1}},
                             {cyclic_body(6, 3), {Type::cyclic, Vector3d::UnitX(), Vector3d::Zero(), 6}}};
    const Eigen::AngleAxisd turn(0.7, Vector3d(1, 2, -0.5).normalized());
    const std::size_t straight = all.size();
    for (std::size_t i = 0; i < straight; ++i) {
        Example turned = all[i];
        turned.mesh.vertices =
            (all[i].mesh.vertices * turn.toRotationMatrix().transpose()).rowwise() + Eigen::RowVector3d(5, -3, 1);
        turned.kind.axis = turn * all[i].kind.axis;
        turned.kind.through = Vector3d(5, -3, 1);
        all.push_back(turned);
    }
    return all;
}

TEST(Invariance, ProjectsToMotionsThatKeepTheKindOfShape) {
    for (const Example& example : examples()) {
        const Invariance invariance(example.mesh, example.kind);
        EXPECT_LT(invariance.num_classes(), example.mesh.num_vertices() / 2) << to_string(example.kind);
        const Points u = random_points(example.mesh.num_vertices(), 3), f = random_points(u.rows(), 4);
        const Points once = invariance.projected(u);
        EXPECT_LT((invariance.projected(once) - once).cwiseAbs().maxCoeff(), 1e-14);
        EXPECT_GT(invariance.deviation(u), 0.1) << "the test can fail";
        EXPECT_NEAR(once.cwiseProduct(f).sum(), u.cwiseProduct(invariance.pulled_back(f)).sum(), 1e-12);
        TriMesh moved = example.mesh, other = example.mesh;
        moved.vertices += 0.05 * once;
        other.vertices += 0.05 * u;
        EXPECT_LT(off_kind(moved, example.kind), 1e-13 * box_diagonal(moved)) << to_string(example.kind);
        EXPECT_GT(off_kind(other, example.kind), 1e-3) << "the test can fail";
    }
}

/// Of chosen motions alone: a profile changes, its stations stay; and together they are as many as without a choice.
TEST(Invariance, FieldsOfChosenMotions) {
    const TriMesh mesh = body_of_revolution(16, 12);
    FieldConditions conditions;
    conditions.kind = ShapeKind{Type::revolved, Vector3d::UnitX(), Vector3d::Zero(), 1};
    const DisplacementFields scaled(mesh, conditions, {8, {}, {"scale"}}), all(mesh, conditions, {8, {}, {}});
    ASSERT_EQ(scaled.size(), 8);
    for (int b = 0; b < 8; ++b) {
        EXPECT_EQ(scaled.name(b), text("section.scale.", b));
        EXPECT_EQ(scaled.field(b).col(0).cwiseAbs().maxCoeff(), 0) << "along the axis";
        EXPECT_GT(scaled.field(b).cwiseAbs().maxCoeff(), 0.5);
    }
    EXPECT_GT(all.displacement(VectorXd::Ones(8)).col(0).cwiseAbs().maxCoeff(), 0.1) << "the test can fail";
    EXPECT_THROW(DisplacementFields(mesh, conditions, {8, {}, {"grow"}}), InvalidInput);
    EXPECT_THROW(DisplacementFields(mesh, conditions, {8, {}, {"shear"}}), InvalidInput) << "none are revolved";
}

/// What is held is not deformed, also where its triangles have centroids that rounding puts beside them.
TEST(Invariance, FieldsLeaveHeldTrianglesAsTheyAre) {
    const TriMesh mesh = body_of_revolution(16, 12);
    FieldConditions conditions;
    conditions.kind = ShapeKind{Type::revolved, Vector3d::UnitX(), Vector3d::Zero(), 1};
    const double front = mesh.vertices.col(0).minCoeff(), length = mesh.vertices.col(0).maxCoeff() - front;
    const Points centroid = triangle_centroids(mesh);
    for (int t = 0; t < mesh.num_triangles(); ++t)
        if (centroid(t, 0) < front + 0.3 * length) conditions.held.push_back(t);
    ASSERT_GT(conditions.held.size(), 16u);
    const DisplacementFields fields(mesh, conditions, {8, {}, {"scale"}});
    const auto maps = fields.local_maps(VectorXd::Ones(8));
    for (const int t : conditions.held)
        EXPECT_EQ((maps[static_cast<std::size_t>(t)] - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 0) << t;
    EXPECT_GT((maps[static_cast<std::size_t>(mesh.num_triangles() / 2)] - Eigen::Matrix3d::Identity()).norm(), 0.1);
}

/// The half sees what the whole sees: of motions and, with half of the forces on the cut, of forces.
TEST(Invariance, OfAHalfIsThatOfTheWhole) {
    const TriMesh whole = body_of_revolution(16, 12);
    const SymmetryPlane plane{Vector3d::UnitY(), 0};
    std::vector<int> number;
    const TriMesh half = part_above(whole, plane, number);
    const ShapeKind kind{Type::revolved, Vector3d::UnitX(), Vector3d::Zero(), 1};
    const Invariance of_whole(whole, kind), of_half(half, kind, 1e-6, plane);
    Points u(whole.num_vertices(), 3);
    for (int v = 0; v < whole.num_vertices(); ++v) {
        const Vector3d x = whole.vertices.row(v);
        u.row(v) = Vector3d(x[0] * x[2], 0.3 * x[1] * x[2], x[0] - x[1] * x[1]);
    }
    Points of(half.num_vertices(), 3), force(half.num_vertices(), 3);
    for (int v = 0; v < half.num_vertices(); ++v) {
        of.row(v) = u.row(number[static_cast<std::size_t>(v)]);
        force.row(v) = (std::abs(half.vertices(v, 1)) < 1e-9 ? 0.5 : 1.0) * of.row(v);
    }
    const Points a = of_whole.projected(u), b = of_half.projected(of);
    const Points c = of_whole.pulled_back(u), d = of_half.pulled_back(force);
    for (int v = 0; v < half.num_vertices(); ++v) {
        const int w = number[static_cast<std::size_t>(v)];
        const double share = std::abs(half.vertices(v, 1)) < 1e-9 ? 0.5 : 1.0;
        EXPECT_LT((a.row(w) - b.row(v)).norm(), 1e-13);
        EXPECT_LT((share * c.row(w) - d.row(v)).norm(), 1e-13);
        if (share < 1) {
            EXPECT_EQ(b(v, 1), 0) << "on the cut, by every bit";
        }
    }
}

std::string refusal(const TriMesh& mesh, const ShapeKind& kind) {
    try {
        const Invariance made(mesh, kind);
    } catch (const InvalidInput& e) {
        return e.what();
    }
    return "";
}

TEST(Invariance, RefusesAnotherBodyWithPlaceAndDeviation) {
    for (Example example : examples()) {
        const double diagonal = box_diagonal(example.mesh);
        const int v = example.mesh.num_vertices() / 2;
        const Vector3d across = example.kind.axis.unitOrthogonal();
        TriMesh slightly = example.mesh;
        slightly.vertices.row(v) += 2e-7 * diagonal * across;
        EXPECT_EQ(refusal(slightly, example.kind), "") << "within the tolerance";
        TriMesh off = example.mesh;
        off.vertices.row(v) += 3e-3 * diagonal * across;
        const std::string words = refusal(off, example.kind);
        EXPECT_NE(words.find(to_string(example.kind)), std::string::npos) << words;
        EXPECT_NE(words.find(" at ("), std::string::npos) << words;
        EXPECT_NE(words.find("by "), std::string::npos) << words;
        EXPECT_NE(words.find("limit"), std::string::npos) << words;
    }
    EXPECT_NE(refusal(icosphere(2), {Type::extruded, Vector3d::UnitY(), Vector3d::Zero(), 1}), "");
    EXPECT_NE(refusal(box_surface({1, 2, 3}, 3), {Type::revolved, Vector3d::UnitY(), Vector3d::Zero(), 1}), "");
    EXPECT_NE(refusal(icosphere(2), {Type::cyclic, Vector3d::UnitX(), Vector3d::Zero(), 7}), "");
    EXPECT_NE(refusal(icosphere(2), {Type::cyclic, Vector3d::UnitX(), Vector3d::Zero(), 1}), "") << "count";
    EXPECT_NE(refusal(icosphere(2), {Type::revolved, Vector3d(2, 0, 0), {}, 1}), "") << "length";
}

TEST(Invariance, WhatIsHeldHasToBeOfTheKind) {
    for (const Example& example : examples()) {
        const Invariance invariance(example.mesh, example.kind);
        EXPECT_THROW(invariance.check_held(example.mesh, {0}), InvalidInput) << to_string(example.kind);
        std::vector<int> all, none;
        for (int t = 0; t < example.mesh.num_triangles(); ++t) all.push_back(t);
        EXPECT_NO_THROW(invariance.check_held(example.mesh, all));
        EXPECT_NO_THROW(invariance.check_held(example.mesh, none));
    }
}

/// Fields of the kind are so by themselves: projecting takes away no more than round-off.
TEST(Invariance, FieldsOfTheKindKeepIt) {
    for (const Example& example : examples()) {
        const Invariance invariance(example.mesh, example.kind);
        for (const bool is_held : {false, true}) {
            FieldConditions conditions;
            conditions.kind = example.kind;
            if (is_held) conditions.held = held_end(example.mesh, example.kind);
            if (is_held) invariance.check_held(example.mesh, conditions.held);
            const DisplacementFields fields(example.mesh, conditions, {24, {}});
            EXPECT_GE(fields.size(), 12) << to_string(example.kind);
            for (int b = 0; b < fields.size(); ++b)
                EXPECT_LT(invariance.deviation(fields.field(b)), 1e-9) << to_string(example.kind) << fields.name(b);
            std::vector<std::string> names;
            for (int b = 0; b < fields.size(); ++b) names.push_back(fields.name(b));
            std::sort(names.begin(), names.end());
            EXPECT_EQ(std::unique(names.begin(), names.end()), names.end()) << "a name once";
        }
    }
}

/// What a designer means on a body of revolution: another contour. Its radius becomes another function of x.
TEST(Invariance, FieldsMakeAnotherContour) {
    const Example example{body_of_revolution(16, 24), {Type::revolved, Vector3d::UnitX(), Vector3d::Zero(), 1}};
    FieldConditions conditions;
    conditions.kind = example.kind;
    const DisplacementFields fields(example.mesh, conditions, {12, {}});
    Points wanted = example.mesh.vertices;
    for (int v = 0; v < wanted.rows(); ++v) {
        const double s = wanted(v, 0);
        wanted.row(v) = Eigen::RowVector3d(0, wanted(v, 1), wanted(v, 2)) * (0.2 * s * s - 0.1 * s);
    }
    EXPECT_LT(left_over(example.mesh, fields, wanted), 1e-4);
}

TEST(Invariance, NoFieldMovesOrTurnsTheBodyAtAPointThatIsStill) {
    const TriMesh body = ellipsoid({3, 1, 0.6}, 3);
    FieldConditions conditions;
    conditions.still = Vector3d(-1, 0.2, 0.1);
    const DisplacementFields fields(body, conditions, {27, {}});
    ASSERT_EQ(fields.size(), 27);
    // The motion near the point by its least-squares affine part: no translation, no rotation.
    TriMesh probe = body;
    const int first = body.num_vertices();
    const double h = 1e-4;
    probe.vertices.conservativeResize(first + 4, 3);
    probe.triangles.conservativeResize(body.num_triangles() + 2, 3);
    probe.vertices.row(first) = *conditions.still;
    for (int k = 0; k < 3; ++k) probe.vertices.row(first + 1 + k) = *conditions.still + h * Vector3d::Unit(k);
    probe.triangles.row(body.num_triangles()) << first, first + 1, first + 2;
    probe.triangles.row(body.num_triangles() + 1) << first, first + 1, first + 3;
    const DisplacementFields same(probe, conditions, {27, {}});
    double strain = 0;
    for (int b = 0; b < same.size(); ++b) {
        const Points u = same.field(b);
        EXPECT_LT(u.row(first).norm(), 1e-12) << same.name(b);
        Eigen::Matrix3d gradient;
        for (int k = 0; k < 3; ++k) gradient.col(k) = (u.row(first + 1 + k) - u.row(first)).transpose() / h;
        EXPECT_LT((gradient - gradient.transpose()).norm(), 1e-3) << same.name(b);
        strain = std::max(strain, gradient.norm());
    }
    EXPECT_GT(strain, 0.1) << "it may stretch there";
}

}  // namespace
}  // namespace strake
