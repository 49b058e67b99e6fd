#include "core/error.hpp"
#include "core/fields/displacement_fields.hpp"
#include "core/mesh/closest_point.hpp"
#include "optimize/run/coarse_to_fine.hpp"
#include "optimize/run/level_program.hpp"
#include "optimize/run/method_choice.hpp"
#include "problems.hpp"

#include <gtest/gtest.h>
#include <Eigen/QR>
#include <limits>

/// Runs by method model: levels, the motion limit, and when `method: auto` chooses it.
namespace strake {
namespace {

using Eigen::VectorXd;

Problem values_only(int evaluations, int levels = 2, VariableKind kind = VariableKind::normal_load) {
    Problem problem = ellipsoid_problem(2, levels);
    problem.parameters.kinds = {kind};
    maximize_volume(problem, 1.02);
    for (Quantity& quantity : problem.quantities) quantity.has_sensitivities = false;
    problem.optimize.method = Method::model;
    problem.optimize.max_evaluations = evaluations;
    return problem;
}

Problem automatic(int evaluations) {
    Problem problem = values_only(evaluations, 2, VariableKind::load);
    problem.optimize.method = Method::sqp;
    problem.optimize.chooses_method = true;
    return problem;
}

/// The same with displacement fields in front.
Problem with_fields(Problem problem) {
    FieldConditions conditions;
    conditions.held = problem.fixed;
    add_fields(problem.parameters,
               std::make_shared<const DisplacementFields>(problem.surface, conditions, FieldOptions{12, {}}));
    problem.parameters.field_steps = {6, 12};
    return problem;
}

struct Told {
    RunResult result;
    std::string notes;
    double largest_displacement = 0;
    bool is_within = true;
};

Told run(const Problem& problem) {
    Told told;
    const double limit = problem.parameters.max_displacement * box_diagonal(problem.surface);
    RunEvents events;
    events.note = [&](const std::string& words) { told.notes += words + "\n"; };
    events.evaluation = [&](const EvaluationRecord& record) {
        told.largest_displacement = std::max(told.largest_displacement, record.max_displacement / limit);
        if (record.reason.find("limit") != std::string::npos) told.is_within = false;
    };
    told.result = optimize(problem, events);
    return told;
}

}  // namespace

TEST(ModelRun, KeepsToTheMotionLimitAndTheConstraint) {
    Problem problem = values_only(60);
    problem.parameters.max_displacement = 0.01;
    const Told told = run(problem);
    EXPECT_LE(told.largest_displacement, 1 + 1e-9);
    EXPECT_GT(told.largest_displacement, 0.9) << "else the limit says nothing";
    EXPECT_TRUE(told.is_within) << "a proposal was refused";
    EXPECT_LE(told.result.max_violation, problem.optimize.constraint_tolerance);
    EXPECT_GT(told.result.objective, told.result.objective_start);
}

/// What limits the area is known exactly, and where it and the motion limit meet the search goes on along both.
TEST(ModelRun, MeetsExactLimitsAndTheMotionLimitTogether) {
    const auto with_turns = [](bool has_turns) {
        Problem problem = ellipsoid_problem(2, 2);
        problem.parameters.kinds = {VariableKind::load};
        maximize_volume(problem, 1.02);
        problem = with_fields(problem);
        problem.quantities[0].has_sensitivities = false;
        problem.quantities[0].program = "a solver";
        problem.parameters.max_displacement = 0.01;
        problem.optimize.method = Method::model;
        problem.optimize.max_evaluations = 40;
        problem.optimize.limits_by_turns = has_turns;
        return problem;
    };
    const Told together = run(with_turns(false)), by_turns = run(with_turns(true));
    EXPECT_GT(together.largest_displacement, 0.9) << "else the limit says nothing";
    EXPECT_LE(together.largest_displacement, 1 + 1e-9);
    EXPECT_LE(together.result.max_violation, 1e-6);
    const auto gain = [](const Told& told) { return told.result.objective - told.result.objective_start; };
    // 4 to 6 % more, by seeds and processors.
    EXPECT_GT(gain(together), 1.02 * gain(by_turns)) << gain(together) << " " << gain(by_turns);
}

/// Steps that are far too long for the shell: a run of before tries designs without a shape.
TEST(ModelRun, ProposesDesignsThatHaveAShape) {
    const auto failed = [](bool has_turns) {
        Problem problem = values_only(40, 2, VariableKind::load);
        problem.parameters.max_displacement = std::numeric_limits<double>::infinity();
        problem.parameters.variable_scale = 0.6;
        problem.optimize.limits_by_turns = has_turns;
        RunEvents events;
        int count = 0;
        events.evaluation = [&](const EvaluationRecord& record) { count += !record.reason.empty(); };
        optimize(problem, events);
        return count;
    };
    const int before = failed(true);
    EXPECT_GT(before, 4) << "else this shows nothing";
    EXPECT_LT(failed(false), before / 2) << before;
}

/// A level that is split inherits its shape exactly, and so every design of before is one of the new level.
TEST(ModelRun, DesignsOfCoarserLevelsAreDesignsOfFinerOnes) {
    const Problem problem = values_only(60, 2, VariableKind::load);
    RunEvents events;
    RunState state(problem, events, LevelProgram::differentiated_names(problem), nullptr);
    state.evaluator.take_over_values();
    LevelProgram level(state);
    VectorXd x = state.next_level({}, nullptr);
    ASSERT_GT(x.size(), 3);
    const VectorXd weight = (level.enter(x), level.weight());
    for (int k = 0; k < 3; ++k) {
        VectorXd y = x.cwiseProduct(weight);
        if (k > 0) y[k] += 0.3 * k;
        ASSERT_EQ(level.program().evaluate(y).failure, "");
        if (k == 2) x = y.cwiseQuotient(weight);
    }
    const VectorXd start = state.next_level(x);
    level.carry_designs(x, start, state.prolongation);
    const NonlinearProgram& finer = level.enter(start);
    ASSERT_TRUE(finer.known);
    const std::vector<KnownPoint> known = finer.known();
    ASSERT_EQ(known.size(), 3u);
    for (const KnownPoint& point : known) {
        ASSERT_EQ(point.x.size(), state.space.size());
        const Evaluation again = finer.evaluate(point.x);
        EXPECT_NEAR(point.evaluation.objective, again.objective, 1e-8 * std::abs(again.objective));
        EXPECT_NEAR(point.evaluation.constraints[0], again.constraints[0], 1e-8);
    }
    EXPECT_GT(std::abs(known[0].evaluation.objective - known[2].evaluation.objective), 1e-6) << "else nothing is shown";
}

TEST(ModelRun, AShortBudgetChoosesItAndALongOneDifferences) {
    const int variables = max_variables_at_start(automatic(1));
    ASSERT_GT(variables, 3);
    const int enough = static_cast<int>(min_gradients) * (variables + 1);
    EXPECT_EQ(choose_method(automatic(enough - 1), enough - 1).method, Method::model);
    EXPECT_EQ(choose_method(automatic(enough), enough).method, Method::sqp);
    const Told told = run(automatic(20));
    EXPECT_NE(told.notes.find("method: auto chooses model, in batches of 8: 'volume' has no gradient"),
              std::string::npos)
        << told.notes;
    Problem stated = values_only(20, 2, VariableKind::load);
    EXPECT_EQ(told.result.vertices, run(stated).result.vertices);
}

TEST(ModelRun, FieldsInFrontAreSearchedByModelsInLongRunsToo) {
    const auto chosen = [](int budget, bool as_before = false) {
        Problem problem = with_fields(automatic(budget));
        problem.optimize.long_runs_by_differences = as_before;
        return choose_method(problem, budget);
    };
    const int enough = static_cast<int>(min_gradients) * (6 + 1);
    ASSERT_EQ(max_variables_at_start(with_fields(automatic(1))), 6);
    for (const int budget : {enough - 1, enough, max_evaluations_by_models})
        EXPECT_EQ(chosen(budget).method, Method::model) << budget;
    EXPECT_EQ(chosen(max_evaluations_by_models + 1).method, Method::sqp);
    EXPECT_EQ(chosen(enough, true).method, Method::sqp) << "a run of before";
    EXPECT_EQ(chosen(enough - 1, true).method, Method::model);
    EXPECT_EQ(chosen(enough - 1).words.find("displacement fields"), std::string::npos);
    EXPECT_NE(chosen(enough).words.find("model, in batches of 8: displacement fields are the first level, and 'volume' "
                                        "has no gradient"),
              std::string::npos)
        << chosen(enough).words;
}

TEST(ModelRun, FirstFieldsAreAskedInHalfBatchesOfAtLeastFour) {
    const auto of = [](int batch, bool as_before = false) {
        OptimizeOptions options;
        options.batch = batch;
        options.begins_with_whole_batches = as_before;
        return batch_of_first_fields(options);
    };
    for (const auto& [batch, first] : {std::pair(1, 1), {3, 3}, {4, 4}, {6, 4}, {8, 4}, {9, 4}, {32, 16}})
        EXPECT_EQ(of(batch), first) << batch;
    EXPECT_EQ(of(8, true), 8) << "a run of before";
    EXPECT_NE(choose_method(with_fields(automatic(60)), 60).words.find("; the first level asks 4 at a time"),
              std::string::npos);
    EXPECT_EQ(choose_method(with_fields(automatic(20)), 20).words.find("at a time"), std::string::npos)
        << "a short run";
}

TEST(ModelRun, SaysThatOneAtATimeNeedsFewerWhereNoProgramRunsSeveral) {
    const auto says = [](int batch, int parallel) {
        Problem problem = with_fields(automatic(60));
        problem.optimize.batch = batch;
        problem.quantities[0].parallel = parallel;
        return choose_method(problem, 60).words.find("optimize.batch: 1 learns after each") != std::string::npos;
    };
    EXPECT_TRUE(says(8, 1));
    EXPECT_FALSE(says(8, 4));
    EXPECT_FALSE(says(1, 1));
}

/// Who has the evaluations begins with the smoothest motions, one at a time; who has few with all of them mixed.
TEST(ModelRun, ALongRunTriesOneFieldAfterAnother) {
    const auto moved_at_first = [](int budget, bool as_before, bool in_whole_batches = false) {  // variables
        Problem problem = with_fields(values_only(budget));
        problem.optimize.long_runs_by_differences = as_before;
        problem.optimize.begins_with_whole_batches = in_whole_batches;
        Eigen::MatrixXd fields(problem.surface.vertices.size(), 6);
        for (int j = 0; j < 6; ++j) fields.col(j) = problem.parameters.fields->field(j).reshaped();
        std::vector<long> moved;
        problem.quantities[0].evaluate = [&, inner = problem.quantities[0].evaluate](const QuantityRequest& request) {
            if (moved.size() == 5) return inner(request);  // the start, and half of a whole first batch
            const VectorXd way = (request.surface.vertices - problem.surface.vertices).reshaped();
            const VectorXd x = fields.householderQr().solve(way);
            EXPECT_LT((fields * x - way).norm(), 1e-9) << "fields alone move it";
            moved.push_back((x.array().abs() > 1e-9).count());
            return inner(request);
        };
        optimize(problem);
        moved.erase(moved.begin());
        return moved;
    };
    const int enough = static_cast<int>(min_gradients) * (6 + 1);
    EXPECT_EQ(moved_at_first(enough, false, true), (std::vector<long>{1, 1, 1, 1}));
    const std::vector<long> now = moved_at_first(enough, false);
    EXPECT_EQ(std::vector<long>(now.begin(), now.begin() + 2), (std::vector<long>{1, 1}));
    EXPECT_GT(now[2], 1) << "models choose after two answers";
    for (const std::vector<long>& mixed : {moved_at_first(enough - 1, false), moved_at_first(enough, true)})
        EXPECT_EQ(mixed, (std::vector<long>{6, 6, 6, 6}));
}

/// Three evaluations for two variables; more in a run of before, and where there are few.
TEST(ModelRun, ALongRunLeavesFieldsAloneSooner) {
    const int variables = 6, enough = static_cast<int>(min_gradients) * (variables + 1);
    const auto spent = [](int budget, bool as_before) {
        Problem problem = with_fields(values_only(budget));
        problem.optimize.batch = 1;
        problem.optimize.begins_slowly = as_before;
        return run(problem).result.levels.at(0).evaluations;
    };
    const int few = 3 * (variables + 1) / 2;
    EXPECT_EQ(spent(enough, false), few);
    EXPECT_GT(spent(enough, true), few);
    EXPECT_GT(spent(enough - 1, false), few);
}

TEST(ModelRun, ALongRunBeginsWithHalfABatch) {
    const int enough = static_cast<int>(min_gradients) * (6 + 1);
    const auto moved_alone = [](int budget, bool is_whole, bool as_before) {  // designs that move one field
        Problem problem = with_fields(values_only(budget));
        problem.optimize.batch = 6;
        problem.optimize.begins_with_whole_batches = is_whole;
        problem.optimize.begins_slowly = as_before;
        Eigen::MatrixXd fields(problem.surface.vertices.size(), 6);
        for (int j = 0; j < 6; ++j) fields.col(j) = problem.parameters.fields->field(j).reshaped();
        int designs = 0, alone = 0;
        problem.quantities[0].evaluate = [&, inner = problem.quantities[0].evaluate](const QuantityRequest& request) {
            const VectorXd way = (request.surface.vertices - problem.surface.vertices).reshaped();
            const VectorXd x = fields.householderQr().solve(way);
            if (++designs <= 7) alone += (x.array().abs() > 1e-9).count() == 1;
            return inner(request);
        };
        optimize(problem);
        return alone;
    };
    EXPECT_EQ(moved_alone(enough, false, false), 2) << "of the four that its first level asks at a time";
    EXPECT_EQ(moved_alone(enough, true, false), 3);
    EXPECT_EQ(moved_alone(enough, true, true), 6);
}

/// The finest level of the tree has no finer fields: where not all can be learned its patches alone are searched, from
/// the shape that fields made.
TEST(ModelRun, FieldsRestWhereALongRunHasNoFinerOnes) {
    for (const auto& [budget, as_before] : {std::pair{80, false}, {80, true}, {300, false}}) {
        Problem problem = with_fields(values_only(budget));
        problem.optimize.batch = 4;
        problem.optimize.begins_slowly = as_before;
        std::vector<long> fields;  // variables of each level
        RunEvents events;
        events.level = [&](const LevelStart& level) {
            fields.push_back(std::ranges::count(level.space.variables, VariableKind::field, &Variable::kind));
        };
        const RunResult result = optimize(problem, events);
        EXPECT_EQ(fields, (std::vector<long>{6, 12, budget == 80 && !as_before ? 0 : 12})) << budget;
        ASSERT_EQ(result.levels.size(), 3u);
        EXPECT_LT(result.levels[2].inherited_shape_change, 1e-9);
        EXPECT_GE(result.levels[2].objective_end, (1 - 1e-9) * result.levels[1].objective_end);
        EXPECT_GT(result.levels[1].objective_end, 1.001 * result.levels[0].objective_start) << "fields have moved";
    }
}

/// Octants, and two levels more: 16 and up to 32 patches.
Problem with_fine_patches(int evaluations) {
    Problem problem = with_fields(values_only(evaluations, 3));
    const Points c = triangle_centroids(problem.surface);
    auto& levels = problem.tree.levels;
    for (const auto& [axis, half] : {std::pair{0, 0.45}, {1, 0.25}}) {
        PatchLevel finer =
            level_by(problem.surface, &levels.back(), [&](int t) { return std::abs(c(t, axis)) > half ? 1 : 0; });
        levels.push_back(std::move(finer));
    }
    return problem;
}

/// Least mean square distance, vertex to vertex, to the surface with a bump that no smooth field makes.
Problem with_bump(int evaluations) {
    Problem problem = with_fine_patches(evaluations);
    problem.constraints.clear();
    Eigen::Index highest = 0;
    problem.surface.vertices.col(2).maxCoeff(&highest);
    const Eigen::RowVector3d top = problem.surface.vertices.row(highest);
    Points target = problem.surface.vertices;
    for (Eigen::Index v = 0; v < target.rows(); ++v)
        target(v, 2) += 0.02 * std::exp(-(target.row(v) - top).squaredNorm() / 0.03);
    Quantity distance = problem.quantities[0];
    distance.names = {"distance"};
    distance.evaluate = [target](const QuantityRequest& request) {
        QuantityResult result;
        result.values = {(request.surface.vertices - target).squaredNorm()};
        return result;
    };
    problem.quantities = {distance};
    problem.objective = "distance";
    problem.maximize = false;
    return problem;
}

/// Fields, few patches to see what these gain, and what follows from that. Shapes go on from level to level, and the
/// order is that of every run of the case.
TEST(ModelRun, ALongRunTriesPatchesBeforeFinerFields) {
    struct Seen {
        std::vector<long> fields;  ///< variables of each level
        std::vector<int> patches;  ///< the same; 0: they rest
        Told told;
    };
    const auto seen = [](Problem problem) {
        Seen seen;
        problem.optimize.batch = 4;
        RunEvents events;
        events.note = [&](const std::string& words) { seen.told.notes += words + "\n"; };
        events.level = [&](const LevelStart& level) {
            seen.fields.push_back(std::ranges::count(level.space.variables, VariableKind::field, &Variable::kind));
            seen.patches.push_back(level.space.size() - static_cast<int>(seen.fields.back()));
        };
        seen.told.result = optimize(problem, events);
        return seen;
    };
    for (const bool has_bump : {true, false}) {
        const Problem problem = has_bump ? with_bump(200) : with_fine_patches(200);
        const Seen found = seen(problem);
        const RunResult& result = found.told.result;
        const bool lead = found.told.notes.find("patches go first") != std::string::npos;
        EXPECT_TRUE(lead || !has_bump) << found.told.notes;
        const std::vector<long> fields = lead ? std::vector<long>{6, 0, 0, 12, 0} : std::vector<long>{6, 0, 12, 0};
        ASSERT_EQ(found.fields, fields) << found.told.notes;
        EXPECT_EQ(found.patches.front(), 0);
        EXPECT_GT(found.patches[1], 0);
        EXPECT_LE(found.patches[1], 24);
        EXPECT_EQ(found.patches[fields.size() - 2], 0) << "patches rest where fields are by themselves";
        EXPECT_GT(found.patches.back(), found.patches[1]);
        for (std::size_t k = 1; k < result.levels.size(); ++k) {
            EXPECT_LT(result.levels[k].inherited_shape_change, 1e-9) << k;
            EXPECT_GT(result.levels[k].evaluations, 0) << k;
        }
        EXPECT_LE(result.evaluations, 200);
        if (!has_bump) continue;
        EXPECT_EQ(seen(problem).told.result.vertices, result.vertices) << "bit for bit";
        Problem before = problem;
        before.optimize.patches_last = true;
        before.optimize.max_evaluations = 60;
        EXPECT_EQ(seen(before).fields[1], 12) << "a run of before";
    }
}

/// Values that fields had when they began to rest are within their ranges once they are variables again.
TEST(ModelRun, FieldsThatRestedGoOnFromWhereTheyWere) {
    const Problem problem = with_bump(200);
    RunEvents events;
    std::vector<double> carried, taken_up;  // the largest of each level
    std::size_t back = 0;                   // where fields are variables again
    events.level = [&](const LevelStart& level) {
        const VectorXd& user = level.space.carried_user_values;
        if (back == 0 && carried.size() > 1 && !level.space.fields.numbers.empty()) back = carried.size();
        carried.push_back(user.size() > 0 ? user.cwiseAbs().maxCoeff() : 0);
        taken_up.push_back(level.x.size() > 0 ? level.x.cwiseAbs().maxCoeff() : 0);
    };
    const RunResult result = optimize(problem, events);
    ASSERT_GE(back, 2u);
    EXPECT_GT(carried[1], 0) << "else this says nothing";
    EXPECT_EQ(carried[back], 0);
    EXPECT_GT(taken_up[back], 0);
    EXPECT_LT(result.levels[back].inherited_shape_change, 1e-9);
}

/// The body is held at one end along x, y and z are planes of it and of its values: both halves move alike.
TEST(ModelRun, ALongRunKeepsTheSymmetryOfBodyAndValues) {
    const auto asymmetry = [](const RunResult& result, const Problem& problem) {
        TriMesh mesh = problem.surface;
        mesh.vertices = result.vertices;
        const ClosestPointTree tree(mesh);
        double worst = 0;
        for (int v = 0; v < result.vertices.rows(); ++v) {
            const Eigen::Vector3d p = result.vertices.row(v), image(p[0], -p[1], p[2]);
            worst = std::max(worst, (tree.find(image).point - image).norm());
        }
        return worst / box_diagonal(problem.surface);
    };
    Problem problem = with_fine_patches(110);
    problem.parameters.field_steps = {12};
    const Told found = run(problem);
    EXPECT_NE(found.notes.find("values are the same for mirror images"), std::string::npos) << found.notes;
    EXPECT_LT(asymmetry(found.result, problem), 1e-6) << found.notes;
    problem.optimize.ignores_symmetry = true;
    const Told before = run(problem);
    EXPECT_EQ(before.notes.find("mirror images"), std::string::npos);
    EXPECT_GT(asymmetry(before.result, problem), 1e-5) << "else this says nothing";
}

/// One side of the body counts more.
TEST(ModelRun, ALongRunLeavesTheSymmetryThatValuesDoNotHave) {
    Problem problem = with_bump(120);
    problem.quantities[0].evaluate = [rest = problem.surface.vertices](const QuantityRequest& request) {
        const Points moved = request.surface.vertices - rest;
        QuantityResult result;
        result.values = {(moved.col(1).array() - 0.02).square().sum() + (moved.col(2).array() - 0.02).square().sum()};
        return result;
    };
    const Told told = run(problem);
    EXPECT_EQ(told.notes.find("mirror images"), std::string::npos) << told.notes;
    EXPECT_LT(told.result.objective, 0.5 * told.result.objective_start);
}

TEST(ModelRun, ABudgetThatEndsWithTheFirstBatchIsTold) {
    EXPECT_NE(run(values_only(9))
                  .notes.find("a budget of 9 evaluations ends with the first (the start, and a batch of "
                              "8): raise optimize.budget.evaluations to 17 or more, or lower "
                              "optimize.batch to 4"),
              std::string::npos);
    EXPECT_EQ(run(values_only(10)).notes.find("ends with the first"), std::string::npos);
}

/// What says nothing and has gradients, or states differences, is left alone.
TEST(ModelRun, AutomaticChangesNothingElse) {
    Problem problem = automatic(12);
    problem.quantities = {volume(problem.surface), area()};
    Problem sqp = problem;
    sqp.optimize.chooses_method = false;
    const Told chosen = run(problem), before = run(sqp);
    EXPECT_EQ(chosen.result.vertices, before.result.vertices);
    EXPECT_EQ(chosen.notes, before.notes);
    Problem stated = automatic(12);
    stated.optimize.finite_differences = true;
    EXPECT_TRUE(choose_method(stated, 12).words.empty());
}

/// The volume is computed here: every proposal can have the one that is asked for.
TEST(ModelRun, MeetsExactlyWhatNoProgramTells) {
    Problem problem = ellipsoid_problem(2, 1);
    problem.parameters.kinds = {VariableKind::load};
    problem.parameters.max_displacement = 0.03;
    Quantity solver;
    solver.names = {"flow"};
    solver.program = "solver";
    solver.has_sensitivities = false;
    solver.evaluate = [](const QuantityRequest& request) {
        QuantityResult result;
        result.values = {triangle_areas(request.surface).sum()};
        return result;
    };
    problem.quantities.push_back(solver);
    problem.objective = "flow";
    Constraint same_volume;
    same_volume.quantity = "volume";
    same_volume.equals = 1;
    same_volume.relative = true;
    problem.constraints = {same_volume};
    problem.optimize.method = Method::model;
    problem.optimize.max_evaluations = 24;
    const Told told = run(problem);
    EXPECT_LE(told.result.max_violation, problem.optimize.constraint_tolerance);
    EXPECT_LT(told.result.objective, 0.999 * told.result.objective_start);
}

TEST(ModelRun, AVariableWithoutEffectAndAConstantObjectiveAreTold) {
    Problem problem = values_only(40, 1);
    problem.constraints.clear();
    problem.quantities[0].evaluate = [](const QuantityRequest&) {
        QuantityResult result;
        result.values = {3};
        return result;
    };
    const Told told = run(problem);
    EXPECT_NE(told.result.reason.find("depend"), std::string::npos) << told.result.reason;
    EXPECT_LT(told.result.evaluations, 40);
}

/// Where the finest patches have come to rest with evaluations left, fields are searched beside them, first few.
TEST(ModelRun, FieldsComeBackBesideTheFinestPatches) {
    Problem problem = with_bump(420);
    problem.optimize.objective_tolerance = 1e-3;
    RunEvents events;
    std::string notes;
    std::vector<std::size_t> fields, patches;
    events.note = [&](const std::string& words) { notes += words + "\n"; };
    events.level = [&](const LevelStart& level) {
        fields.push_back(level.space.fields.numbers.size());
        patches.push_back(static_cast<std::size_t>(level.space.size()) - fields.back());
    };
    const RunResult result = optimize(problem, events);
    ASSERT_NE(notes.find("fields come back beside the finest patches"), std::string::npos) << notes;
    const auto back = static_cast<std::size_t>(
        std::adjacent_find(fields.begin() + 1, fields.end(),
                           [](std::size_t before, std::size_t after) { return before == 0 && after == 6; }) -
        fields.begin());
    ASSERT_LT(back + 1, fields.size()) << notes;
    EXPECT_EQ(patches[back + 1], patches[back]) << "beside all of them";
    EXPECT_LT(result.levels[back + 1].inherited_shape_change, 1e-9);
    EXPECT_LE(result.evaluations, 420);
    problem.optimize.fields_lead = true;
    notes.clear();
    optimize(problem, events);
    EXPECT_EQ(notes.find("come back"), std::string::npos) << "a run of before";
}

/// Not the first fields, nor the trial of patches after them; and only in a run of now.
TEST(ModelRun, LevelsOfALongRunGoOnWhileTheyGain) {
    Problem problem = with_fine_patches(200);
    const auto grown = [](const Told& told) {  // numbers of these levels
        std::vector<int> levels;
        const std::string words = "the limit of evaluations of level ";
        for (std::size_t at = told.notes.find(words); at != std::string::npos; at = told.notes.find(words, at + 1))
            if (told.notes.find(" grows by ", at) == told.notes.find(' ', at + words.size()))
                levels.push_back(std::stoi(told.notes.substr(at + words.size())));
        return levels;
    };
    const Told now = run(problem);
    const std::vector<int> levels = grown(now);
    ASSERT_FALSE(levels.empty()) << now.notes;
    EXPECT_GE(*std::ranges::min_element(levels), 2) << now.notes;
    EXPECT_LE(now.result.evaluations, 200);
    EXPECT_EQ(run(problem).result.vertices, now.result.vertices) << "bit for bit";
    EXPECT_NE(now.notes.find("has gained 15 % of all"), std::string::npos) << now.notes;
    problem.optimize.levels_gain_a_quarter = true;
    const Told before = run(problem);
    EXPECT_EQ(before.notes.find("has gained 15 % of all"), std::string::npos) << before.notes;
    EXPECT_LE(grown(before).size(), levels.size());
    problem.optimize.levels_end_at_limits = true;
    EXPECT_EQ(grown(run(problem)), std::vector<int>{});
}

}  // namespace strake
