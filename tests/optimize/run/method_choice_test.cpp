#include "optimize/run/method_choice.hpp"

#include "core/fields/displacement_fields.hpp"
#include "optimize/evaluate/evaluation.hpp"
#include "optimize/run/coarse_to_fine.hpp"
#include "optimize/space/field_conditions.hpp"
#include "problems.hpp"

#include <gtest/gtest.h>

using namespace strake;

namespace {

/// Most volume at the area of the start, by fields and patches.
Problem fields_and_patches() {
    Problem problem = ellipsoid_problem(3, 3);
    const Points centre = triangle_centroids(problem.surface);  // held all along the bottom: what is done stays there
    problem.fixed.clear();
    for (int t = 0; t < problem.surface.num_triangles(); ++t)
        if (centre(t, 2) < -0.05) problem.fixed.push_back(t);
    add_fields(problem.parameters, std::make_shared<const DisplacementFields>(
                                       problem.surface, field_conditions(problem), FieldOptions{27, {}}));
    problem.parameters.field_steps = {12, 27};
    problem.parameters.kinds = {VariableKind::normal_load};
    problem.parameters.split = SplitRule::sensitivity;
    maximize_volume(problem, 1.0);
    return problem;
}

}  // namespace

TEST(MethodChoice, BesideFieldsAShareOfTheEnergyCountsWhereGradientsAreKnown) {
    const Problem problem = fields_and_patches();
    EXPECT_EQ(energy_share(problem), energy_beside_fields);
    Problem other = problem;
    other.optimize.method = Method::model;
    EXPECT_EQ(energy_share(other), 1) << "values alone";
    other = problem;
    other.quantities[0].has_sensitivities = false;
    other.optimize.finite_differences = true;
    EXPECT_EQ(energy_share(other), 1) << "differences";
    other = problem;
    other.parameters.fields.reset();
    EXPECT_EQ(energy_share(other), 1) << "patches alone";
    other = problem;
    other.optimize.counts_whole_energy = true;
    EXPECT_EQ(energy_share(other), 1) << "as in earlier runs";
}

/// A load on one octant, which fields cannot stand for: were patches as dear as by their whole energy, they would
/// hardly be taken.
TEST(MethodChoice, PatchesJoinFieldsForWhatTheseCannotDo) {
    Problem problem = fields_and_patches();
    problem.constraints.clear();
    Problem by_patches = problem;
    by_patches.parameters.fields.reset();
    by_patches.parameters.user_variables.clear(), by_patches.parameters.field_steps.clear();
    const auto rest = rest_facts(by_patches);
    ShapeEvaluator evaluator(by_patches, rest, {});
    const DesignSpace octants = design_space(rest, 3);
    evaluator.enter(octants);
    const ShapeEvaluation wanted =
        evaluator.evaluate(0.5 * Eigen::VectorXd::Unit(octants.size(), octants.size() - 1), 1);
    problem.quantities = {target_shape_same("match", problem.surface, with_vertices(problem.surface, wanted.vertices))};
    problem.objective = "match";
    problem.maximize = false;
    problem.optimize.max_evaluations = 25;
    problem.optimize.refines_whole_fronts = true;  // single patches have tests of their own
    const auto left = [&](bool as_before) {
        problem.optimize.counts_whole_energy = problem.optimize.sees_parts_alone = as_before;
        const RunResult result = optimize(problem);
        return result.objective / result.objective_start;
    };
    const double now = left(false), before = left(true);
    EXPECT_LT(now, 0.01 * before) << now << ' ' << before;
}
