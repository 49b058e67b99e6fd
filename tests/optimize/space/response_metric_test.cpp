#include "optimize/space/response_metric.hpp"

#include "problems.hpp"

#include <gtest/gtest.h>

using namespace strake;

namespace {

/// One variable that loads these patches along their normals, with the name that such a group gets.
Variable group_of(const DesignSpace& space, const std::vector<int>& patches) {
    Variable variable;
    const auto& all = space.patches().patches;
    variable.name = all[patches[0]].name + "+" + all[patches[1]].name + "+" + std::to_string(patches.size() - 2) +
                    "more.load_normal";
    variable.kind = VariableKind::normal_load;
    variable.patch = patches[0];
    for (const int p : patches) variable.moves.push_back({p * patch_dof::count + patch_dof::normal, 1.0});
    return variable;
}

Responses responses_of(DesignSpace space, const std::vector<int>& patches) {
    space.variables = {group_of(space, patches)};
    return responses_at_rest(space);
}

}  // namespace

/// Two groups of four patches share their first two members and their name, but not the others.
TEST(ResponseMetric, AGroupWithOtherMembersHasItsOwnResponse) {
    Problem problem = ellipsoid_problem(2, 3);
    problem.parameters.kinds = {VariableKind::normal_load};
    const auto rest = rest_facts(problem), other = rest_facts(problem);
    const DesignSpace space = design_space(rest, 3), untouched = design_space(other, 3);
    const std::vector<int> first{0, 1, 2, 3}, second{0, 1, 4, 7};
    ASSERT_EQ(group_of(space, first).name, group_of(space, second).name);
    const Responses of_first = responses_of(space, first), of_second = responses_of(space, second);
    const Responses alone = responses_of(untouched, second);
    EXPECT_EQ(of_second.largest[0], alone.largest[0]);
    EXPECT_EQ(of_second.samples, alone.samples);
    EXPECT_GT((of_second.samples - of_first.samples).norm(), 1e-3 * of_first.samples.norm());
}
