#include "core/fields/displacement_fields.hpp"
#include "optimize/run/coarse_to_fine.hpp"
#include "problems.hpp"

#include <gtest/gtest.h>

using namespace strake;

namespace {

/// Fields first, then fields and patches to choose from; an objective that gives its values only.
Problem by_values(const std::function<Points(const Problem&)>& target) {
    Problem problem = ellipsoid_problem(2, 3);
    problem.parameters.kinds = {VariableKind::normal_load};
    problem.parameters.max_displacement = 0.1;
    problem.parameters.split = SplitRule::sensitivity;
    FieldConditions conditions;
    conditions.held = problem.fixed;
    add_fields(problem.parameters,
               std::make_shared<const DisplacementFields>(problem.surface, conditions, FieldOptions{27, {}}));
    problem.parameters.field_steps = {12, 27};
    problem.quantities = {target_shape_same("match", problem.surface, with_vertices(problem.surface, target(problem)))};
    problem.quantities[0].has_sensitivities = false;
    problem.quantities[0].residuals = nullptr;
    problem.objective = problem.quantities[0].names[0];
    problem.maximize = false;
    problem.constraints.clear();
    problem.optimize.finite_differences = true;
    problem.optimize.max_evaluations = 300;
    return problem;
}

struct Seen {
    RunResult result;
    std::vector<std::vector<int>> fields;  ///< numbers, per level
    std::vector<int> loads, evaluations;
    std::vector<std::string> notes;
    std::vector<std::pair<int, std::string>> choices;  ///< loads of the level before, and what was said
};

Seen run(const Problem& problem) {
    Seen seen;
    RunEvents events;
    events.level = [&](const LevelStart& level) {
        seen.fields.push_back(level.space.fields.numbers);
        seen.loads.push_back(static_cast<int>(std::ranges::count_if(
            level.space.variables, [](const Variable& v) { return v.kind == VariableKind::normal_load; })));
    };
    events.level_end = [&](const LevelSummary& level) { seen.evaluations.push_back(level.evaluations); };
    events.note = [&](const std::string& words) {
        seen.notes.push_back(words);
        if (words.starts_with("choice by")) seen.choices.emplace_back(seen.loads[seen.loads.size() - 2], words);
    };
    seen.result = optimize(problem, events);
    return seen;
}

std::string choice_of(const Seen& seen) {
    for (const std::string& words : seen.notes)
        if (words.starts_with("choice by")) return words;
    return "";
}

/// What patches can do and coarse fields cannot: a dent in one place.
Points dented(const Problem& problem) {
    Points target = problem.surface.vertices;
    const Box box = bounding_box(problem.surface);
    const Eigen::RowVector3d at(0.5 * (box.min[0] + box.max[0]), box.max[1], 0);
    for (int v = 0; v < problem.surface.num_vertices(); ++v) {
        const double d =
            (problem.surface.vertices.row(v) - at).squaredNorm() / std::pow(0.2 * (box.max[0] - box.min[0]), 2);
        target(v, 1) -= 0.05 * (box.max[0] - box.min[0]) * std::exp(-d);
    }
    return target;
}

}  // namespace

TEST(ValueTrial, TakesTheFieldsThatATargetNeeds) {
    const Seen seen = run(by_values([](const Problem& p) {
        return Points(p.surface.vertices + 0.03 * p.parameters.fields->field(18) +
                      0.03 * p.parameters.fields->field(3));
    }));
    ASSERT_GT(seen.fields.size(), 2u) << seen.result.reason;
    EXPECT_EQ(seen.fields[0].size(), 12u);
    EXPECT_EQ(seen.loads[0], 0);
    // Its start, six directions for the fields that are there, finer ones and patches, and a value for the curvature
    // along each six.
    EXPECT_EQ(seen.evaluations[1], 1 + 3 * (6 + 1)) << "a level of its own that tries";
    EXPECT_EQ(seen.fields[2].size(), 27u) << choice_of(seen);
    EXPECT_EQ(seen.loads[2], 0) << choice_of(seen);
    EXPECT_NE(choice_of(seen).find("fields become finer, patches wait"), std::string::npos) << choice_of(seen);
    EXPECT_LT(seen.result.objective, 1e-3 * seen.result.objective_start) << seen.result.reason;
}

TEST(ValueTrial, EveryLevelGoesOnFromWhereTheOneBeforeEnded) {
    const Seen seen = run(by_values(dented));
    ASSERT_GT(seen.fields.size(), 2u) << seen.result.reason;
    EXPECT_GT(*std::ranges::max_element(seen.loads), 0) << choice_of(seen);
    for (std::size_t k = 1; k < seen.result.levels.size(); ++k) {
        EXPECT_LT(seen.result.levels[k].inherited_shape_change, 1e-10) << k;
        EXPECT_LE(seen.result.levels[k].objective_end, seen.result.levels[k - 1].objective_end) << k;
        EXPECT_GT(seen.result.levels[k].level, seen.result.levels[k - 1].level);
    }
    const Seen again = run(by_values(dented));
    EXPECT_EQ(seen.result.objective, again.result.objective) << "the same input, the same bits";
}

/// Fields of which there are no further ones are offered no more: what rounding leaves of them is no direction.
TEST(ValueTrial, AGroupThatIsThereToItsEndIsNotOfferedAgain) {
    Problem problem = by_values(dented);
    problem.parameters.field_steps = {27};
    const Seen seen = run(problem);
    const std::string first = choice_of(seen);
    EXPECT_NE(first.find("fields 0 for each of 0 (those there "), std::string::npos) << first;
    EXPECT_EQ(first.find("patches 0 for each of 0"), std::string::npos) << "these are offered: " << first;
    EXPECT_EQ(seen.evaluations[1], 1 + 2 * (6 + 1)) << "the fields that are there, and patches";
}

TEST(ValueTrial, ATightBudgetIsNotTried) {
    Problem problem = by_values(dented);
    problem.optimize.max_evaluations = 40;
    const Seen seen = run(problem);
    EXPECT_LE(seen.result.evaluations, 40);
    EXPECT_EQ(choice_of(seen), "");
}
