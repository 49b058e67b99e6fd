#include "optimize/space/design_space.hpp"

#include "core/error.hpp"
#include "optimize/evaluate/evaluation.hpp"
#include "problems.hpp"

#include <gtest/gtest.h>

using namespace strake;

namespace {

struct Evaluated {
    Problem problem;
    std::shared_ptr<const RestFacts> rest;
    ShapeEvaluator evaluator;
    DesignSpace space;
    explicit Evaluated(Problem p, int level = 1)
        : problem(std::move(p)),
          rest(rest_facts(problem)),
          evaluator(problem, rest, {"volume", "area"}),
          space(design_space(rest, level)) {
        evaluator.enter(space);
    }
    ShapeEvaluation at(const Eigen::VectorXd& x) {
        ShapeEvaluation e = evaluator.evaluate(x, 1);
        EXPECT_EQ(e.status, EvaluationStatus::ok) << e.reason;
        return e;
    }
};

Problem with_kinds(std::vector<VariableKind> kinds, int levels = 2) {
    Problem problem = ellipsoid_problem(2, levels);
    problem.parameters.kinds = std::move(kinds);
    return problem;
}

/// A start at which every kind has an effect, away from x = 0.
Eigen::VectorXd deformed_start(const DesignSpace& space) { return 0.4 * random_vector(space.size(), 3); }

void expect_second_order(Problem problem) {
    // A background load makes prism heights matter.
    problem.given_traction = Points::Zero(problem.surface.num_triangles(), 3);
    problem.given_traction.col(2).setConstant(1e-4);
    Evaluated e(std::move(problem));
    ASSERT_GT(e.space.size(), 0);
    const Eigen::VectorXd x = deformed_start(e.space), p = random_vector(e.space.size(), 5);
    ShapeEvaluation here = e.at(x);
    e.evaluator.differentiate(here);
    for (int i = 0; i < 2; ++i) {
        const auto J = [&](const Eigen::VectorXd& y) { return e.at(y).values[i]; };
        const Eigen::VectorXd g = here.gradients.row(i);
        EXPECT_NEAR(taylor_order(J, x, g, p, 3e-2), 2, 0.15) << e.evaluator.names()[i];
        EXPECT_NEAR(taylor_order(J, x, 1.1 * g, p, 3e-2), 1, 0.15) << e.evaluator.names()[i];
    }
}

}  // namespace

TEST(DesignSpace, LoadGradientsAreExact) { expect_second_order(with_kinds({VariableKind::load})); }
TEST(DesignSpace, NormalLoadGradientsAreExact) { expect_second_order(with_kinds({VariableKind::normal_load})); }
TEST(DesignSpace, StrainGradientsAreExact) { expect_second_order(with_kinds({VariableKind::strain})); }
TEST(DesignSpace, StiffnessGradientsAreExact) {
    expect_second_order(with_kinds({VariableKind::load, VariableKind::stiffness}));
}

TEST(DesignSpace, UnitsMoveTheSurfaceByMaxDisplacement) {
    Problem problem = with_kinds({VariableKind::load});
    problem.parameters.max_displacement = 1e-6;  // so small that the response is linear
    Evaluated e(problem);
    for (int j = 0; j < e.space.size(); ++j) {
        const ShapeEvaluation moved = e.at(Eigen::VectorXd::Unit(e.space.size(), j));
        EXPECT_NEAR(moved.max_displacement, 1e-6 * e.rest->diagonal, 1e-9 * e.rest->diagonal) << j;
    }
}

TEST(DesignSpace, UnitOfLengthDoesNotMatter) {
    Problem mm = ellipsoid_problem(2, 2, 1000);
    Evaluated small(ellipsoid_problem(2, 2)), large(mm);
    const Eigen::VectorXd x = deformed_start(small.space);
    EXPECT_LT((1000 * small.at(x).vertices - large.at(x).vertices).cwiseAbs().maxCoeff(), 1e-9 * large.rest->diagonal);
}

TEST(DesignSpace, ChildrenInheritTheShape) {
    for (const auto& kinds : std::vector<std::vector<VariableKind>>{
             {VariableKind::load},
             {VariableKind::normal_load},
             {VariableKind::strain},
             {VariableKind::load, VariableKind::stiffness},
             {VariableKind::load, VariableKind::normal_load, VariableKind::strain, VariableKind::stiffness}}) {
        Evaluated e(with_kinds(kinds, 3));
        const Eigen::VectorXd x = deformed_start(e.space);
        ShapeEvaluation before = e.at(x);
        e.evaluator.accept();
        DesignSpace space = e.space;
        Eigen::VectorXd y = x;
        for (int level = 2; level <= 3; ++level) {
            InheritedSpace child = refine(space, y);
            EXPECT_GT(child.space.size(), space.size());
            e.evaluator.enter(child.space);
            const ShapeEvaluation after = e.at(child.x);
            EXPECT_LT((after.vertices - before.vertices).cwiseAbs().maxCoeff(), 1e-10 * e.rest->diagonal);
            EXPECT_NEAR(after.values[0], before.values[0], 1e-10 * before.values[0]);
            EXPECT_TRUE((child.x.array() >= child.space.lower.array()).all());
            EXPECT_TRUE((child.x.array() <= child.space.upper.array()).all());
            space = child.space;
            y = child.x;
        }
    }
}

TEST(DesignSpace, InheritedTractionIsTheSameWhereAChildHasNoVariables) {
    Problem problem = with_kinds({VariableKind::load});
    problem.parameters.variables_on.assign(problem.surface.num_triangles(), 0);
    const Points c = triangle_centroids(problem.surface);
    for (int t = 0; t < problem.surface.num_triangles(); ++t)
        problem.parameters.variables_on[t] = c(t, 0) > 0 && c(t, 1) > 0;
    const auto rest = rest_facts(problem);
    const DesignSpace parent = design_space(rest, 1);
    EXPECT_EQ(parent.size(), 3);  // only the half that holds triangles that are on
    const Eigen::VectorXd x = random_vector(3, 4);
    const InheritedSpace child = refine(parent, x);
    EXPECT_EQ(child.space.size(), 3);
    const Points before = demand(parent, x).loads.force, after = demand(child.space, child.x).loads.force;
    EXPECT_LT((before - after).cwiseAbs().maxCoeff(), 1e-14 * before.cwiseAbs().maxCoeff());
}

TEST(DesignSpace, HeldPatchesCarryNoVariables) {
    Problem problem = with_kinds({VariableKind::load});
    const Points c = triangle_centroids(problem.surface);
    problem.fixed.clear();
    for (int t = 0; t < problem.surface.num_triangles(); ++t)
        if (c(t, 0) <= 1e-9) problem.fixed.push_back(t);
    const DesignSpace space = design_space(rest_facts(problem), 1);
    EXPECT_EQ(space.size(), 3);
    EXPECT_EQ(space.notes.size(), 1u);
    EXPECT_EQ(space.variables[0].name, space.patches().patches[space.variables[0].patch].name + ".load_x");
}

TEST(DesignSpace, StrainCoresStayOffTheBorders) {
    const Problem problem = with_kinds({VariableKind::strain}, 2);
    const auto rest = rest_facts(problem);
    const DesignSpace parent = design_space(rest, 1);
    const InheritedSpace child = refine(parent, Eigen::VectorXd::Zero(parent.size()));
    int pinned = 0;
    for (std::size_t p = 0; p < parent.core.size(); ++p) {
        EXPECT_FALSE(parent.core[p].empty());
        EXPECT_LT(parent.core[p].size(), parent.patches().patches[p].triangles.size());
        pinned += static_cast<int>(parent.core[p].size());
    }
    for (const auto& core : child.space.core) pinned -= static_cast<int>(core.size());
    EXPECT_EQ(pinned, 0);  // children share out their parents' cores, nothing more, nothing less
}

TEST(DesignSpace, StrainThatLeavesNoFreePrismIsRefused) {
    Problem problem = ellipsoid_problem(1, 0);
    problem.fixed.clear();
    problem.parameters.kinds = {VariableKind::strain};
    EXPECT_THROW(design_space(rest_facts(problem), 0), InvalidInput);
}

TEST(ShellSetup, FixedWinsOverStrainAndTwoStrainsClash) {
    Problem problem = ellipsoid_problem(1, 1);
    problem.strains = {{{problem.fixed[0], 1, 2}, {}}};
    const ShellSetup setup = shell_setup(problem);
    EXPECT_EQ(setup.options.pin[problem.fixed[0]], fixed_prism);
    EXPECT_EQ(setup.options.pin[1], 1);
    EXPECT_EQ(setup.warnings.size(), 1u);
    problem.strains.push_back({{2}, {}});
    EXPECT_THROW(shell_setup(problem), InvalidInput);
    problem.strains = {{{100000}, {}}};
    EXPECT_THROW(shell_setup(problem), InvalidInput);
}
