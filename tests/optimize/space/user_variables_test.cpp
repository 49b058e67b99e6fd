#include "optimize/space/user_variables.hpp"

#include "core/error.hpp"
#include "evaluated.hpp"
#include "problems.hpp"

#include <gtest/gtest.h>

using namespace strake;

namespace {

/// Triangles whose centre is inside.
std::vector<int> where(const TriMesh& mesh, const std::function<bool(const Eigen::Vector3d&)>& inside) {
    const Points c = triangle_centroids(mesh);
    std::vector<int> triangles;
    for (int t = 0; t < mesh.num_triangles(); ++t)
        if (inside(c.row(t).transpose())) triangles.push_back(t);
    return triangles;
}

UserVariable user_load(const TriMesh& mesh, const std::string& name, bool normal) {
    UserVariable v;
    v.name = name;
    v.triangles = where(mesh, [](const Eigen::Vector3d& x) { return x[2] > 0.1 && x[0] < 0.4; });
    v.traction = Points::Zero(static_cast<Eigen::Index>(v.triangles.size()), 3);
    v.traction.col(1).setOnes();
    if (normal) v.traction = triangle_normals(mesh)(v.triangles, Eigen::all);
    return v;
}

UserVariable user_motion(const TriMesh& mesh, const std::string& name, bool turns) {
    UserVariable v;
    v.name = name;
    v.triangles = where(mesh, [](const Eigen::Vector3d& x) { return x[0] > 0.8; });
    if (turns) {
        v.motion.rotation = {0, 1, 0};
        v.motion.about = {0.8, 0, 0};
        v.unit = 0.2;
    } else {
        v.motion.translation = Eigen::Vector3d(1, 0, 1).normalized();
        v.max_displacement = 0.02;
    }
    return v;
}

/// Loads and motions of the user's beside those of the patches.
Problem with_user_variables(std::vector<VariableKind> kinds = {VariableKind::load}) {
    Problem problem = ellipsoid_problem(2, 3);
    problem.parameters.kinds = std::move(kinds);
    problem.parameters.free_border = 0.6;  // or strains would leave no skin between the cores of so coarse a mesh
    const TriMesh& mesh = problem.surface;
    problem.parameters.user_variables = {user_load(mesh, "push", false), user_load(mesh, "inflate", true),
                                         user_motion(mesh, "slide", false), user_motion(mesh, "hinge", true)};
    return problem;
}

std::string refusal(const Problem& problem) {
    try {
        rest_facts(problem);
    } catch (const InvalidInput& e) {
        return e.what();
    }
    return "";
}

bool has(const std::string& all, const std::string& part) { return all.find(part) != std::string::npos; }

}  // namespace

TEST(Given, GradientsAreExactBesideTheAutomaticVariables) {
    for (const auto& kinds : std::vector<std::vector<VariableKind>>{
             {VariableKind::load}, {VariableKind::strain}, {VariableKind::normal_load, VariableKind::stiffness}, {}}) {
        Evaluated e(with_user_variables(kinds));
        for (int j = 0; j < 4; ++j) EXPECT_EQ(e.space.variables[j].patch, -1);
        const Eigen::VectorXd x = 0.3 * random_vector(e.space.size(), 3), p = random_vector(e.space.size(), 5);
        ShapeEvaluation here = e.at(x);
        e.evaluator.differentiate(here);
        for (int i = 0; i < 2; ++i) {
            const auto J = [&](const Eigen::VectorXd& y) { return e.at(y).values[i]; };
            EXPECT_NEAR(taylor_order(J, x, here.gradients.row(i), p, 3e-3), 2, 0.15) << kinds.size() << ' ' << i;
            for (int j = 0; j < 4; ++j) {
                const Eigen::VectorXd h = 1e-5 * Eigen::VectorXd::Unit(x.size(), j);
                const double slope = (J(x + h) - J(x - h)) / 2e-5;
                EXPECT_NEAR(here.gradients(i, j), slope, 1e-5 * here.gradients.row(i).norm()) << j;
            }
        }
    }
}

TEST(Given, UnitsMoveTheSurfaceByTheirOwnMaxDisplacement) {
    Problem problem = with_user_variables();
    problem.parameters.max_displacement = 1e-6;  // so small that the response is linear
    problem.parameters.user_variables[2].max_displacement = 3e-6;
    Evaluated e(problem);
    const double diagonal = e.rest->diagonal;
    EXPECT_NEAR(e.at(Eigen::VectorXd::Unit(e.space.size(), 0)).max_displacement, 1e-6 * diagonal, 1e-9 * diagonal);
    EXPECT_NEAR(e.at(Eigen::VectorXd::Unit(e.space.size(), 1)).max_displacement, 1e-6 * diagonal, 1e-9 * diagonal);
    EXPECT_NEAR(e.at(Eigen::VectorXd::Unit(e.space.size(), 2)).max_displacement, 3e-6 * diagonal, 1e-9 * diagonal);
    EXPECT_EQ(physical_values(e.space, Eigen::VectorXd::Ones(e.space.size()))[3],
              (std::pair<std::string, double>("hinge", 0.2)));
}

TEST(Given, ALimitOfItsOwnThatTheMotionLimitForbidsIsNoted) {
    const auto notes_with = [](double motion_limit) {
        Problem problem = with_user_variables();
        problem.parameters.max_displacement = motion_limit;
        std::string all;
        for (const std::string& note : Evaluated(problem).space.notes) all += note + "\n";
        return all;
    };
    EXPECT_TRUE(has(notes_with(0.01),
                    "slide: at its own limit it moves the surface by 2 % of the diagonal, but the "
                    "motion limit is 1 %: raise parameters.max_displacement"))
        << notes_with(0.01);
    EXPECT_FALSE(has(notes_with(0.03), "slide: at its own limit")) << notes_with(0.03);
}

TEST(Given, MotionsMoveTheirTrianglesRigidlyAboutTheStatedPoint) {
    Evaluated e(with_user_variables());
    const ShapeEvaluation turned = e.at(Eigen::VectorXd::Unit(e.space.size(), 3));
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitY()).toRotationMatrix();
    const Eigen::Vector3d about(0.8, 0, 0);
    for (const int t : e.problem.parameters.user_variables[3].triangles)
        for (int k = 0; k < 3; ++k) {
            const int v = e.problem.surface.triangles(t, k);
            const Eigen::Vector3d x = e.problem.surface.vertices.row(v).transpose();
            EXPECT_LT((turned.vertices.row(v).transpose() - about - turn * (x - about)).norm(), 1e-12);
        }
}

TEST(Given, TheyAreCarriedOverExactlyAndNeverSplit) {
    for (const auto& kinds : std::vector<std::vector<VariableKind>>{{VariableKind::load}, {VariableKind::strain}}) {
        Evaluated e(with_user_variables(kinds));
        DesignSpace space = e.space;
        Eigen::VectorXd x = 0.3 * random_vector(space.size(), 9);
        const ShapeEvaluation before = e.at(x);
        e.evaluator.accept();
        for (int level = 2; level <= 3; ++level) {
            const InheritedSpace child = refine(space, x);
            e.evaluator.enter(child.space);
            const ShapeEvaluation after = e.at(child.x);
            EXPECT_LT((after.vertices - before.vertices).cwiseAbs().maxCoeff(), 1e-10 * e.rest->diagonal);
            for (int j = 0; j < 4; ++j) {
                EXPECT_EQ(child.space.variables[j].name, e.problem.parameters.user_variables[j].name);
                EXPECT_NEAR(child.x[j] * child.space.variables[j].unit, x[j] * space.variables[j].unit,
                            1e-12 * std::abs(x[j] * space.variables[j].unit));
            }
            space = child.space;
            x = child.x;
        }
        EXPECT_TRUE(space.carried_user_values.isZero(1e-14));
    }
}

TEST(Given, ARunThatRefinesBySensitivityUsesThem) {
    Problem problem = with_user_variables({VariableKind::normal_load});
    problem.parameters.split = SplitRule::sensitivity;
    problem.optimize.min_expected_gain = 0;  // however little it is
    maximize_volume(problem);
    problem.optimize.max_evaluations = 40;
    const RunResult r = optimize(problem);
    EXPECT_TRUE(r.is_done()) << r.status << ": " << r.reason;
    EXPECT_GT(r.levels.size(), 1u);
    for (const LevelSummary& level : r.levels) EXPECT_LT(level.inherited_shape_change, 1e-10);
    EXPECT_GT(r.x.head(4).cwiseAbs().minCoeff(), 0);
    Problem without = problem;
    without.parameters.user_variables.clear();
    EXPECT_GE(r.objective, optimize(without).objective);
}

TEST(Given, WhatTheyMoveHolds) {
    Problem problem = with_user_variables();
    problem.fixed.clear();
    Evaluated e(problem);
    EXPECT_EQ(e.at(0.1 * Eigen::VectorXd::Ones(e.space.size())).status, EvaluationStatus::ok);
}

TEST(Given, UnitOfLengthDoesNotMatter) {
    const auto shape = [](double size) {
        Problem problem = ellipsoid_problem(2, 1, size);
        UserVariable push, turn;
        push.name = "push";
        push.triangles = where(problem.surface, [=](const Eigen::Vector3d& x) { return x[2] > 0.1 * size; });
        push.traction = Points::Zero(static_cast<Eigen::Index>(push.triangles.size()), 3);
        push.traction.col(1).setOnes();
        turn.name = "turn";
        turn.triangles = where(problem.surface, [=](const Eigen::Vector3d& x) { return x[0] > 0.8 * size; });
        turn.motion.rotation = {0, 1, 0};
        turn.motion.about = {0.8 * size, 0, 0};
        problem.parameters.user_variables = {push, turn};
        Evaluated e(problem);
        return Points(e.at(0.5 * Eigen::VectorXd::Ones(e.space.size())).vertices / size);
    };
    EXPECT_LT((shape(1) - shape(1000)).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(Given, WhatCannotBeIsRefused) {
    const Problem good = with_user_variables();
    ASSERT_EQ(refusal(good), "");
    Problem p = good;
    p.parameters.user_variables[1].name = "push";
    EXPECT_TRUE(has(refusal(p), "two user variables are called 'push'"));
    p = good;
    p.parameters.user_variables[0].triangles[0] = -1;
    EXPECT_TRUE(has(refusal(p), "triangle -1"));
    p = good;
    p.parameters.user_variables[3].triangles.pop_back();
    EXPECT_TRUE(has(refusal(p), "follows another motion already"));
    p = good;
    p.parameters.user_variables[2].triangles = p.fixed;
    EXPECT_TRUE(has(refusal(p), "all of its triangles are fixed"));
    p = good;
    p.parameters.user_variables[0].traction.setZero();
    EXPECT_TRUE(has(refusal(p), "its traction is zero"));
    p = good;
    p.parameters.user_variables[2].motion.rotation = {0, 0, 1};
    EXPECT_TRUE(has(refusal(p), "about different points"));
    p = good;
    p.parameters.user_variables[0].traction(0, 0) = std::nan("");
    EXPECT_TRUE(has(refusal(p), "not finite"));
}
