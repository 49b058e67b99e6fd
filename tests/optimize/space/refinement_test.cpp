#include "optimize/space/refinement.hpp"

#include "core/error.hpp"
#include "optimize/evaluate/evaluation.hpp"
#include "optimize/run/coarse_to_fine.hpp"
#include "optimize/space/mirror.hpp"
#include "problems.hpp"

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

using namespace strake;

namespace {

Eigen::MatrixXd random_definite(int n, int seed) {
    const Eigen::VectorXd entries = random_vector(n * n, seed);
    const Eigen::MatrixXd A = Eigen::Map<const Eigen::MatrixXd>(entries.data(), n, n);
    return A * A.transpose() + 0.1 * Eigen::MatrixXd::Identity(n, n);
}

/// A target that only a load on the part x > 0.5, y > 0, z > 0 makes.
Problem bump_problem(double load) {
    Problem problem = ellipsoid_problem(3, 3);
    problem.parameters.kinds = {VariableKind::normal_load};
    problem.parameters.split = SplitRule::sensitivity;
    // Held all along the bottom, so that what is done in one place stays there.
    const Points centre = triangle_centroids(problem.surface);
    problem.fixed.clear();
    for (int t = 0; t < problem.surface.num_triangles(); ++t)
        if (centre(t, 2) < -0.05) problem.fixed.push_back(t);
    const auto rest = rest_facts(problem);
    ShapeEvaluator evaluator(problem, rest, {});
    const DesignSpace fine = design_space(rest, 3);
    evaluator.enter(fine);
    Eigen::VectorXd x = Eigen::VectorXd::Zero(fine.size());
    for (int j = 0; j < fine.size(); ++j) {
        const Patch& patch = fine.patches().patches[fine.variables[j].patch];
        const Eigen::RowVector3d c = centre.row(patch.triangles[patch.triangles.size() / 2]);
        if (c[0] > 0 && c[1] > 0 && c[2] > 0) x[j] = load;
    }
    const ShapeEvaluation wanted = evaluator.evaluate(x, 1);
    problem.quantities.push_back(
        target_shape_same("match", problem.surface, with_vertices(problem.surface, wanted.vertices)));
    problem.objective = "match";
    return problem;
}

Problem problem_that_may_split_all() {
    Problem problem = ellipsoid_problem(3, 3);
    problem.parameters.kinds = {VariableKind::normal_load};
    problem.parameters.split = SplitRule::sensitivity;
    problem.parameters.marking_fraction = 1;
    problem.parameters.max_variable_ratio = 100;
    return problem;
}

/// As if the objective fell along these forces, one per vertex.
ShellSensitivities falls_along(const Points& force) {
    ShellSensitivities s;
    s.force = -force;
    s.spring = s.prism_height = Eigen::VectorXd::Zero(force.rows());
    return s;
}

int count_chosen(const RefinementPlan& plan) {
    return static_cast<int>(std::ranges::count_if(plan.splits, [](const auto& split) { return split.chosen; }));
}

double expected_of_chosen(const RefinementPlan& plan) {
    double sum = 0;
    for (const SplitDecrease& split : plan.splits)
        if (split.chosen) sum += split.decrease;
    return sum;
}

}  // namespace

TEST(CarriedHessian, KeepsWhatTheParentKnewAndTheMetricOfTheRest) {
    const int n = 7, m = 3;
    const Eigen::MatrixXd H = random_definite(m, 1), M = random_definite(n, 2);
    const Eigen::VectorXd entries = random_vector(n * m, 3);
    const Eigen::MatrixXd P = Eigen::Map<const Eigen::MatrixXd>(entries.data(), n, m);
    const Eigen::MatrixXd carried = carried_hessian(H, P, M, 2.5);
    EXPECT_LT((P.transpose() * carried * P - H).cwiseAbs().maxCoeff(), 1e-12 * H.cwiseAbs().maxCoeff());
    // A direction orthogonal to the parent's in the metric has curvature 2.5 in it.
    Eigen::VectorXd d = random_vector(n, 4);
    d -= P * (P.transpose() * M * P).ldlt().solve(P.transpose() * M * d);
    EXPECT_NEAR(d.dot(carried * d), 2.5 * d.dot(M * d), 1e-12 * d.dot(M * d));
    EXPECT_LT((P.transpose() * carried * d).cwiseAbs().maxCoeff(), 1e-12 * carried.norm() * d.norm());
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(carried).eigenvalues().minCoeff(), 0);
    EXPECT_NEAR(mean_curvature(2.5 * M, M), 2.5, 1e-12);
    // One direction that is a thousand times stiffer says little of the others.
    const Eigen::VectorXd Md = M * d;
    EXPECT_LT(mean_curvature(2.5 * (M + 999 / d.dot(Md) * Md * Md.transpose()), M), 2.5 * std::pow(1001, 1.0 / n));
}

TEST(Refinement, EverySplitButTheFirstEarnsItsPrice) {
    const Problem problem = problem_that_may_split_all();
    const DesignSpace space = design_space(rest_facts(problem), 2);
    const Eigen::VectorXd x = Eigen::VectorXd::Zero(space.size());
    Points force = problem.surface.vertices;
    for (int v = 0; v < force.rows(); ++v) force.row(v) *= 1 + force(v, 0) + 2 * force(v, 2);
    const DesignFacts facts{space, x, falls_along(force), 1, force};
    const auto forecast = make_forecast(facts);
    ASSERT_TRUE(forecast);
    const RefinementPlan all = plan_refinement(facts, *forecast);
    ASSERT_EQ(count_chosen(all), 4);
    EXPECT_NEAR(expected_of_chosen(all), forecast->decrease, 1e-6 * forecast->decrease);
    const double least = 1.01 * all.splits[2].decrease / all.splits[2].new_variables;
    const RefinementPlan some = plan_refinement(facts, *forecast, least);
    EXPECT_EQ(count_chosen(some), 2);
    EXPECT_GE(some.splits[1].decrease, least * some.splits[1].new_variables);
    EXPECT_EQ(count_chosen(plan_refinement(facts, *forecast, 1e300)), 1);
}

TEST(Refinement, WhatLeavesAtTheirBoundsCannotDoIsNotExpected) {
    const Problem problem = problem_that_may_split_all();
    const auto rest = rest_facts(problem);
    // One quadrant in its two octants, which have no parts, the other three whole.
    const DesignSpace quadrants = design_space(rest, 2);
    const Front front = split_front(*rest->tree, *quadrants.front, {0, 0, 0, 1});
    const DesignSpace space = refine(quadrants, Eigen::VectorXd::Zero(quadrants.size()), front).space;
    const Points force = problem.surface.vertices;
    const ShellSensitivities lagrangian = falls_along(force);
    Eigen::VectorXd x = Eigen::VectorXd::Zero(space.size());
    const Eigen::VectorXd g = design_gradient(space, x, lagrangian);
    int leaves = 0;
    const std::vector<int> parts = parts_of(*rest->tree, front);
    for (int j = 0; j < space.size(); ++j)
        if (parts[space.variables[j].patch] == 1) {
            x[j] = g[j] > 0 ? space.lower[j] : space.upper[j];
            ++leaves;
        }
    ASSERT_EQ(leaves, 2);
    const DesignFacts facts{space, x, lagrangian, 1, force};
    const auto forecast = make_forecast(facts);
    ASSERT_TRUE(forecast);
    const RefinementPlan plan = plan_refinement(facts, *forecast);
    EXPECT_NEAR(expected_of_chosen(plan), forecast->decrease, 1e-6 * forecast->decrease);
}

/// Quadrants feel nothing of forces that are opposite on their octants.
TEST(Refinement, PartsOfPartsAreSeenWherePartsFeelNothing) {
    Problem problem = problem_that_may_split_all();
    problem.parameters.max_variable_ratio = 2;
    const DesignSpace halves = design_space(rest_facts(problem), 1);
    ASSERT_EQ(halves.size(), 2);
    const DesignSpace octants = design_space(halves.rest, 3);
    const Eigen::VectorXd x = Eigen::VectorXd::Zero(halves.size());
    // The force under which octants 0 and 1, of one quadrant, have opposite slopes and all others none.
    Eigen::MatrixXd slopes(octants.size(), octants.size());
    std::vector<Points> each;
    for (int j = 0; j < octants.size(); ++j) {
        Points force = Points::Zero(problem.surface.num_vertices(), 3);
        for (const int t : octants.patches().patches[j].triangles)
            for (int k = 0; k < 3; ++k)
                force.row(problem.surface.triangles(t, k)) += octants.rest->area[t] * octants.rest->normal.row(t);
        slopes.col(j) = design_gradient(octants, Eigen::VectorXd::Zero(octants.size()), falls_along(force));
        each.push_back(force);
    }
    int first = 0, second = -1;
    for (int j = 1; j < octants.size() && second < 0; ++j)
        if (octants.patches().patches[j].parent == octants.patches().patches[first].parent) second = j;
    ASSERT_GT(second, 0);
    Eigen::VectorXd wanted = Eigen::VectorXd::Zero(octants.size());
    wanted[first] = 1, wanted[second] = -1;
    const Eigen::VectorXd amounts = slopes.partialPivLu().solve(wanted);
    Points force = Points::Zero(problem.surface.num_vertices(), 3);
    for (int j = 0; j < octants.size(); ++j) force += amounts[j] * each[j];
    const ShellSensitivities lagrangian = falls_along(force);
    const DesignFacts facts{halves, x, lagrangian, 1, force};

    const auto parts = make_forecast(facts), deeper = make_forecast(facts, 2);
    ASSERT_TRUE(parts && deeper);
    EXPECT_FALSE(make_forecast(facts, 3)) << "octants have no parts";
    EXPECT_LT(parts->decrease, 1e-5 * deeper->decrease) << "what slopes are exact to, squared";
    const RefinementPlan plan = plan_refinement(facts, *deeper, 1e-3 * deeper->decrease);
    EXPECT_EQ(plan.depth, 2);
    EXPECT_EQ(count_chosen(plan), 1);
    EXPECT_GT(plan.chosen, 0.1 * deeper->decrease);
    // The other half is whole, so is the other quadrant of this one.
    const InheritedSpace next = refine(halves, x, plan.next);
    EXPECT_EQ(next.space.size(), 4);
    EXPECT_EQ(plan.variables_after, 4);
    for (const Patch& patch : next.space.patches().patches)
        EXPECT_EQ(patch.parent, halves.patches().label[patch.triangles.back()]);
    EXPECT_NE(plan.words().find("parts of patches promise too little"), std::string::npos) << plan.words();
}

/// Of each quadrant one octant is held: the other one does what the quadrant does.
TEST(Refinement, PartsOfPartsThatAreTheSameAreNotOffered) {
    Problem problem = problem_that_may_split_all();
    const auto are_offered = [&] {
        const DesignSpace halves = design_space(rest_facts(problem), 1);
        const Points force = Points::Ones(problem.surface.num_vertices(), 3);
        const ShellSensitivities lagrangian = falls_along(force);
        return make_forecast({halves, Eigen::VectorXd::Zero(halves.size()), lagrangian, 1, force}, 2).has_value();
    };
    EXPECT_TRUE(are_offered());
    const Points centre = triangle_centroids(problem.surface);
    problem.fixed.clear();
    for (int t = 0; t < problem.surface.num_triangles(); ++t)
        if (centre(t, 2) <= 1e-9) problem.fixed.push_back(t);
    EXPECT_FALSE(are_offered());
}

/// Two quadrants of one half have four octants, with the other half one more than a level may have.
TEST(Refinement, PartsOfPartsCountWithThoseBesideThem) {
    Problem problem = problem_that_may_split_all();
    for (const double ratio : {2.2, 2.6, 100.0}) {
        problem.parameters.max_variable_ratio = ratio;
        const DesignSpace halves = design_space(rest_facts(problem), 1);
        const int n = problem.surface.num_vertices();
        const Eigen::VectorXd numbers = random_vector(3 * n, 7);
        const Points force = Eigen::Map<const Points>(numbers.data(), n, 3);
        const ShellSensitivities lagrangian = falls_along(force);
        const DesignFacts facts{halves, Eigen::VectorXd::Zero(halves.size()), lagrangian, 1, force};
        const auto forecast = make_forecast(facts, 2);
        ASSERT_TRUE(forecast);
        const RefinementPlan plan = plan_refinement(facts, *forecast);
        EXPECT_GE(count_chosen(plan), 1);
        EXPECT_LE(plan.variables_after, ratio * halves.size());
        EXPECT_EQ(plan.variables_after, refine(halves, facts.x, plan.next).space.size());
        if (ratio > 10) {
            EXPECT_EQ(plan.variables_after, 8);
        }
    }
}

/// Octants move by turns, and quadrants can do nothing of it.
TEST(Refinement, ARunGoesOnToPartsOfParts) {
    Problem problem = ellipsoid_problem(3, 3);
    problem.parameters.kinds = {VariableKind::normal_load};
    problem.parameters.split = SplitRule::sensitivity;
    const auto rest = rest_facts(problem);
    ShapeEvaluator evaluator(problem, rest, {});
    const DesignSpace fine = design_space(rest, 3);
    evaluator.enter(fine);
    Eigen::VectorXd x = Eigen::VectorXd::Constant(fine.size(), 0.3);
    std::vector<int> seen(fine.patches().patches.size(), 0);
    for (int j = 0; j < fine.size(); ++j)
        x[j] += seen[fine.patches().patches[fine.variables[j].patch].parent]++ == 0 ? 0.2 : -0.2;
    const ShapeEvaluation wanted = evaluator.evaluate(x, 1);
    problem.quantities.push_back(
        target_shape_same("match", problem.surface, with_vertices(problem.surface, wanted.vertices)));
    problem.objective = "match";
    problem.optimize.max_evaluations = 40;
    problem.optimize.min_expected_gain = 0.01;
    const auto left = [&](bool as_before) {
        problem.optimize.sees_parts_alone = as_before;
        const RunResult result = optimize(problem);
        return result.objective / result.objective_start;
    };
    const double now = left(false), before = left(true);
    EXPECT_LT(now, 0.7 * before) << "the motion limit stops both " << now << " " << before;
}

TEST(Refinement, WhatIsNotMadeGivesNoModelCorrection) {
    Problem problem = ellipsoid_problem(3, 2);
    problem.parameters.kinds = {VariableKind::strain};
    problem.parameters.split = SplitRule::sensitivity;
    const Points aim = problem.surface.vertices * Eigen::Vector3d(1.02, 1, 1).asDiagonal();
    problem.quantities.push_back(target_shape_same("match", problem.surface, with_vertices(problem.surface, aim)));
    problem.objective = "match";
    problem.optimize.min_expected_gain =
        0.9;  // no split is expected to gain that much: the first level is left, then finished
    std::vector<std::string> notes;
    RunEvents events;
    events.note = [&](const std::string& words) { notes.push_back(words); };
    const RunResult result = optimize(problem, events);
    EXPECT_EQ(result.levels.size(), 1u) << result.reason;
    int decisions = 0;
    for (const std::string& note : notes) {
        decisions += note.starts_with("refinement: splits");
        EXPECT_EQ(note.find("the last one gave"), std::string::npos) << note;
    }
    EXPECT_EQ(decisions, 2);
}

TEST(DesignSpace, ProlongationIsTheDerivativeOfWhatIsInherited) {
    for (const VariableKind kind : {VariableKind::load, VariableKind::strain}) {
        Problem problem = ellipsoid_problem(2, 2);
        problem.parameters.kinds = {kind};
        const DesignSpace parent = design_space(rest_facts(problem), 1);
        const Eigen::VectorXd x = 0.3 * random_vector(parent.size(), 1), d = random_vector(parent.size(), 2);
        const InheritedSpace here = refine(parent, x);
        constexpr double step = 1e-4;
        const Eigen::VectorXd moved = refine(parent, x + step * d).x - here.x;
        EXPECT_LT((moved / step - here.prolongation * d).norm(), 1e-3 * d.norm());
        EXPECT_GT((here.prolongation * d).norm(), 0.1 * d.norm());
    }
}

TEST(Refinement, SplitsOnlyWhereTheBumpIs) {
    Problem problem = bump_problem(0.05);
    problem.optimize.max_evaluations = 200;
    problem.optimize.min_expected_gain = 1e-6;  // to the very bump: three variables already remove all but 5e-5 of it
    std::vector<std::vector<std::string>> fronts;
    RunEvents events;
    events.level = [&](const LevelStart& level) {
        fronts.emplace_back();
        for (const Patch& patch : level.space.patches().patches) fronts.back().push_back(patch.name);
    };
    const RunResult result = optimize(problem, events);
    ASSERT_EQ(fronts.size(), 3u) << result.reason;
    EXPECT_LT(result.objective, 1e-6 * result.objective_start);
    // The half away from the bump is never split, and nothing is split for its own sake afterwards.
    const auto& last = fronts.back();
    std::string names;
    for (const std::string& name : last) names += name + ' ';
    EXPECT_LE(last.size(), 5u) << names;
    EXPECT_EQ(std::count(last.begin(), last.end(), "p0.p0"), 1) << names;
    EXPECT_EQ(std::count(last.begin(), last.end(), "p0.p1.p1"), 0);
    EXPECT_TRUE(result.status == "converged" || result.status == "roundoff") << result.reason;
    EXPECT_NE(result.reason.find("no progress is expected from further refinement"), std::string::npos);
}

TEST(Refinement, CurvatureAlongDetailsIsTheSecondDifferenceOfTheValues) {
    Problem problem = bump_problem(0.05);
    const auto rest = rest_facts(problem);
    ShapeEvaluator evaluator(problem, rest, {"match", "volume"});
    const DesignSpace coarse = design_space(rest, 1);
    evaluator.enter(coarse);
    const Eigen::VectorXd x = 0.1 * random_vector(coarse.size(), 1), weight = Eigen::Vector2d(2, -0.3);
    ASSERT_EQ(evaluator.evaluate(x, 1).status, EvaluationStatus::ok);
    const DesignSpace fine = refine(coarse, x).space;
    const Eigen::VectorXd step = random_vector(fine.size(), 2);
    const Points at = evaluator.shell()->vertices(), moved = evaluator.shell()->response({load_forces(fine, step)})[0];
    const auto sum = [&](double h) {
        const TriMesh surface = with_vertices(problem.surface, at + h * moved);
        double value = 0;
        for (const Quantity& q : problem.quantities)
            for (std::size_t i = 0; i < q.names.size(); ++i)
                value += (q.names[i] == "match"    ? 2
                          : q.names[i] == "volume" ? -0.3
                                                   : 0) *
                         q.evaluate({surface, false, 0, 0, {}}).values[i];
        return value;
    };
    const double h = 0.01;
    const double expected = (sum(h) - 2 * sum(0) + sum(-h)) / (h * h);
    const auto curvature = evaluator.curvature_along(x, fine, step, weight);
    ASSERT_TRUE(curvature);
    EXPECT_NEAR(*curvature, expected, 1e-3 * std::abs(expected));
    // What a program gives would have to be paid.
    problem.quantities[0].program = "solver";
    EXPECT_FALSE(evaluator.curvature_along(x, fine, step, weight));
}

TEST(Refinement, EveryRuleStartsALevelFromTheInheritedShape) {
    for (const SplitRule rule : {SplitRule::tree, SplitRule::sensitivity, SplitRule::gradient}) {
        Problem problem = bump_problem(0.05);
        problem.parameters.split = rule;
        problem.parameters.max_variable_ratio = 1.5;
        const RunResult result = optimize(problem);
        ASSERT_GE(result.levels.size(), 2u);
        for (const LevelSummary& level : result.levels) {
            EXPECT_LT(level.inherited_shape_change, 1e-10);
        }
    }
}

TEST(Mirror, FindsThePlaneAndTiesImages) {
    Problem problem = ellipsoid_problem(3, 2);
    problem.parameters.mirror = true;
    problem.fixed.clear();
    const Points c = triangle_centroids(problem.surface);
    PatchHierarchy tree;
    tree.levels.push_back(level_by(problem.surface, nullptr, [](int) { return 0; }));
    tree.levels.push_back(level_by(problem.surface, &tree.levels[0], [&](int t) { return c(t, 0) > 1e-9 ? 1 : 0; }));
    tree.levels.push_back(level_by(problem.surface, &tree.levels[1], [&](int t) {
        return c(t, 1) > 1e-9 ? 2 : c(t, 1) < -1e-9 ? 0 : 1;
    }));
    problem.tree = tree;
    for (int t = 0; t < problem.surface.num_triangles(); ++t)
        if (std::abs(c(t, 0)) < 0.1) problem.fixed.push_back(t);
    const auto rest = rest_facts(problem);
    ASSERT_TRUE(rest->mirror);
    EXPECT_NEAR(std::abs(rest->mirror->normal[1]), 1, 1e-9);  // of three planes
    // Two pairs, and two patches that lie across the plane and may not be pulled out of it.
    const DesignSpace space = design_space(rest, 2);
    ASSERT_EQ(space.size(), 2 * 3 + 2 * 2);
    // The deformed shape is its own mirror image.
    ShapeEvaluator evaluator(problem, rest, {"volume"});
    evaluator.enter(space);
    ShapeEvaluation e = evaluator.evaluate(0.2 * random_vector(space.size(), 1), 1);
    ASSERT_EQ(e.status, EvaluationStatus::ok) << e.reason;
    Points image = e.vertices;
    image.col(1) *= -1;
    double worst = 0;
    for (int v = 0; v < image.rows(); ++v)
        worst = std::max(worst, std::sqrt((e.vertices.rowwise() - image.row(v)).rowwise().squaredNorm().minCoeff()));
    EXPECT_LT(worst, 1e-6);
    // And the gradient of a tied variable is the derivative along it.
    const Eigen::VectorXd x = 0.2 * random_vector(space.size(), 1), d = random_vector(space.size(), 2);
    e = evaluator.evaluate(x, 2);
    evaluator.differentiate(e);
    const Eigen::VectorXd g = e.gradients.row(0);
    const auto J = [&](const Eigen::VectorXd& y) { return evaluator.evaluate(y, 3).values[0]; };
    EXPECT_NEAR(taylor_order(J, x, g, d, 3e-2), 2, 0.15);
    EXPECT_NEAR(taylor_order(J, x, 1.1 * g, d, 3e-2), 1, 0.15);
}

TEST(Mirror, OfPlanesThatAreExactTheFirstIsTakenWhateverTheRounding) {
    TriMesh mesh = ellipsoid(Eigen::Vector3d(1, 0.6, 0.4), 3);
    mesh.vertices.col(0).array() += 0.1 * mesh.vertices.col(0).array().square();  // y and z are left
    for (int v = 0; v < mesh.num_vertices(); ++v) mesh.vertices(v, 1) += 1e-12 * std::sin(100.0 * v);
    const auto plane = plane_of_symmetry(mesh);
    ASSERT_TRUE(plane);
    EXPECT_EQ(plane->normal, Eigen::Vector3d(Eigen::Vector3d::UnitY()));
}

/// Left and right, not nose and tail, nor top and bottom.
TEST(Mirror, OfSeveralExactPlanesTheOneBetweenLeftAndRightIsTaken) {
    const auto normal_for = [](const Eigen::Vector3d& half_axes) {
        const auto plane = plane_of_symmetry(ellipsoid(half_axes, 3));
        return plane ? plane->normal : Eigen::Vector3d::Zero();
    };
    const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY();
    EXPECT_EQ(normal_for({1, 0.6, 0.4}), y);    // a body along x, wider than high
    EXPECT_EQ(normal_for({1, 0.2, 0.2}), y);    // a spindle
    EXPECT_EQ(normal_for({0.2, 1, 0.2}), x);    // along y
    EXPECT_EQ(normal_for({0.3, 2, 0.05}), y);   // a wing, whose span is longest
    EXPECT_EQ(normal_for({2, 0.3, 0.05}), x);   // a wing that spans x
    EXPECT_EQ(normal_for({1, 1, 0.1}), y);      // a disc
    EXPECT_EQ(normal_for({0.5, 0.5, 0.5}), y);  // no direction is the longest
}

TEST(Mirror, AnOffsetWithinRoundingIsZero) {
    TriMesh mesh = ellipsoid({1, 0.6, 0.4}, 3);
    mesh.vertices.col(1).array() += 1e-16;
    EXPECT_EQ(plane_of_symmetry(mesh)->offset, 0);
    mesh.vertices.col(1).array() += 1e-3;
    EXPECT_NEAR(plane_of_symmetry(mesh)->offset, 1e-3, 1e-12);
}

TEST(Mirror, ASurfaceWithoutPlaneIsRefused) {
    Problem problem = ellipsoid_problem(2, 1);
    problem.surface.vertices.col(0).array() += 0.2 * problem.surface.vertices.col(1).array().square() +
                                               3 * problem.surface.vertices.col(2).array().cube() +
                                               2 * problem.surface.vertices.col(1).array().cube();
    problem.parameters.mirror = true;
    EXPECT_THROW(rest_facts(problem), InvalidInput);
}

TEST(Ties, GroupsShareAndFrozenPatchesCarryNone) {
    Problem problem = ellipsoid_problem(2, 2);
    problem.parameters.kinds = {VariableKind::normal_load};
    const PatchLevel& level = problem.tree.levels[2];
    std::vector<char> group(problem.surface.num_triangles(), 0);
    for (const int p : {0, 1})
        for (const int t : level.patches[p].triangles) group[t] = 1;
    problem.parameters.groups = {group};
    DesignSpace space = design_space(rest_facts(problem), 2);
    EXPECT_EQ(space.size(), 3);
    EXPECT_EQ(space.variables[0].moves.size(), 2u);
    problem.parameters.groups.clear();
    problem.parameters.frozen = group;
    space = design_space(rest_facts(problem), 2);
    EXPECT_EQ(space.size(), 2);
    EXPECT_EQ(space.notes.size(), 2u);
    // Frozen at the second level: what the first level did stays.
    problem.parameters.frozen.assign(problem.surface.num_triangles(), 0);
    const DesignSpace parent = design_space(rest_facts(problem), 1);
    InheritedSpace child = refine(parent, Eigen::VectorXd::Constant(parent.size(), 0.3));
    EXPECT_LT((demand(child.space, child.x).loads.force -
               demand(parent, Eigen::VectorXd::Constant(parent.size(), 0.3)).loads.force)
                  .norm(),
              1e-14);
}

TEST(Variables, LoadsAlongStatedDirections) {
    Problem problem = ellipsoid_problem(2, 1);
    const Eigen::Vector3d direction = Eigen::Vector3d(1, 2, 2) / 3;
    problem.parameters.load_directions = {direction};
    const DesignSpace space = design_space(rest_facts(problem), 1);
    EXPECT_EQ(space.size(), 2);
    const Points force = demand(space, Eigen::VectorXd::Ones(2)).loads.force;
    EXPECT_LT((force - force * direction * direction.transpose()).norm(), 1e-15 * force.norm());
}
