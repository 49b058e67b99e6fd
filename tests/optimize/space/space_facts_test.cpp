#include "optimize/space/space_facts.hpp"

#include "optimize/check/start_check.hpp"
#include "tests/optimize/problems.hpp"

#include <gtest/gtest.h>

namespace strake {
namespace {

Problem normal_problem() {
    Problem problem = ellipsoid_problem(2, 1);
    problem.parameters.kinds = {VariableKind::normal_load};
    problem.parameters.max_displacement = 0.03;
    problem.objective = "volume";
    return problem;
}

TEST(SpaceFacts, ModesHaveTheSizeOfAVariableAndHeldVerticesAreStill) {
    const Problem problem = normal_problem();
    const DesignSpace space = design_space(rest_facts(problem), 1);
    int modes = 0;
    const SpaceFacts facts = space_facts(space, [&](const Variable& variable, const Points& dv) {
        EXPECT_EQ(variable.name, space.variables[static_cast<std::size_t>(modes++)].name);
        EXPECT_NEAR(dv.rowwise().norm().maxCoeff(), 0.03 * box_diagonal(problem.surface), 1e-9);
    });
    EXPECT_EQ(modes, 2);
    EXPECT_EQ(facts.names.size(), 2u);
    EXPECT_GE(facts.condition, 1);
    EXPECT_LT(facts.condition, 1e6);
    std::vector<char> is_held(facts.moves.size(), 0);
    for (const int t : problem.fixed)
        for (int k = 0; k < 3; ++k) is_held[static_cast<std::size_t>(problem.surface.triangles(t, k))] = 1;
    for (std::size_t v = 0; v < is_held.size(); ++v) EXPECT_NE(facts.moves[v], is_held[v]) << v;
}

TEST(SpaceFacts, VariablesThatDoTheSameAreNamed) {
    Problem problem = normal_problem();
    problem.parameters.kinds = {VariableKind::normal_load, VariableKind::stiffness};
    UserVariable twice;  // what the first patch does already
    twice.name = "twice";
    const DesignSpace single = design_space(rest_facts(normal_problem()), 1);
    twice.triangles = single.patches().patches[1].triangles;
    twice.traction = Points(static_cast<Eigen::Index>(twice.triangles.size()), 3);
    for (std::size_t i = 0; i < twice.triangles.size(); ++i)
        twice.traction.row(static_cast<Eigen::Index>(i)) = single.rest->normal.row(twice.triangles[i]);
    problem.parameters.user_variables = {twice};
    const SpaceFacts facts = space_facts(design_space(rest_facts(problem), 1));
    EXPECT_EQ(facts.dependent.size(), 1u);
    EXPECT_FALSE(facts.notes.empty());
    EXPECT_TRUE(facts.changes_height);
}

TEST(SpaceFacts, TheStartIsKnownButForPrograms) {
    Problem problem = normal_problem();
    Quantity program;
    program.names = {"cfd"};
    program.program = "cfd.sh";
    program.evaluate = [](const QuantityRequest&) -> QuantityResult {
        ADD_FAILURE() << "the program was asked";
        return {};
    };
    problem.quantities.push_back(program);
    Quantity ratio, other;
    ratio.names = {"ratio"};
    ratio.combination = Combination{{"volume", "area"}, [](const Eigen::VectorXd& v, Eigen::VectorXd* gradient) {
                                        if (gradient) *gradient = Eigen::Vector2d(1 / v[1], -v[0] / (v[1] * v[1]));
                                        return v[0] / v[1];
                                    }};
    other = ratio;
    other.names = {"other"};
    other.combination->of = {"cfd", "area"};
    problem.quantities.push_back(ratio);
    problem.quantities.push_back(other);
    problem.constraints = {{"area", {}, 0.9, {}, true}, {"cfd", 1.0, {}, {}, false}, {"ratio", 0.0, {}, {}, false}};
    const Problem free = without_programs(problem);
    ASSERT_EQ(free.quantities.size(), 3u);
    ASSERT_EQ(free.constraints.size(), 2u);
    const auto rest = rest_facts(problem);
    const StartAnswer start = check_start(free, rest, design_space(rest, 1));
    EXPECT_EQ(start.status, "ok") << start.reason;
    ASSERT_EQ(start.constraints.size(), 2u);
    EXPECT_GT(start.constraints[0].scaled, 0.01);   // area <= 0.9 of itself
    EXPECT_LT(start.constraints[1].scaled, 1e-12);  // ratio >= 0
}

}  // namespace
}  // namespace strake
