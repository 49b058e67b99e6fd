#include "optimize/space/parameters.hpp"

#include "core/error.hpp"
#include "optimize/check/gradient_check.hpp"
#include "optimize/check/sweep.hpp"
#include "optimize/run/coarse_to_fine.hpp"
#include "optimize/run/fit.hpp"
#include "problems.hpp"

#include <gtest/gtest.h>

/// Design variables that are not shape: optimized with it, carried over exactly, bounded, checked.
namespace strake {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

struct Seen {
    double least = 1e9, most = -1e9;
    int evaluations = 0;
};

/// J = 40 (v - 1.05)^2 + (alpha - wanted)^2 + 2 (v - 1.05) (alpha - wanted), v the volume over that at rest: least at
/// v = 1.05 and alpha = wanted.
Quantity drag(const TriMesh& surface, double wanted, double slope_factor = 1, Seen* seen = nullptr) {
    const Quantity volume_of = volume(surface);
    const double at_rest = volume_of.evaluate({surface, false, 0, 0, {}}).values[0];
    Quantity quantity;
    quantity.names = {"drag"};
    quantity.evaluate = [=](const QuantityRequest& request) {
        const double alpha = request.parameters.at(0).second;
        if (seen) {
            seen->least = std::min(seen->least, alpha);
            seen->most = std::max(seen->most, alpha);
            ++seen->evaluations;
        }
        QuantityResult result = volume_of.evaluate(request);
        const double dv = result.values[0] / at_rest - 1.05, da = alpha - wanted;
        result.values[0] = 40 * dv * dv + da * da + 2 * dv * da;
        if (!result.dJ_dv.empty()) {
            result.dJ_dv[0] *= (80 * dv + 2 * da) / at_rest;
            result.dJ_dp = {Eigen::VectorXd::Constant(1, slope_factor * (2 * da + 2 * dv))};
        }
        return result;
    };
    return quantity;
}

Problem with_alpha(double wanted, double slope_factor = 1, Seen* seen = nullptr) {
    Problem problem = ellipsoid_problem(2, 2);
    problem.program_parameters = {{"alpha", 0.05, 0, 0.2, true}};
    problem.quantities.push_back(drag(problem.surface, wanted, slope_factor, seen));
    problem.objective = "drag";
    problem.parameters.kinds = {VariableKind::normal_load};
    problem.optimize.max_evaluations = 80;
    problem.optimize.objective_tolerance = 1e-9;
    problem.optimize.step_tolerance = 1e-8;
    return problem;
}

/// Something that only small patches can do.
void add_local_target(Problem& problem) {
    TriMesh target = problem.surface;
    for (int v = 0; v < target.num_vertices(); ++v)
        if (target.vertices(v, 0) > 0.5 && target.vertices(v, 1) > 0) target.vertices(v, 1) *= 1.15;
    const Quantity first = problem.quantities.back(), second = target_shape_same("match", problem.surface, target);
    problem.quantities.back().evaluate = [=](const QuantityRequest& request) {
        QuantityResult sum = first.evaluate(request);
        const QuantityResult more = second.evaluate(request);
        sum.values[0] += 100 * more.values[0];
        if (!sum.dJ_dv.empty()) sum.dJ_dv[0] += 100 * more.dJ_dv[0];
        return sum;
    };
}

double alpha_of(const RunResult& result) { return parameter_values(result.space, result.x).at(0).second; }

}  // namespace

TEST(ParameterValues, StandBehindTheShapeWithHalfTheRangeAsUnit) {
    const Problem problem = with_alpha(0.1);
    const DesignSpace space = design_space(rest_facts(problem), 1);
    ASSERT_EQ(space.num_parameters(), 1);
    EXPECT_EQ(space.num_shape() + 1, space.size());
    const int j = space.size() - 1;
    EXPECT_EQ(space.variables[j].name, "alpha");
    EXPECT_DOUBLE_EQ(space.variables[j].unit, 0.1);
    EXPECT_DOUBLE_EQ(space.lower[j], -0.5);
    EXPECT_DOUBLE_EQ(space.upper[j], 1.5);
    EXPECT_EQ(space.metric(j, j), 1);
    EXPECT_TRUE(space.metric.col(j).head(j).isZero(0));
    Eigen::VectorXd x = Eigen::VectorXd::Zero(space.size());
    EXPECT_EQ(parameter_values(space, x)[0].second, 0.05);
    x[j] = space.upper[j];
    EXPECT_EQ(parameter_values(space, x)[0].second, 0.2) << "not beyond by a bit";
    EXPECT_EQ(physical_values(space, x).size(), static_cast<std::size_t>(space.num_shape()));
}

TEST(ParameterValues, TheOptimumInShapeAndVariableIsFound) {
    for (const Method method : {Method::sqp, Method::lbfgs}) {
        Problem problem = with_alpha(0.12);
        problem.optimize.method = method;
        const RunResult r = optimize(problem, {});
        EXPECT_TRUE(r.is_done()) << r.status << ": " << r.reason;
        EXPECT_NEAR(alpha_of(r), 0.12, 1e-4) << r.reason;
        EXPECT_NEAR(r.values[0] / r.values_start[0], 1.05, 1e-4);
        EXPECT_LT(r.objective, 1e-7);
    }
}

TEST(ParameterValues, RefinementKeepsThemToTheBit) {
    for (const SplitRule rule : {SplitRule::tree, SplitRule::sensitivity}) {
        Problem problem = with_alpha(0.12);
        problem.parameters.split = rule;
        problem.parameters.mirror = rule == SplitRule::tree;  // tied variables are inherited by least squares
        add_local_target(problem);
        problem.optimize.objective_tolerance = 1e-4;
        std::vector<EvaluationRecord> records;
        double before = nan;
        int levels = 0;
        RunEvents events;
        events.evaluation = [&](const EvaluationRecord& record) { records.push_back(record); };
        events.level = [&](const LevelStart& level) {
            const double start = parameter_values(level.space, level.x).at(0).second;
            if (levels++ > 0) {
                EXPECT_EQ(start, before);
            }
        };
        events.level_end = [&](const LevelSummary&) {
            double best = nan;
            for (const EvaluationRecord& r : records)
                if (r.status == "ok" && !(r.objective >= best)) best = r.objective, before = r.parameters.at(0);
        };
        const RunResult r = optimize(problem, events);
        EXPECT_GE(levels, 2);
    }
}

TEST(ParameterValues, BoundsAreRespected) {
    Seen seen;
    const RunResult r = optimize(with_alpha(0.5, 1, &seen), {});
    EXPECT_TRUE(r.is_done()) << r.reason;
    EXPECT_EQ(alpha_of(r), 0.2) << r.reason;
    EXPECT_NE(r.reason.find("alpha at its max"), std::string::npos) << r.reason;
    EXPECT_GE(seen.least, 0);
    EXPECT_LE(seen.most, 0.2);
    EXPECT_GT(seen.evaluations, 3);
}

TEST(ParameterValues, GradientCheckCoversThem) {
    const GradientCheck right = check_gradients(with_alpha(0.12));
    EXPECT_TRUE(right.passed()) << right.tests[0].verdict;
    Problem at_bound = with_alpha(0.12);
    at_bound.program_parameters[0].start = 0.2;
    GradientCheckOptions options;
    options.at_start = true;
    EXPECT_TRUE(check_gradients(at_bound, options).passed());
    const GradientCheck wrong = check_gradients(with_alpha(0.12, 1.05));
    EXPECT_FALSE(wrong.passed());
    EXPECT_NE(wrong.tests[0].verdict.find("wrong"), std::string::npos) << wrong.tests[0].verdict;
}

TEST(ParameterValues, AMissingDerivativeIsAFailureOrTakenByDifferences) {
    const RunResult none = optimize(with_alpha(0.12, nan), {});
    EXPECT_EQ(none.status, "evaluation_failed");
    EXPECT_NE(none.reason.find("alpha"), std::string::npos) << none.reason;
    for (const Method method : {Method::sqp, Method::mma}) {
        Problem problem = with_alpha(0.12, nan);
        problem.optimize.finite_differences = true;
        problem.optimize.method = method;
        problem.optimize.max_evaluations = 200;
        problem.parameters.split = SplitRule::sensitivity;
        const RunResult r = optimize(problem, {});
        EXPECT_TRUE(r.is_done()) << r.reason;
        EXPECT_NEAR(alpha_of(r), 0.12, 1e-3) << r.reason;
        EXPECT_LT(r.objective, 1e-5);
    }
    Problem problem = with_alpha(0.12, nan);
    problem.optimize.finite_differences = true;
    const GradientCheck check = check_gradients(problem);
    EXPECT_TRUE(check.passed()) << "the derivative by the shape is right";
    ASSERT_FALSE(check.notes.empty());
    EXPECT_NE(check.notes[0].find("alpha: not tested"), std::string::npos);
}

TEST(ParameterValues, WithoutShapeVariablesTheShapeStays) {
    Problem problem = with_alpha(0.12);
    problem.parameters.kinds.clear();
    const RunResult r = optimize(problem, {});
    EXPECT_EQ(r.status, "converged") << r.reason;
    EXPECT_EQ(r.levels.size(), 1u);
    EXPECT_EQ(r.space.size(), 1);
    EXPECT_NEAR(alpha_of(r), 0.12 + 0.05, 1e-6) << "least in alpha alone, at v = 1";
    EXPECT_LT((r.vertices - problem.surface.vertices).norm(), 1e-12);
}

TEST(ParameterValues, SweepTakesTheirValues) {
    const Problem problem = with_alpha(0.12);
    const Sweep work_integrals = sweep(problem, {{{"alpha", 0.0, 0.2, 3}}, 1});
    ASSERT_EQ(work_integrals.points.size(), 3u);
    EXPECT_DOUBLE_EQ(work_integrals.points[1].physical[0], 0.1);
    EXPECT_DOUBLE_EQ(work_integrals.points[1].x[0], 0.5);
    const double da = 0.1 - 0.12, dv = -0.05;
    EXPECT_NEAR(work_integrals.points[1].objective, 40 * dv * dv + da * da + 2 * da * dv, 1e-12);
    EXPECT_THROW(sweep(problem, {{{"alpha", 0.0, 0.3, 3}}, 1}), InvalidInput);
}

TEST(ParameterValues, WrongOnesAreRefused) {
    for (const ProgramParameter& own : std::vector<ProgramParameter>{{"a.b", 0, -1, 1, false},
                                                                     {"", 0, -1, 1, false},
                                                                     {"a", 2, -1, 1, false},
                                                                     {"a", 1, 1, 1, false},
                                                                     {"a", 0, nan, 1, false}}) {
        Problem problem = with_alpha(0.1);
        problem.program_parameters = {own};
        EXPECT_THROW(rest_facts(problem), InvalidInput) << own.name << own.start;
    }
    Problem problem = with_alpha(0.1);
    problem.program_parameters.push_back(problem.program_parameters[0]);
    EXPECT_THROW(rest_facts(problem), InvalidInput);
    problem.program_parameters.pop_back();
    problem.quantities.push_back(target_shape_same("match", problem.surface, problem.surface));
    problem.fit = {"match"};
    EXPECT_THROW(fit(problem, {}), InvalidInput);
}

}  // namespace strake
