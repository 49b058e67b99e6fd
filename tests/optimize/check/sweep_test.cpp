#include "optimize/check/sweep.hpp"

#include "core/error.hpp"
#include "optimize/space/design_space.hpp"
#include "problems.hpp"

#include <gtest/gtest.h>

namespace strake {
namespace {

Problem inflated() {
    Problem problem = ellipsoid_problem(2, 2);
    problem.parameters.kinds = {VariableKind::normal_load};
    problem.objective = "volume";
    return problem;
}

std::string refused(const Problem& problem, const SweepOptions& options) {
    try {
        sweep(problem, options);
    } catch (const InvalidInput& error) {
        return error.what();
    }
    return "";
}

TEST(Sweep, GoesFromEndToEndThroughTheStart) {
    const Problem problem = inflated();
    const DesignSpace space = design_space(rest_facts(problem), 1);
    const Variable& v = space.variables[0];
    int told = 0;
    const Sweep s = sweep(problem, {{{v.name, -0.5, 0.5, 5}}, 1}, [&](const SweepPoint&) { ++told; });
    EXPECT_EQ(s.names, (std::vector<std::string>{"volume", "area"}));
    ASSERT_EQ(s.points.size(), 5u);
    EXPECT_EQ(told, 5);
    for (int i = 0; i < 5; ++i) {
        const SweepPoint& p = s.points[i];
        EXPECT_EQ(p.status, "ok") << p.reason;
        EXPECT_DOUBLE_EQ(p.x[0], -0.5 + 0.25 * i);
        EXPECT_DOUBLE_EQ(p.physical[0], p.x[0] * v.unit);
        EXPECT_EQ(p.objective, p.values[0]);
        EXPECT_TRUE(i == 0 || p.objective > s.points[i - 1].objective) << i;
    }
    const double start = problem.quantities[0].evaluate({problem.surface, false, 1, 0, {}}).values[0];
    EXPECT_NEAR(s.points[2].objective, start, 1e-9 * start);
}

TEST(Sweep, PointsOfAGridDoNotDependOnTheirNeighbours) {
    const Problem problem = inflated();
    const DesignSpace space = design_space(rest_facts(problem), 2);
    const std::string a = space.variables[0].name, b = space.variables[1].name;
    const Sweep grid = sweep(problem, {{{a, 0, 0.4, 2}, {b, -0.3, 0.3, 3}}, 2});
    ASSERT_EQ(grid.points.size(), 6u);
    EXPECT_EQ(grid.points[5].x, (std::vector<double>{0.4, 0.3}));
    EXPECT_EQ(grid.points[2].x, (std::vector<double>{0, 0.3}));
    const Sweep alone = sweep(problem, {{{b, 0.3, 0, 1}, {a, 0.4, 0, 1}}, 2});
    EXPECT_EQ(alone.points.at(0).values, grid.points[5].values);
    EXPECT_NE(grid.points[5].values, grid.points[2].values);
}

TEST(Sweep, WhatDoesNotExistIsARowWithItsStatus) {
    Problem problem = inflated();
    const std::string name = design_space(rest_facts(problem), 1).variables[0].name;
    Quantity probe;
    probe.names = {"probe"};
    probe.evaluate = [](const QuantityRequest& request) -> QuantityResult {
        if (request.variables[0].second > 0) return {{}, {}, Failure{"undefined", "no room"}};
        return {{1}, {}, {}};
    };
    problem.quantities.push_back(probe);
    const Sweep s = sweep(problem, {{{name, -0.2, 0.2, 3}}, 1});
    EXPECT_EQ(s.points[0].status, "ok");
    EXPECT_EQ(s.points[2].status, "quantity_failed");
    EXPECT_NE(s.points[2].reason.find("no room"), std::string::npos) << s.points[2].reason;
    EXPECT_TRUE(s.points[2].values.empty());
    EXPECT_TRUE(std::isnan(s.points[2].objective));
    const Sweep far = sweep(inflated(), {{{name, -1e6, 0, 2}}, 1});
    EXPECT_NE(far.points[0].status, "ok");
    EXPECT_FALSE(far.points[0].reason.empty());
    EXPECT_EQ(far.points[1].status, "ok");
}

TEST(Sweep, OfAFitShowsItsObjective) {
    Problem problem = inflated();
    problem.objective.clear();
    TriMesh target = problem.surface;
    target.vertices *= 1.1;
    problem.quantities.push_back(target_shape_same("match", problem.surface, target));
    problem.fit = {"match"};
    const std::string name = design_space(rest_facts(problem), 1).variables[0].name;
    const Sweep s = sweep(problem, {{{name, 0, 0, 1}}, 1});
    EXPECT_NEAR(s.points.at(0).objective, s.points[0].values[2], 1e-12);
}

TEST(Sweep, RefusesWhatIsNoSweep) {
    const Problem problem = inflated();
    const std::string a = design_space(rest_facts(problem), 1).variables[0].name;
    EXPECT_NE(refused(problem, {{{"nothing", 0, 1, 2}}, 1}).find("'nothing'; there are: " + a), std::string::npos);
    EXPECT_NE(refused(problem, {{{a, 0, 1, 40}, {"b", 0, 1, 40}}, 1}).find("1600 points; at most 1000"),
              std::string::npos);
    EXPECT_NE(refused(problem, {{{a, 0, 1, 2}, {a, 0, 1, 2}}, 1}).find("twice"), std::string::npos);
    EXPECT_NE(refused(problem, {{{a, 0, 1, 0}}, 1}).find(">= 1"), std::string::npos);
    EXPECT_NE(refused(problem, {{{a, 0, 1, 2}}, 3}).find("[1, 2]"), std::string::npos);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_NE(refused(problem, {{{a, 0, nan, 2}}, 1}).find("finite"), std::string::npos);
    EXPECT_NE(refused(problem, {}), "");
}

}  // namespace
}  // namespace strake
