#include "optimize/run/wave_watch.hpp"

#include "core/fields/displacement_fields.hpp"
#include "optimize/run/coarse_to_fine.hpp"
#include "optimize/run/method_choice.hpp"
#include "optimize/run/stored_design.hpp"
#include "optimize/space/field_conditions.hpp"
#include "problems.hpp"

#include <gtest/gtest.h>
#include <cmath>
#include <numbers>

using namespace strake;

namespace {

/// The sum of the smooth quantity, over its value at the start, and of waves in the mean height of six slices along x:
/// 1 - cos of 2.5 waves between the start and the `wanted` shape, whose sum is `height` where all are at their top.
Quantity with_waves(const Quantity& smooth, const TriMesh& start, const Points& wanted, double height) {
    constexpr int slices = 6;
    std::vector<std::vector<int>> slice(slices);
    for (int v = 0; v < start.num_vertices(); ++v) {
        const double s = (start.vertices(v, 0) + 0.7) / 1.7;
        if (s > 0) slice[std::min(slices - 1, static_cast<int>(slices * s))].push_back(v);
    }
    const auto missing = [=](const Points& at, int k) {
        double sum = 0;
        for (const int v : slice[k]) sum += at(v, 2) - wanted(v, 2);
        return sum / static_cast<double>(slice[k].size());
    };
    const double at_start = smooth.evaluate({start, false, 0, 0, {}}).values[0];
    Quantity quantity = smooth;
    quantity.names = {"match"};
    quantity.evaluate = [=](const QuantityRequest& asked) {
        QuantityResult r = smooth.evaluate(asked);
        r.values[0] /= at_start;
        if (asked.want_sensitivities) r.dJ_dv[0] /= at_start;
        for (int k = 0; k < slices; ++k) {
            const double wave = std::max(std::abs(missing(start.vertices, k)), 0.01) / 2.5,
                         angle = 2 * std::numbers::pi * missing(asked.surface.vertices, k) / wave;
            r.values[0] += height / (2 * slices) * (1 - std::cos(angle));
            if (!asked.want_sensitivities) continue;
            for (const int v : slice[k])
                r.dJ_dv[0](v, 2) += height / (2 * slices) * std::sin(angle) * 2 * std::numbers::pi / wave /
                                    static_cast<double>(slice[k].size());
        }
        return r;
    };
    return quantity;
}

/// A body to be bent, tilted and thickened, by six fields at first.
Problem many_minima(double height) {
    Problem problem = ellipsoid_problem(3, 3);
    add_fields(problem.parameters, std::make_shared<const DisplacementFields>(
                                       problem.surface, field_conditions(problem), FieldOptions{60, {}}));
    problem.parameters.field_steps = {12, 60};
    problem.parameters.kinds = {VariableKind::normal_load};
    problem.parameters.split = SplitRule::sensitivity;
    TriMesh wanted = problem.surface;
    for (int v = 0; v < wanted.num_vertices(); ++v) {
        const Eigen::RowVector3d at = wanted.vertices.row(v);
        const double s = std::max(0.0, at[0] + 0.7);
        wanted.vertices(v, 2) += 0.05 * s * s - 0.02 * s * at[1] + 0.1 * s * at[2];
        wanted.vertices(v, 1) += 0.04 * s * at[1];
    }
    const Quantity smooth = target_shape_same("match", problem.surface, wanted);
    problem.quantities = {with_waves(smooth, problem.surface, wanted.vertices, height)};
    problem.objective = "match";
    problem.optimize.max_evaluations = 60;
    return problem;
}

/// The same by values alone, in a run long enough for models.
Problem by_values(double height) {
    Problem problem = many_minima(height);
    problem.quantities[0].has_sensitivities = false;
    problem.parameters.split = SplitRule::tree;
    problem.optimize.method = Method::model;
    problem.optimize.max_evaluations = 110;
    return problem;
}

struct Seen {
    RunResult result;
    std::vector<double> objectives;
    std::vector<int> sizes;  ///< variables of each level
    bool has_noted = false;
};

Seen run(const Problem& problem) {
    Seen seen;
    RunEvents events;
    events.evaluation = [&](const EvaluationRecord& r) { seen.objectives.push_back(r.objective); };
    events.level = [&](const LevelStart& level) { seen.sizes.push_back(level.space.size()); };
    events.note = [&](const std::string& words) { seen.has_noted |= words.find("many minima") != std::string::npos; };
    seen.result = optimize(problem, events);
    return seen;
}

/// Number of the level that is the first one again; 0: none.
std::size_t return_of(const Seen& seen) {
    for (std::size_t k = 1; k < seen.sizes.size(); ++k)
        if (seen.sizes[k] < seen.sizes[k - 1]) return k;
    return 0;
}

}  // namespace

TEST(WaveWatch, AcrossWavesARunGoesBackToTheFirstFields) {
    const Problem problem = many_minima(0.3);
    const Seen seen = run(problem);
    const std::size_t back = return_of(seen);
    ASSERT_GT(back, 0u) << seen.result.reason;
    EXPECT_TRUE(seen.has_noted);
    EXPECT_EQ(seen.sizes[back], seen.sizes[0]);
    const auto& levels = seen.result.levels;
    EXPECT_EQ(levels[back].level, static_cast<int>(back)) << "levels are numbered as they come";
    EXPECT_EQ(levels[back].objective_start, seen.result.objective_start) << "from the start";
    EXPECT_NE(levels[back].stop, "finer details are expected to gain more") << "the search there is patient";
    EXPECT_NE(levels[back].stop, "progress slackened");
    EXPECT_LE(seen.result.evaluations, 60);

    Problem as_before = problem;
    as_before.optimize.ignores_waves = true;
    const Seen before = run(as_before);
    EXPECT_EQ(return_of(before), 0u);
    EXPECT_FALSE(before.has_noted);
    EXPECT_LT(seen.result.objective, 0.5 * before.result.objective);
}

TEST(WaveWatch, NothingChangesWhereThereAreNone) {
    Problem problem = many_minima(0);
    const Seen seen = run(problem);
    problem.optimize.ignores_waves = true;
    EXPECT_EQ(seen.objectives, run(problem).objectives);
    EXPECT_FALSE(seen.has_noted);
}

/// What the seed decides is where the second search of the first fields begins.
TEST(WaveWatch, TheSameSeedGivesTheSameRun) {
    Problem problem = many_minima(0.3);
    const Seen first = run(problem);
    EXPECT_EQ(run(problem).objectives, first.objectives);
    problem.optimize.seed = 2;
    const Seen other = run(problem);
    EXPECT_NE(other.objectives, first.objectives);
    const auto differ = std::ranges::mismatch(other.objectives, first.objectives).in1 - other.objectives.begin();
    const int before = first.result.levels[0].evaluations + first.result.levels[1].evaluations;
    EXPECT_GT(differ, before) << "up to there they are the same";
}

TEST(WaveWatch, EveryBudgetIsKept) {
    Problem problem = many_minima(0.3);
    const Seen all = run(problem);
    for (const int budget : {1, 2, 3, 4, 6, 9, 13, 19, 27, 40}) {
        problem.optimize.max_evaluations = budget;
        const Seen seen = run(problem);
        EXPECT_LE(seen.result.evaluations, budget);
        EXPECT_EQ(seen.result.objective, *std::ranges::min_element(seen.objectives)) << budget;
    }
}

/// Whose first level looks between the start and its best design, and begins there once more.
TEST(WaveWatch, ByValuesARunLooksForWavesAndBeginsAgain) {
    Problem problem = by_values(0.5);
    const Seen seen = run(problem);
    EXPECT_TRUE(seen.has_noted);
    EXPECT_EQ(return_of(seen), 0u);
    EXPECT_LE(seen.result.evaluations, 110);
    EXPECT_EQ(seen.result.objective, *std::ranges::min_element(seen.objectives));
    EXPECT_EQ(run(problem).objectives, seen.objectives) << "the seed decides";
    problem.optimize.ignores_waves = true;
    const Seen before = run(problem);
    EXPECT_FALSE(before.has_noted);
    EXPECT_LT(seen.result.levels[0].objective_end, 0.8 * before.result.levels[0].objective_end);
    const int first = before.result.levels[0].evaluations;
    EXPECT_GT(seen.result.levels[0].evaluations, first);
    EXPECT_TRUE(std::equal(before.objectives.begin(), before.objectives.begin() + first, seen.objectives.begin()))
        << "up to there they are the same";
    EXPECT_FALSE(run(by_values(0)).has_noted);
}

/// Fields alone, none finer: what its share has cut is searched to its end.
TEST(WaveWatch, WhereTheFirstFieldsAreTheLastTheBudgetIsNotLeftOver) {
    Problem problem = many_minima(0.3);
    problem.parameters.kinds.clear();
    problem.parameters.field_steps = {60};
    problem.optimize.max_evaluations = 150;
    for (const unsigned seed : {1u, 2u, 3u}) {
        problem.optimize.seed = seed;
        const Seen seen = run(problem);
        EXPECT_TRUE(seen.has_noted);
        EXPECT_TRUE(seen.result.is_done() || seen.result.evaluations > 140)
            << seen.result.evaluations << ' ' << seen.result.status << ' ' << seen.result.reason;
    }
}

/// As a run that is resumed with a larger budget: the search goes on from where it was, and begins again after that.
TEST(WaveWatch, ASearchThatWasCutIsFinishedFirst) {
    Problem problem = many_minima(0.3);
    const Seen all = run(problem);
    const std::size_t back = return_of(all);
    ASSERT_GT(back, 0u);
    int before = 0;
    for (std::size_t k = 0; k < back; ++k) before += all.result.levels[k].evaluations;
    problem.optimize.max_evaluations = before + 16;  // the first fields get a share of these, and take 22
    const Seen cut = run(problem);
    const auto& level = cut.result.levels.back();
    EXPECT_EQ(cut.sizes.back(), all.sizes[back]) << "nothing else has joined";
    EXPECT_EQ(level.evaluations, cut.result.evaluations - before) << "all that is left is its own";
    // Random changes lead to 1.9; the search that was cut is at 0.66, and falls.
    EXPECT_LT(*std::max_element(cut.objectives.end() - 8, cut.objectives.end()), 0.6 * cut.objectives[0]);
}

/// The best design is the start: there is no line to look along, and rounding makes no waves.
TEST(WaveWatch, AStartThatIsTheBestHasNoWaves) {
    Problem problem = by_values(0);
    problem.quantities[0].evaluate = [start = problem.surface.vertices](const QuantityRequest& asked) {
        return QuantityResult{{1.2345 + (asked.surface.vertices - start).squaredNorm()}, {}, {}};
    };
    const Seen seen = run(problem);
    EXPECT_FALSE(seen.has_noted);
    problem.optimize.ignores_waves = true;
    EXPECT_EQ(seen.objectives, run(problem).objectives);
}

/// A quantity that fails for good while the run looks around, or begins again, ends it.
TEST(WaveWatch, WhatFailsForGoodEndsTheRun) {
    for (const bool with_gradients : {false, true}) {
        Problem problem = with_gradients ? many_minima(0.3) : by_values(0.3);
        const Seen seen = run(problem);
        const int from =
            with_gradients ? seen.result.levels[0].evaluations + seen.result.levels[1].evaluations + 2 : 24;
        for (const int last : {from, from + 11, from + 26, from + 38}) {
            Problem failing = problem;
            auto calls = std::make_shared<int>(0), after = std::make_shared<int>(0);
            failing.quantities[0].evaluate = [=, sound = problem.quantities[0].evaluate](const QuantityRequest& asked) {
                if (++*calls <= last) return sound(asked);
                *after += asked.evaluation > 0;  // others are no evaluations of the run
                QuantityResult r;
                r.failure = Failure{"exit", "the licence has expired"};
                return r;
            };
            const Seen ended = run(failing);
            EXPECT_EQ(ended.result.status, "evaluation_failed") << last << ": " << ended.result.reason;
            EXPECT_NE(ended.result.reason.find("the licence has expired"), std::string::npos) << ended.result.reason;
            EXPECT_EQ(*after, 1) << "nothing is asked after that";
        }
    }
}

/// By gradients of all values, with fields that the run chooses, from rest.
TEST(WaveWatch, WatchesRunsThatCanGoBack) {
    const Problem problem = many_minima(0.3);
    EXPECT_TRUE(looks_for_waves(problem));
    const auto without = [&](const std::function<void(Problem&)>& change) {
        Problem other = problem;
        change(other);
        return !looks_for_waves(other);
    };
    EXPECT_TRUE(without([](Problem& p) { p.parameters.fields.reset(); }));
    EXPECT_TRUE(without([](Problem& p) { p.parameters.split = SplitRule::tree; }));
    EXPECT_TRUE(without([](Problem& p) { p.optimize.method = Method::model; }));
    EXPECT_TRUE(without([](Problem& p) { p.optimize.starts = 2; }));
    EXPECT_TRUE(without([](Problem& p) { p.optimize.ignores_waves = true; }));
    EXPECT_TRUE(without([](Problem& p) { p.start = std::make_shared<const StoredDesign>(); }));

    Problem values = by_values(0.3);
    EXPECT_TRUE(looks_for_waves_by_values(values));
    EXPECT_FALSE(looks_for_waves(values));
    EXPECT_FALSE(looks_for_waves_by_values(problem));
    values.optimize.starts = 2;
    EXPECT_FALSE(looks_for_waves_by_values(values));
}
