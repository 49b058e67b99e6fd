#include "core/fields/displacement_fields.hpp"
#include "evaluated.hpp"
#include "optimize/run/method_choice.hpp"
#include "optimize/space/field_conditions.hpp"
#include "optimize/space/refinement.hpp"
#include "problems.hpp"

#include <gtest/gtest.h>

using namespace strake;

namespace {

/// An ellipsoid in octants, whose target is made by loads on some of them.
struct SinglePatches {
    Problem problem;
    std::shared_ptr<const RestFacts> rest;

    /// @param is_loaded by the centre of the octant
    explicit SinglePatches(const std::function<bool(const Eigen::RowVector3d&)>& is_loaded, bool mirror = false,
                           int fields = 12)
        : problem(without_fields(mirror)) {
        const auto alone = rest_facts(problem);
        const DesignSpace octants = design_space(alone, 3);
        ShapeEvaluator evaluator(problem, alone, {});
        evaluator.enter(octants);
        const Points centre = triangle_centroids(problem.surface);
        Eigen::VectorXd x = Eigen::VectorXd::Zero(octants.size());
        for (int j = 0; j < octants.size(); ++j) {
            Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
            for (const int t : octants.patches().patches[octants.variables[j].patch].triangles) sum += centre.row(t);
            if (is_loaded(sum)) x[j] = 0.02 * octants.variables[0].unit / octants.variables[j].unit;
        }
        const ShapeEvaluation wanted = evaluator.evaluate(x, 1);
        problem.quantities = {
            target_shape_same("match", problem.surface, with_vertices(problem.surface, wanted.vertices))};
        problem.objective = "match";
        add_fields(problem.parameters, std::make_shared<const DisplacementFields>(
                                           problem.surface, field_conditions(problem), FieldOptions{fields, {}}));
        problem.parameters.field_steps = {4, fields};
        problem.parameters.split = SplitRule::sensitivity;
        problem.parameters.max_variable_ratio = 8;
        rest = rest_facts(problem, energy_share(problem), takes_single_patches(problem));
    }

    RefinementPlan plan(const DesignSpace& space, const Eigen::VectorXd& x) const {
        ShapeEvaluator evaluator(problem, rest, {"match"});
        evaluator.enter(space);
        ShapeEvaluation e = evaluator.evaluate(x, 1);
        EXPECT_EQ(e.status, EvaluationStatus::ok) << e.reason;
        evaluator.differentiate(e);
        const DesignFacts facts{space, x, e.sensitivities[0], 2, e.dJ_dv[0]};
        const auto forecast = make_forecast(facts);
        EXPECT_TRUE(forecast);
        const auto by_themselves = make_forecast(facts, 2);
        EXPECT_TRUE(by_themselves);
        EXPECT_TRUE(std::ranges::all_of(by_themselves->below.splits, [](const auto& s) { return s.field < 0; }));
        EXPECT_FALSE(make_forecast(facts, 3)) << "parts of all depths are in the first";
        return plan_refinement(facts, *forecast, 1e-2 * forecast->decrease);
    }

private:
    static Problem without_fields(bool mirror) {
        Problem problem = ellipsoid_problem(3, 3);
        const Points centre = triangle_centroids(problem.surface);  // held all along the bottom
        problem.fixed.clear();
        for (int t = 0; t < problem.surface.num_triangles(); ++t)
            if (centre(t, 2) < -0.05) problem.fixed.push_back(t);
        problem.parameters.kinds = {VariableKind::normal_load};
        problem.parameters.mirror = mirror;
        return problem;
    }
};

std::vector<std::string> patches_with_variables(const DesignSpace& space) {
    std::vector<std::string> names;
    for (const Variable& v : space.variables)
        if (v.patch >= 0) names.push_back(v.name);
    return names;
}

/// The child demands of every triangle what the parent does.
void expect_inherited(const DesignSpace& parent, const Eigen::VectorXd& x, const InheritedSpace& child) {
    const ShellDemand above = demand(parent, x), below = demand(child.space, child.x);
    EXPECT_LT((above.loads.force - below.loads.force).norm(), 1e-12 * (1e-300 + above.loads.force.norm()));
    EXPECT_LT((above.fields - below.fields).norm(), 1e-12 * (1e-300 + above.fields.norm()));
}

}  // namespace

TEST(SinglePatches, OneOctantIsTakenAndThoseBesideItRest) {
    const SinglePatches bump([](const Eigen::RowVector3d& c) { return c[0] > 0 && c[1] > 0 && c[2] > 0; });
    const DesignSpace fields = design_space(bump.rest, 0);
    const Eigen::VectorXd x = 0.01 * random_vector(fields.size(), 3);
    const RefinementPlan plan = bump.plan(fields, x);
    ASSERT_FALSE(plan.splits.empty());
    EXPECT_NE(plan.words().find("gives variables to 1 patch of "), std::string::npos) << plan.words();
    const InheritedSpace next = refine(fields, x, plan.next);
    EXPECT_EQ(next.space.size(), plan.variables_after);
    EXPECT_EQ(patches_with_variables(next.space).size(), 1u);
    // The octant, the one beside it, the other quadrant, the other half.
    ASSERT_EQ(next.space.patches().patches.size(), 4u);
    EXPECT_EQ(std::ranges::count(next.space.resting, 1), 3);
    const Points centre = triangle_centroids(bump.problem.surface);
    for (const Patch& patch : next.space.patches().patches)
        if (next.space.has_variables(patch.id)) {
            for (const int t : patch.triangles) EXPECT_TRUE(centre(t, 0) > 0 && centre(t, 1) > 0 && centre(t, 2) > 0);
        }
    expect_inherited(fields, x, next);
}

/// Its octants could do the same, at four variables for one.
TEST(SinglePatches, OfPatchesOfAllDepthsTheLargestGainForEachVariableIsTaken) {
    const SinglePatches swell([](const Eigen::RowVector3d& c) { return c[0] > 0; });
    const DesignSpace fields = design_space(swell.rest, 0);
    const Eigen::VectorXd x = Eigen::VectorXd::Zero(fields.size());
    const InheritedSpace next = refine(fields, x, swell.plan(fields, x).next);
    EXPECT_EQ(patches_with_variables(next.space).size(), 1u);
    EXPECT_EQ(next.space.patches().patches.size(), 2u) << "two halves, one of them at rest";
    EXPECT_EQ(std::ranges::count(next.space.resting, 1), 1);
}

/// What has variables is split as it always was, what rests is taken beside it, and nothing is lost.
TEST(SinglePatches, GoOnWithThoseThatRestedAndSplitTheOthers) {
    const SinglePatches two([](const Eigen::RowVector3d& c) { return c[2] > 0 && c[1] > 0; });
    const DesignSpace fields = design_space(two.rest, 0);
    const Eigen::VectorXd none = Eigen::VectorXd::Zero(fields.size());
    // Half of the body has variables, the other rests.
    LevelSet set = level_set_of(refine(fields, none, level_set(*two.rest, 1)).space);
    ASSERT_EQ(set.front.depth.size(), 2u);
    set.resting = {0, 1};
    const InheritedSpace half = refine(fields, none, set);
    ASSERT_EQ(patches_with_variables(half.space).size(), 1u);
    const Eigen::VectorXd x = 0.01 * random_vector(half.space.size(), 5);
    const RefinementPlan plan = two.plan(half.space, x);
    int splits = 0, takes = 0;
    for (const SplitDecrease& split : plan.splits)
        if (split.chosen && split.field < 0) ++(split.patches.empty() ? takes : splits);
    EXPECT_EQ(splits, 1) << plan.words();
    EXPECT_GE(takes, 1) << plan.words();
    const InheritedSpace next = refine(half.space, x, plan.next);
    EXPECT_EQ(next.space.size(), plan.variables_after);
    expect_inherited(half.space, x, next);
    for (const Patch& patch : next.space.patches().patches)
        EXPECT_TRUE(patch.parent != 0 || next.space.has_variables(patch.id)) << "parts of what had variables";
    // What the half could do, its parts can.
    const Eigen::VectorXd step = random_vector(half.space.size(), 6);
    const ShellDemand above = demand(half.space, x + step),
                      below = demand(next.space, next.x + next.prolongation * step);
    EXPECT_LT((above.loads.force - below.loads.force).norm(), 1e-9 * above.loads.force.norm());
}

TEST(SinglePatches, MirrorImagesAreTakenTogether) {
    const SinglePatches pair([](const Eigen::RowVector3d& c) { return c[0] > 0 && c[2] > 0; }, true, 5);
    ASSERT_TRUE(pair.rest->mirror);
    const DesignSpace fields = design_space(pair.rest, 0);
    const Eigen::VectorXd x = Eigen::VectorXd::Zero(fields.size());
    const RefinementPlan plan = pair.plan(fields, x);
    const InheritedSpace next = refine(fields, x, plan.next);
    EXPECT_EQ(next.space.size(), plan.variables_after);
    ASSERT_GE(patches_with_variables(next.space).size(), 1u) << plan.words();
    for (const Variable& v : next.space.variables)
        for (const DegreeOfFreedom& move : v.moves)
            EXPECT_TRUE(v.patch < 0 || next.space.has_variables(move.index / patch_dof::count)) << v.name;
}

/// By gradients alone, of loads alone, and where the run chooses.
TEST(SinglePatches, AreForRunsThatKnowWhatTheyTake) {
    const SinglePatches bump([](const Eigen::RowVector3d& c) { return c[0] > 0; });
    EXPECT_TRUE(takes_single_patches(bump.problem));
    const auto without = [&](const std::function<void(Problem&)>& change) {
        Problem other = bump.problem;
        change(other);
        return !takes_single_patches(other);
    };
    EXPECT_TRUE(without([](Problem& p) { p.parameters.fields.reset(); }));
    EXPECT_TRUE(without([](Problem& p) { p.parameters.split = SplitRule::tree; }));
    EXPECT_TRUE(without([](Problem& p) { p.parameters.split = SplitRule::gradient; }));
    EXPECT_TRUE(without([](Problem& p) { p.parameters.kinds.push_back(VariableKind::strain); }));
    EXPECT_TRUE(without([](Problem& p) { p.parameters.kinds = {VariableKind::stiffness}; }));
    EXPECT_TRUE(without([](Problem& p) { p.parameters.kinds.clear(); }));
    EXPECT_TRUE(without([](Problem& p) { p.optimize.method = Method::model; }));
    EXPECT_TRUE(without([](Problem& p) { p.optimize.refines_whole_fronts = true; }));
}

/// And from its stored design another run: what rested there rests here.
TEST(SinglePatches, ARunTakesThemAndIsStoredWithThem) {
    const SinglePatches bump([](const Eigen::RowVector3d& c) { return c[0] > 0 && c[1] > 0 && c[2] > 0; });
    Problem problem = bump.problem;
    problem.optimize.max_evaluations = 20;
    std::optional<StoredDesign> best;
    bool has_resting = false;
    RunEvents events;
    events.accepted = [&](const AcceptedDesign& design) { best = stored_design(design); };
    events.level = [&](const LevelStart& level) {
        has_resting |= level.space.has_patches && std::ranges::count(level.space.resting, 1) > 0;
    };
    const RunResult single = optimize(problem, events);
    EXPECT_TRUE(has_resting);
    EXPECT_LT(single.objective, 1e-3 * single.objective_start) << single.reason;
    has_resting = false;
    problem.optimize.refines_whole_fronts = true;
    optimize(problem, events);
    EXPECT_FALSE(has_resting) << "as in earlier runs";

    problem.optimize.refines_whole_fronts = false;
    optimize(problem, events);
    ASSERT_TRUE(best);
    problem.optimize.max_evaluations = 3;
    start_from(problem, std::make_shared<const StoredDesign>(*best));
    int variables = 0;
    RunEvents again;
    again.level = [&](const LevelStart& level) {
        if (variables == 0) variables = static_cast<int>(patches_with_variables(level.space).size());
    };
    const RunResult more = optimize(problem, again);
    EXPECT_EQ(variables, static_cast<int>(patches_with_variables(single.space).size()));
    EXPECT_LE(more.objective, single.objective * (1 + 1e-6) + 1e-12 * single.objective_start) << more.reason;
}
