#include "optimize/run/stored_design.hpp"

#include "core/error.hpp"
#include "core/formats/io.hpp"
#include "core/mesh/temp_folder.hpp"
#include "core/text/file.hpp"
#include "optimize/check/gradient_check.hpp"
#include "optimize/run/coarse_to_fine.hpp"
#include "optimize/run/fit.hpp"
#include "problems.hpp"

#include <gtest/gtest.h>

/// A run that begins at the best design of another one.
namespace strake {
namespace {

Problem more_volume(std::vector<VariableKind> kinds, int budget) {
    Problem problem = ellipsoid_problem(2, 3);
    problem.parameters.kinds = std::move(kinds);
    problem.objective = "volume";
    problem.maximize = true;
    problem.constraints = {{"area", std::nullopt, 1.02, std::nullopt, true}};
    problem.optimize.max_evaluations = budget;
    return problem;
}

struct Ended {
    RunResult result;
    std::shared_ptr<const StoredDesign> best;
};

/// Runs the problem; the best design has gone through a file.
Ended run(const Problem& problem, bool is_fit = false) {
    TempFolder folder;
    RunEvents events;
    events.accepted = [&](const AcceptedDesign& d) {
        write_atomically(folder / "best.design", design_bytes(stored_design(d)));
    };
    Ended ended;
    ended.result = is_fit ? fit(problem, events) : optimize(problem, events);
    ended.best = std::make_shared<StoredDesign>(read_design(folder / "best.design"));
    return ended;
}

std::string refusal(const std::function<void()>& work) {
    try {
        work();
    } catch (const InvalidInput& refused) {
        return refused.what();
    }
    return "";
}

}  // namespace

TEST(StoredDesign, ARunGoesOnWhereAnotherEnded) {
    using K = VariableKind;
    struct Pair {
        std::vector<K> first, second;
        SplitRule first_rule, second_rule;
    };
    const std::vector<Pair> pairs{{{K::load}, {K::load}, SplitRule::tree, SplitRule::tree},
                                  {{K::load}, {K::normal_load}, SplitRule::sensitivity, SplitRule::tree},
                                  {{K::normal_load, K::stiffness}, {K::load}, SplitRule::tree, SplitRule::sensitivity},
                                  {{K::strain}, {K::strain}, SplitRule::tree, SplitRule::tree}};
    for (const Pair& pair : pairs) {
        Problem a = more_volume(pair.first, 10);
        a.parameters.split = pair.first_rule;
        const Ended before = run(a);
        ASSERT_GT(before.result.objective, before.result.objective_start);
        Problem b = more_volume(pair.second, 25);
        b.parameters.split = pair.second_rule;
        start_from(b, before.best);
        Points first;
        RunEvents events;
        events.accepted = [&](const AcceptedDesign& d) {
            if (first.rows() == 0) first = d.vertices;
        };
        const RunResult r = optimize(b, events);
        EXPECT_NEAR(r.objective_start, before.result.objective, 1e-10 * before.result.objective);
        EXPECT_LE((first - before.result.vertices).rowwise().norm().maxCoeff(), 1e-10 * box_diagonal(a.surface));
        EXPECT_LE(r.levels[0].inherited_shape_change, 1e-10);
        EXPECT_EQ(r.levels[0].level, before.best->level);
        EXPECT_GT(r.objective, r.objective_start * (1 + 1e-4)) << r.reason;
        EXPECT_LE(r.max_violation, 1e-6) << "relative limits are those of the first run";
        EXPECT_NEAR(r.values[1], 1.02 * before.result.values_start[1], 1e-3 * r.values[1]);
    }
}

TEST(StoredDesign, GradientsAreCheckedThere) {
    Problem problem = more_volume({VariableKind::normal_load}, 10);
    const Ended before = run(problem);
    GradientCheckOptions options;
    options.at_start = true;
    const double undeformed = check_gradients(problem, options).tests[0].value;
    start_from(problem, before.best);
    const GradientCheck there = check_gradients(problem, options);
    EXPECT_NEAR(there.tests[0].value, before.result.objective, 1e-10 * before.result.objective);
    EXPECT_GT(there.tests[0].value, undeformed * (1 + 1e-4));
    EXPECT_TRUE(there.passed()) << there.tests[0].verdict;
    options.at_start = false;
    const GradientCheck beside = check_gradients(problem, options);
    EXPECT_NE(beside.tests[0].value, there.tests[0].value);
    EXPECT_TRUE(beside.passed()) << beside.tests[0].verdict;
    options.level = 1;
    EXPECT_NE(refusal([&] { check_gradients(problem, options); }).find("start_from"), std::string::npos);
}

TEST(StoredDesign, UserVariablesComeAlongByName) {
    Problem a = more_volume({VariableKind::normal_load}, 8);
    UserVariable lift;
    lift.name = "lift";
    for (int t = 0; t < a.surface.num_triangles() / 2; ++t) lift.triangles.push_back(t);
    lift.traction = Points::Zero(a.surface.num_triangles() / 2, 3);
    lift.traction.col(2).setConstant(1e-3);
    a.parameters.user_variables = {lift};
    const Ended before = run(a);
    ASSERT_EQ(before.best->given.size(), 1u);
    ASSERT_NE(before.best->given[0].second, 0);
    Problem b = a;
    start_from(b, before.best);
    EXPECT_NEAR(optimize(b, {}).objective_start, before.result.objective, 1e-10 * before.result.objective);
    b.parameters.user_variables.clear();
    EXPECT_NE(refusal([&] { optimize(b, {}); }).find("a variable lift"), std::string::npos);
}

TEST(StoredDesign, AFitBeginsThereToo) {
    Problem problem = ellipsoid_problem(2, 2);
    TriMesh target = problem.surface;
    target.vertices = target.vertices * Eigen::Vector3d(1.03, 0.97, 1.04).asDiagonal();
    problem.quantities = {target_shape_same("match", problem.surface, target)};
    problem.fit = {"match"};
    problem.optimize.max_evaluations = 3;
    const Ended before = run(problem, true);
    problem.optimize.max_evaluations = 20;
    start_from(problem, before.best);
    const RunResult r = fit(problem, {});
    EXPECT_NEAR(r.objective_start, before.result.objective, 1e-10 * before.result.objective);
    EXPECT_LT(r.objective, 0.9 * r.objective_start);
}

TEST(StoredDesign, ParametersComeAlong) {
    Problem a = more_volume({VariableKind::normal_load}, 6);
    a.program_parameters = {{"alpha", 0.1, 0, 1, false}, {"beta", 0.5, 0, 1, false}};
    Quantity sum;
    sum.names = {"sum"};
    const Quantity volume_of = volume(a.surface);
    sum.evaluate = [=](const QuantityRequest& request) {
        QuantityResult result = volume_of.evaluate(request);
        for (const auto& [name, value] : request.parameters) result.values[0] -= (value - 0.7) * (value - 0.7);
        Eigen::VectorXd slope(request.parameters.size());
        for (int i = 0; i < slope.size(); ++i) slope[i] = -2 * (request.parameters[i].second - 0.7);
        if (!result.dJ_dv.empty()) result.dJ_dp = {slope};
        return result;
    };
    a.quantities.push_back(sum);
    a.objective = "sum";
    const Ended before = run(a);
    ASSERT_EQ(before.best->parameters.size(), 2u);
    EXPECT_NE(before.best->parameters[0].second, 0.1);
    Problem b = a;
    start_from(b, before.best);
    EXPECT_EQ(b.program_parameters[0].start, before.best->parameters[0].second);
    EXPECT_NEAR(optimize(b, {}).objective_start, before.result.objective, 1e-10);
    Problem other = a;
    other.program_parameters = {{"beta", 0, -1, 0.1, false}};
    EXPECT_NE(refusal([&] { start_from(other, before.best); }).find("beta"), std::string::npos);
    other.program_parameters = {{"gamma", 0, -1, 0.1, false}};
    start_from(other, before.best);
    EXPECT_EQ(other.program_parameters[0].start, 0);
}

TEST(StoredDesign, ADeeperTreeOfTheSameLevelsIsUsed) {
    Problem a = more_volume({VariableKind::normal_load}, 8);
    const PatchHierarchy deep = a.tree;
    a.tree.levels.resize(2);
    const Ended before = run(a);
    Problem b = more_volume({VariableKind::normal_load}, 30);
    start_from(b, before.best);
    EXPECT_EQ(b.tree.levels.size(), deep.levels.size());
    EXPECT_GT(optimize(b, {}).levels.size(), 1u);
    Problem c = b;
    c.tree.levels.resize(1);
    start_from(c, before.best);
    EXPECT_EQ(c.tree.levels.size(), 2u);
}

TEST(StoredDesign, OtherSurfacesAndShellsAreRefused) {
    const Ended before = run(more_volume({VariableKind::normal_load}, 8));
    ASSERT_GT(before.result.best_evaluation, 1);
    const auto with_surface = [&](const TriMesh& surface) {
        Problem problem = more_volume({VariableKind::normal_load}, 3);
        problem.surface = surface;
        return refusal([&] { start_from(problem, before.best); });
    };
    const TriMesh same = more_volume({VariableKind::load}, 1).surface;
    EXPECT_EQ(with_surface(same), "");
    EXPECT_NE(with_surface(icosphere(1)).find("42 vertices and 80 triangles"), std::string::npos);
    TriMesh turned = same;
    turned.triangles.row(0).reverseInPlace();
    EXPECT_NE(with_surface(turned).find("other triangles"), std::string::npos);
    TriMesh moved = same;
    moved.vertices(3, 1) = std::nextafter(moved.vertices(3, 1), 10);
    EXPECT_NE(with_surface(moved).find("other positions"), std::string::npos);
    Problem strained = more_volume({VariableKind::strain}, 3);
    EXPECT_NE(refusal([&] { start_from(strained, before.best); }).find("strain"), std::string::npos);
    Problem thicker = more_volume({VariableKind::normal_load}, 3);
    thicker.prism_height *= 1.5;
    start_from(thicker, before.best);
    EXPECT_NE(refusal([&] { optimize(thicker, {}); }).find("diagonals off"), std::string::npos);
}

TEST(StoredDesign, ADamagedFileIsRefused) {
    TempFolder folder;
    const std::string bytes = design_bytes(*run(more_volume({VariableKind::load}, 2)).best);
    const auto file = folder / "best.design";
    write_atomically(file, bytes);
    EXPECT_EQ(design_bytes(read_design(file)), bytes) << "nothing is lost on the way";
    for (std::size_t length = 0; length < bytes.size(); length += bytes.size() / 40 + 1) {
        write_atomically(file, bytes.substr(0, length));
        EXPECT_THROW(read_design(file), InputError) << length;
    }
    write_atomically(file, bytes + "x");
    EXPECT_THROW(read_design(file), InputError);
    EXPECT_THROW(read_design(folder / "none"), InputError);
}

}  // namespace strake
