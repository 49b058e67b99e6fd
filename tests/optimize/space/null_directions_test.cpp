#include "optimize/space/null_directions.hpp"

#include "optimize/evaluate/evaluation.hpp"
#include "optimize/run/coarse_to_fine.hpp"
#include "problems.hpp"

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

using namespace strake;

namespace {

Eigen::MatrixXd random_matrix(int rows, int columns) {
    Eigen::MatrixXd m(rows, columns);
    for (int j = 0; j < columns; ++j) m.col(j) = random_vector(rows, 20 + j);
    return m;
}

/// Of the metric in variables that have size 1 in it, as the optimizer takes them.
double condition(const DesignSpace& space) {
    const Eigen::VectorXd scale = space.metric.diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> spectrum(scale.asDiagonal() * space.metric *
                                                                  scale.asDiagonal());
    return spectrum.eigenvalues().maxCoeff() / spectrum.eigenvalues().minCoeff();
}

/// A box, whose patches are its flat sides; the one at x = 0 is fixed.
Problem box_problem() {
    Problem problem;
    problem.name = "box";
    problem.surface = box_surface({1, 0.7, 0.4}, 4);
    const Points n = triangle_normals(problem.surface);
    problem.tree.levels.push_back(level_by(problem.surface, nullptr, [](int) { return 0; }));
    problem.tree.levels.push_back(level_by(problem.surface, &problem.tree.levels.back(), [&](int t) {
        for (int c = 0; c < 3; ++c)
            if (std::abs(n(t, c)) > 0.5) return 2 * c + (n(t, c) > 0);
        return -1;
    }));
    problem.prism_height = Eigen::VectorXd::Constant(problem.surface.num_vertices(), 0.06);
    for (int t = 0; t < problem.surface.num_triangles(); ++t)
        if (n(t, 0) < -0.5) problem.fixed.push_back(t);
    problem.quantities = {volume(problem.surface), area()};
    return problem;
}

/// More volume under a limit of the area, with one load that repeats what the patches of a side have, or without.
Problem more_volume(bool repeats, int subdivisions = 2) {
    Problem problem = ellipsoid_problem(subdivisions, 2);
    problem.parameters.kinds = {VariableKind::load};
    maximize_volume(problem);
    if (repeats) {
        UserVariable v;
        v.name = "again";
        v.triangles = problem.tree.levels[1].patches[1].triangles;
        v.traction = Points::Zero(static_cast<Eigen::Index>(v.triangles.size()), 3);
        v.traction.col(2).setOnes();
        problem.parameters.user_variables = {v};
    }
    return problem;
}

}  // namespace

TEST(NullDirections, DependentColumnsAreFound) {
    Eigen::MatrixXd m = random_matrix(60, 6);
    m.col(3) = 2 * m.col(0) - 0.5 * m.col(1);
    m.col(4) *= 1e-7;  // size is no dependence
    m.col(5).setZero();
    const Dependence found = dependence(m);
    EXPECT_EQ(found.kept, (std::vector<int>{0, 1, 2, 4, 5}));
    EXPECT_EQ(found.dependent, std::vector<int>{3});
    Eigen::VectorXd expected(5);
    expected << 2, -0.5, 0, 0, 0;
    EXPECT_LT((found.share.col(0) - expected).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(NullDirections, TheThresholdIsThatOfTheStatedShare) {
    Eigen::MatrixXd m = random_matrix(60, 4);
    const Eigen::VectorXd other = m.col(3);
    m.col(3) = m.col(0) + 0.3 * null_share * other;
    EXPECT_EQ(dependence(m).dependent, std::vector<int>{3});
    m.col(3) = m.col(0) + 10 * null_share * other;
    EXPECT_TRUE(dependence(m).dependent.empty());
}

TEST(NullDirections, WhatIsWeakIsNamedAndKept) {
    // One triangle out of the plane of a side: its normal load is not quite made of the side's vector load.
    Problem problem = box_problem();
    problem.parameters.kinds = {VariableKind::load, VariableKind::normal_load};
    const Points centre = triangle_centroids(problem.surface);
    Eigen::Index top = 0;
    centre.col(2).maxCoeff(&top);
    const auto size_with = [&](double bump, std::vector<std::string>* weak, std::string* note) {
        Problem bent = problem;
        bent.surface.vertices(bent.surface.triangles(top, 0), 2) += bump;
        const DesignSpace space = design_space(rest_facts(bent), 1);
        *weak = space.weak;
        for (const std::string& words : space.notes)
            if (words.find("nearly what others can do") != std::string::npos) *note = words;
        return space.size();
    };
    std::vector<std::string> weak;
    std::string note;
    int found = 0;
    for (double bump = 1e-4; bump < 0.1; bump *= 1.5) {
        if (size_with(bump, &weak, &note) < 16 || weak.empty()) continue;  // left out still, or strong already
        ++found;
        ASSERT_EQ(weak.size(), 1u);
        EXPECT_NE(weak[0].find("load_normal"), std::string::npos);
        EXPECT_NE(note.find("1 of 16 variables does nearly what others can do"), std::string::npos) << note;
    }
    EXPECT_GE(found, 1);
    EXPECT_EQ(size_with(0.3, &weak, &note), 16);
    EXPECT_TRUE(weak.empty());
    const DesignSpace ordinary = design_space(rest_facts(ellipsoid_problem(2, 3)), 3);
    EXPECT_TRUE(ordinary.weak.empty());
}

TEST(NullDirections, ANormalLoadOnAFlatPatchBesideItsVectorIsDependent) {
    Problem problem = box_problem();
    problem.parameters.kinds = {VariableKind::load, VariableKind::normal_load};
    const DesignSpace space = design_space(rest_facts(problem), 1);
    EXPECT_EQ(space.size(), 15);  // five free sides
    ASSERT_EQ(space.dependent.size(), 5u);
    for (const DependentVariable& other : space.dependent) EXPECT_EQ(other.variable.kind, VariableKind::normal_load);
    EXPECT_LT(condition(space), 1e8);
    bool said = false;
    for (const std::string& words : space.notes)
        said |= words.find("5 of 20 directions move the surface by less than") != std::string::npos &&
                words.find(".load_normal does what ") != std::string::npos;
    EXPECT_TRUE(said);
}

TEST(NullDirections, NothingIsDependentInAnOrdinarySpace) {
    for (const auto& kinds : std::vector<std::vector<VariableKind>>{
             {VariableKind::load}, {VariableKind::load, VariableKind::normal_load}, {VariableKind::strain}}) {
        Problem problem = ellipsoid_problem(2, 3);
        problem.parameters.kinds = kinds;
        EXPECT_TRUE(design_space(rest_facts(problem), 3).dependent.empty());
    }
}

TEST(NullDirections, ARepeatedVariableChangesNeitherConditionNorVerdictNorOptimum) {
    const DesignSpace alone = design_space(rest_facts(more_volume(false)), 1),
                      twice = design_space(rest_facts(more_volume(true)), 1);
    EXPECT_EQ(twice.size(), alone.size());
    EXPECT_LT(condition(twice), 2 * condition(alone));
    const auto run = [](bool repeats) {
        Problem problem = more_volume(repeats);
        problem.parameters.max_displacement = 0.02;  // farther, the search ends beside buckling
        return optimize(problem);
    };
    const RunResult a = run(false), b = run(true);
    EXPECT_EQ(a.status, "converged") << a.reason;
    EXPECT_EQ(b.status, a.status) << b.reason;
    EXPECT_NEAR(b.objective, a.objective, 1e-4 * a.objective);
    for (const LevelSummary& level : b.levels) {
        EXPECT_LT(level.inherited_shape_change, 1e-10);
        EXPECT_EQ(level.dependent.size(), 1u);
    }
}

TEST(NullDirections, RefiningKeepsTheShapeWhereTheChildrenLeaveSomethingOut) {
    Problem problem = more_volume(true);
    const auto rest = rest_facts(problem);
    const DesignSpace parent = design_space(rest, 1);
    const Eigen::VectorXd x = 0.3 * random_vector(parent.size(), 8);
    const InheritedSpace child = refine(parent, x);
    ASSERT_EQ(child.space.dependent.size(), 1u);
    const Points before = demand(parent, x).loads.force, after = demand(child.space, child.x).loads.force;
    EXPECT_LT((after - before).cwiseAbs().maxCoeff(), 1e-12 * before.cwiseAbs().maxCoeff());
    // Every direction of the parent is still there.
    const Eigen::MatrixXd above = responses_at_rest(parent).samples, below = responses_at_rest(child.space).samples;
    EXPECT_LT((below * child.prolongation - above).norm(), 1e-6 * above.norm());
}

TEST(NullDirections, APatchThatIsNearlyFixedSpoilsNeitherConditionNorVerdict) {
    Problem problem = more_volume(false, 3);
    // All of a quadrant but one interior vertex.
    const Patch& patch = problem.tree.levels[2].patches[3];
    std::vector<char> inside(problem.surface.num_vertices(), 1);
    for (int t = 0; t < problem.surface.num_triangles(); ++t)
        for (int k = 0; problem.tree.levels[2].label[t] != patch.id && k < 3; ++k)
            inside[problem.surface.triangles(t, k)] = 0;
    const auto free_vertex = std::find(inside.begin(), inside.end(), 1);
    ASSERT_NE(free_vertex, inside.end());
    const int v = static_cast<int>(free_vertex - inside.begin());
    for (const int t : patch.triangles) {
        const Eigen::Vector3i at = problem.surface.triangles.row(t);
        if (at[0] != v && at[1] != v && at[2] != v) problem.fixed.push_back(t);
    }
    const DesignSpace space = design_space(rest_facts(problem), 2);
    EXPECT_LT(condition(space), 1e6);
    ASSERT_EQ(space.nearly_fixed, std::vector<std::string>{patch.name});
    bool said = false;
    for (const std::string& words : space.notes)
        said |= words.find("of its area is held; its variables move what is left") != std::string::npos;
    EXPECT_TRUE(said);
    const RunResult r = optimize(problem);
    EXPECT_EQ(r.status, "converged") << r.reason;
    for (const LevelSummary& level : r.levels) EXPECT_LT(level.inherited_shape_change, 1e-10);
}
