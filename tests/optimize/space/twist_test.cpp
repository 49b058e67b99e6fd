#include "optimize/space/twist.hpp"

#include "cases/geometry/wing.hpp"
#include "core/error.hpp"
#include "optimize/evaluate/evaluation.hpp"
#include "optimize/run/fit.hpp"
#include "problems.hpp"

#include <gtest/gtest.h>
#include <numbers>
#include <numeric>

using namespace strake;

namespace {

constexpr double degree = std::numbers::pi / 180;

/// The wing, held at its root, with twist about its quarter chord line at root, middle and tip and no other variables.
struct TwistedWing {
    Problem problem;
    TwistSpec spec;
    TwistVariables made;
    explicit TwistedWing(int triangles = 1500, double size = 1, double max_angle = 2 * degree) {
        problem.name = "wing";
        problem.surface = example::wing(triangles);
        problem.surface.vertices *= size;
        const Points c = triangle_centroids(problem.surface);
        problem.tree.levels.push_back(level_by(problem.surface, nullptr, [](int) { return 0; }));
        problem.tree.levels.push_back(
            level_by(problem.surface, &problem.tree.levels.back(), [&](int t) { return c(t, 2) > 0; }));
        problem.prism_height =
            Eigen::VectorXd::Constant(problem.surface.num_vertices(), 0.02 * box_diagonal(problem.surface));
        problem.symmetry = SymmetryPlane{{0, 1, 0}, 0};
        for (int t = 0; t < problem.surface.num_triangles(); ++t) {
            bool inside = true;
            for (int k = 0; k < 3; ++k)
                inside &= problem.surface.vertices(problem.surface.triangles(t, k), 1) <= 0.06 * size;
            if (inside) problem.fixed.push_back(t);
        }
        problem.quantities = {volume(problem.surface, problem.symmetry), area()};
        problem.parameters.kinds = {};
        // From the quarter chord of the root to that of the tip.
        const example::WingShape shape;
        const double tip = shape.semi_span * std::tan(shape.sweep_deg * degree);
        const Eigen::Vector3d root(0.25 * shape.root_chord, 0, 0),
            end(tip + 0.25 * shape.taper * shape.root_chord, shape.semi_span, 0);
        spec.name = "twist";
        spec.triangles.resize(problem.surface.num_triangles());
        std::iota(spec.triangles.begin(), spec.triangles.end(), 0);
        spec.axis = (end - root).normalized();
        spec.about = size * root;
        spec.stations = {0, 0.5 * size * (end - root).norm(), size * (end - root).norm()};
        spec.max_angle = max_angle;
        made = twist_variables(problem, spec);
        problem.parameters.user_variables = made.variables;
    }
};

Points shape_at(const Problem& problem, const Eigen::VectorXd& x) {
    const auto rest = rest_facts(problem);
    ShapeEvaluator evaluator(problem, rest, {});
    evaluator.enter(design_space(rest, 1));
    const ShapeEvaluation shape = evaluator.evaluate(x, 1);
    EXPECT_EQ(shape.status, EvaluationStatus::ok) << shape.reason;
    return shape.vertices;
}

std::string refusal(const TwistedWing& wing, const TwistSpec& spec) {
    try {
        Problem bare = wing.problem;
        bare.parameters.user_variables.clear();
        twist_variables(bare, spec);
    } catch (const InvalidInput& e) {
        return e.what();
    }
    return "";
}

bool has(const std::string& all, const std::string& part) { return all.find(part) != std::string::npos; }

}  // namespace

TEST(Twist, TurnsOneSectionByTheStatedAngleAndLeavesTheOthers) {
    const TwistedWing wing;
    EXPECT_EQ(wing.made.held, (std::vector<char>{1, 0, 0}));  // the root is fixed
    ASSERT_EQ(wing.made.variables.size(), 2u);
    EXPECT_EQ(wing.made.variables[1].name, "twist.3");
    for (int k = 0; k < 2; ++k) {
        const Points moved = shape_at(wing.problem, Eigen::VectorXd::Unit(2, k)) - wing.problem.surface.vertices;
        const Eigen::VectorXd twist = section_twists(wing.problem.surface, wing.spec, wing.made.held, moved) / degree;
        EXPECT_NEAR(twist[1 + k], 2, 0.05 * 2) << k;
        EXPECT_NEAR(twist[2 - k], 0, 0.05 * 2) << k;
    }
}

TEST(Twist, TheLinearResponseIsExact) {
    const TwistedWing wing(1500, 1, 1e-6);
    const Points moved = shape_at(wing.problem, Eigen::VectorXd::Unit(2, 1)) - wing.problem.surface.vertices;
    const Eigen::VectorXd twist = section_twists(wing.problem.surface, wing.spec, wing.made.held, moved);
    EXPECT_NEAR(twist[2], 1e-6, 1e-11);
    EXPECT_NEAR(twist[1], 0, 1e-11);
}

TEST(Twist, AFieldThatTwistsIsMeasuredExactly) {
    // Linear between the stations, about the axis.
    const TwistedWing wing;
    const TriMesh& mesh = wing.problem.surface;
    Points d = Points::Zero(mesh.num_vertices(), 3);
    const auto& s = wing.made.stations;
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        const Eigen::Vector3d r = mesh.vertices.row(v).transpose() - wing.spec.about;
        const double at = wing.spec.axis.dot(r);
        const double angle = at < s[1] ? 0.02 * std::clamp((at - s[0]) / (s[1] - s[0]), 0.0, 1.0)
                                       : 0.02 + 0.03 * std::clamp((at - s[1]) / (s[2] - s[1]), 0.0, 1.0);
        d.row(v) = angle * wing.spec.axis.cross(r).transpose();
    }
    const Eigen::VectorXd twist = section_twists(mesh, wing.spec, {0, 0, 0}, d);
    EXPECT_NEAR(twist[0], 0, 5e-4);
    EXPECT_NEAR(twist[1], 0.02, 5e-4);
    EXPECT_NEAR(twist[2], 0.05, 5e-4);
}

TEST(Twist, NeitherUnitNorMeshMatter) {
    const Eigen::Vector2d x(0.5, -0.8);
    const TwistedWing metres, millimetres(1500, 1000), fine(6000);
    const Points a = shape_at(metres.problem, x), b = shape_at(millimetres.problem, x) / 1000;
    EXPECT_LT((a - b).cwiseAbs().maxCoeff(), 1e-9);
    // The tip's leading and trailing edge, by the largest motion of the whole.
    const double coarse_max = (a - metres.problem.surface.vertices).rowwise().norm().maxCoeff();
    const double fine_max = (shape_at(fine.problem, x) - fine.problem.surface.vertices).rowwise().norm().maxCoeff();
    EXPECT_NEAR(fine_max, coarse_max, 0.05 * coarse_max);
}

TEST(Twist, GradientsAreExact) {
    Problem problem = TwistedWing(1500, 1, 5 * degree).problem;
    problem.parameters.kinds = {VariableKind::load};
    problem.parameters.max_displacement = 0.02;
    const auto rest = rest_facts(problem);
    ShapeEvaluator evaluator(problem, rest, {"volume", "area"});
    const DesignSpace space = design_space(rest, 1);
    evaluator.enter(space);
    ASSERT_EQ(space.size(), 8);
    const Eigen::VectorXd x = 0.4 * random_vector(8, 3), p = random_vector(8, 4);
    ShapeEvaluation here = evaluator.evaluate(x, 1);
    ASSERT_EQ(here.status, EvaluationStatus::ok) << here.reason;
    evaluator.differentiate(here);
    for (int i = 0; i < 2; ++i) {
        const auto J = [&](const Eigen::VectorXd& y) { return evaluator.evaluate(y, 1).values[i]; };
        EXPECT_NEAR(taylor_order(J, x, here.gradients.row(i), p, 3e-2), 2, 0.15) << i;
        EXPECT_NEAR(taylor_order(J, x, 1.1 * here.gradients.row(i), p, 3e-2), 1, 0.15) << i;
    }
}

TEST(Twist, AFitRecoversATwistedTarget) {
    Problem problem = TwistedWing(1500, 1, 5 * degree).problem;
    const Eigen::Vector2d x(-0.6, 0.7);
    const TriMesh target = with_vertices(problem.surface, shape_at(problem, x));
    problem.quantities.push_back(target_shape_same("match", problem.surface, target));
    problem.fit = {"match"};
    const RunResult r = fit(problem);
    EXPECT_EQ(r.status, "converged") << r.reason;
    ASSERT_EQ(r.x.size(), 2);
    EXPECT_LT((r.x - x).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(Twist, AFitFindsTheTwistOfAWingThatWasTurnedBySections) {
    // Not a shape of the skin: every section is turned rigidly, linearly from 0 at the root to 4 degrees at the tip,
    // also those that the slanted axis lets run into the fixed root.
    TwistedWing wing(1500, 1, 6 * degree);
    const TriMesh& mesh = wing.problem.surface;
    TriMesh target = mesh;
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        const Eigen::Vector3d r = mesh.vertices.row(v).transpose() - wing.spec.about;
        const double share = std::clamp(wing.spec.axis.dot(r) / wing.made.stations[2], 0.0, 1.0);
        target.vertices.row(v) =
            (wing.spec.about + Eigen::AngleAxisd(4 * degree * share, wing.spec.axis) * r).transpose();
    }
    const double before = std::sqrt((target.vertices - mesh.vertices).rowwise().squaredNorm().mean());
    wing.problem.quantities.push_back(target_shape_same("match", mesh, target));
    wing.problem.fit = {"match"};
    const RunResult r = fit(wing.problem);
    ASSERT_EQ(r.x.size(), 2) << r.reason;
    EXPECT_NEAR(r.x[0] * 6, 2, 0.4);
    EXPECT_NEAR(r.x[1] * 6, 4, 0.2);
    EXPECT_LT(std::sqrt(r.objective), 0.25 * before);
}

TEST(Twist, WhatCannotBeIsRefused) {
    const TwistedWing wing;
    TwistSpec spec = wing.spec;
    spec.stations = {0, 1, 5};
    EXPECT_TRUE(has(refusal(wing, spec), "the station at 5 must lie in")) << refusal(wing, spec);
    spec.stations = {0, 1, 0.5};
    EXPECT_TRUE(has(refusal(wing, spec), "must lie beyond")) << refusal(wing, spec);
    spec.stations = {0};
    EXPECT_TRUE(has(refusal(wing, spec), "all stations are fixed")) << refusal(wing, spec);
    spec.stations = {0, 1, 1.0001, 1.0002};
    EXPECT_TRUE(has(refusal(wing, spec), "cannot follow its stations")) << refusal(wing, spec);
    spec = wing.spec;
    spec.axis *= 2;
    EXPECT_TRUE(has(refusal(wing, spec), "must be 1")) << refusal(wing, spec);
    spec = wing.spec;
    spec.max_angle = 0;
    EXPECT_TRUE(has(refusal(wing, spec), "max_angle")) << refusal(wing, spec);
}
