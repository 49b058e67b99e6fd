#include "optimize/check/gradient_check.hpp"

#include "core/error.hpp"
#include "problems.hpp"

#include <gtest/gtest.h>

#include <cstring>

namespace strake {
namespace {

const std::vector<double> ladder{1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6};

TaylorTest tested(const std::function<double(double h)>& J, double slope) {
    std::vector<double> values;
    for (const double h : ladder) values.push_back(J(h));
    return taylor_test("J", J(0), slope, std::abs(slope), ladder, values);
}

Problem checked(const std::vector<VariableKind>& kinds) {
    Problem problem = ellipsoid_problem(2, 2);
    problem.parameters.kinds = kinds;
    problem.objective = "volume";
    problem.constraints.push_back({"area", std::nullopt, 1.1, std::nullopt, true});
    TriMesh target = problem.surface;
    target.vertices = target.vertices * Eigen::Vector3d(1.05, 0.97, 1.1).asDiagonal();
    problem.quantities.push_back(target_shape_same("match", problem.surface, target));
    problem.constraints.push_back({"match", std::nullopt, 1.0, std::nullopt, false});
    return problem;
}

/// The problem's volume with its sensitivities or its value changed.
Problem spoiled(const std::function<void(const TriMesh& surface, QuantityResult& result)>& spoil) {
    Problem problem = ellipsoid_problem(2, 2);
    const auto evaluate = problem.quantities[0].evaluate;
    problem.quantities[0].evaluate = [=](const QuantityRequest& request) {
        QuantityResult result = evaluate(request);
        spoil(request.surface, result);
        return result;
    };
    problem.objective = "volume";
    return problem;
}

}  // namespace

TEST(TaylorTest, SeesTheOrderOfCurvedAndStraightFunctions) {
    const TaylorTest curved = tested([](double h) { return std::exp(0.7 * h); }, 0.7);
    EXPECT_TRUE(curved.passed) << curved.verdict;
    EXPECT_NEAR(curved.order, 2, 0.1);
    EXPECT_NEAR(curved.differences_slope, 0.7, 1e-6);
    const TaylorTest cubic = tested([](double h) { return 3 + h + h * h * h; }, 1);
    EXPECT_TRUE(cubic.passed) << cubic.verdict;
    const TaylorTest straight = tested([](double h) { return 3 + 0.2 * h; }, 0.2);
    EXPECT_TRUE(straight.passed) << straight.verdict;
    EXPECT_NE(straight.verdict.find("linear"), std::string::npos) << straight.verdict;
    EXPECT_TRUE(tested([](double) { return 5.0; }, 0).passed);
    const TaylorTest stationary = tested([](double h) { return 2 + h * h; }, 0);
    EXPECT_TRUE(stationary.passed) << stationary.verdict;
}

TEST(TaylorTest, SeesSmallErrorsBehindStrongCurvature) {
    for (const double wrong : {1.01, 1.001, 0.99, -1.0, 0.0}) {
        const TaylorTest test = tested([](double h) { return 1 + h + 50 * h * h; }, wrong);
        EXPECT_FALSE(test.passed) << wrong << ": " << test.verdict;
        EXPECT_NE(test.verdict.find("wrong"), std::string::npos) << test.verdict;
        EXPECT_NEAR(test.differences_slope, 1, 1e-5);
    }
    EXPECT_FALSE(tested([](double) { return 5.0; }, 1).passed);
    EXPECT_FALSE(tested([](double h) { return 5.0 + h; }, 0).passed);
}

TEST(TaylorTest, AcceptsAnApproximateGradientWithinTheGivenShareOnly) {
    const auto judged = [](double slope, double accept, double noise) {
        std::vector<double> values;
        int sign = 1;
        for (const double h : ladder) values.push_back(1 + h + h * h + noise * (sign = -sign));
        return taylor_test("J", 1, slope, std::abs(slope), ladder, values, accept);
    };
    EXPECT_FALSE(judged(1.05, 0, 0).passed);
    EXPECT_TRUE(judged(1.05, 0.1, 0).passed) << judged(1.05, 0.1, 0).verdict;
    EXPECT_NE(judged(1.05, 0.1, 0).verdict.find("0.1 is accepted"), std::string::npos);
    EXPECT_FALSE(judged(1.15, 0.1, 0).passed);
    EXPECT_FALSE(judged(-1, 0.1, 0).passed);
    const auto across = [](double slope, double size) {  // a direction across the gradient: the true slope is 0.01
        std::vector<double> values;
        for (const double h : ladder) values.push_back(1 + 0.01 * h + h * h);
        return taylor_test("J", 1, slope, size, ladder, values, 0.1);
    };
    EXPECT_TRUE(across(0.015, 1).passed);
    EXPECT_FALSE(across(0.015, 0.01).passed);
    EXPECT_FALSE(across(0.2, 1).passed);
    EXPECT_FALSE(judged(1.05, 0.1, 1e-2).passed) << "differences that noise hides confirm nothing";
    EXPECT_THROW(judged(1, 1, 0), InvalidInput);
}

TEST(TaylorTest, NoiseIsNotConfirmed) {
    const Eigen::VectorXd noise = random_vector(8, 3);
    for (const double amplitude : {1e-3, 1e-1}) {
        int k = 0;
        const TaylorTest test = tested([&](double h) { return 1 + h + h * h + amplitude * noise[k++ % 8]; }, 1);
        EXPECT_FALSE(test.passed) << test.verdict;
        EXPECT_NE(test.verdict.find("noisy"), std::string::npos) << test.verdict;
    }
    // Noise below what the ladder's beginning tells does no harm.
    int k = 0;
    EXPECT_TRUE(tested([&](double h) { return 1 + h + h * h + 1e-9 * noise[k++ % 8]; }, 1).passed);
}

TEST(TaylorTest, MissingStepsAreToldAndWrongInputIsRefused) {
    const double none = std::numeric_limits<double>::quiet_NaN();
    const TaylorTest few = taylor_test("J", 1, 1, 1, ladder, {none, none, none, none, 1 + 1e-5, 1 + 1e-6});
    EXPECT_FALSE(few.passed);
    EXPECT_NE(few.verdict.find("2 of 6"), std::string::npos);
    EXPECT_THROW(taylor_test("J", 1, 1, 1, {1e-1, 1e-2}, {1, 1}), InvalidInput);
    EXPECT_THROW(taylor_test("J", 1, 1, 1, {1e-1, 1e-2, 1e-2}, {1, 1, 1}), InvalidInput);
    EXPECT_THROW(taylor_test("J", none, 1, 1, ladder, std::vector<double>(6, 1)), InvalidInput);
}

TEST(GradientCheck, PassesForVolumeAreaAndTargetWithEveryKindOfVariable) {
    for (const auto& kinds : std::vector<std::vector<VariableKind>>{{VariableKind::load},
                                                                    {VariableKind::normal_load},
                                                                    {VariableKind::load, VariableKind::stiffness},
                                                                    {VariableKind::strain}})
        for (const bool at_start : {false, true}) {
            GradientCheckOptions options;
            options.at_start = at_start;
            const GradientCheck check = check_gradients(checked(kinds), options);
            ASSERT_EQ(check.tests.size(), 3u);
            EXPECT_EQ(check.level, 2);
            EXPECT_GT(check.variables, 1);
            EXPECT_EQ(check.evaluations, 7) << check.notes.size();
            for (const TaylorTest& test : check.tests) EXPECT_TRUE(test.passed) << test.name << ": " << test.verdict;
        }
}

TEST(GradientCheck, AGradientThatIsOnePercentTooLargeFails) {
    const GradientCheck check = check_gradients(spoiled([](const TriMesh&, QuantityResult& r) {
        for (auto& g : r.dJ_dv) g *= 1.01;
    }));
    ASSERT_FALSE(check.passed());
    EXPECT_NEAR(check.tests[0].slope / check.tests[0].differences_slope, 1.01, 1e-5);
    EXPECT_NE(check.tests[0].verdict.find("1.01"), std::string::npos) << check.tests[0].verdict;
}

TEST(GradientCheck, AWrongSignInOnePatchFails) {
    const GradientCheck check = check_gradients(spoiled([](const TriMesh& surface, QuantityResult& r) {
        for (auto& g : r.dJ_dv)
            for (int v = 0; v < surface.num_vertices(); ++v)
                if (surface.vertices(v, 0) > 0.5 && surface.vertices(v, 2) > 0) g.row(v) *= -1;
    }));
    EXPECT_FALSE(check.passed()) << check.tests[0].verdict;
    EXPECT_NE(check.tests[0].verdict.find("wrong"), std::string::npos) << check.tests[0].verdict;
}

TEST(GradientCheck, ANoisyValueFails) {
    const GradientCheck check = check_gradients(spoiled([](const TriMesh& surface, QuantityResult& r) {
        std::uint64_t bits = 0;
        for (int i = 0; i < surface.vertices.size(); ++i) {
            std::uint64_t word;
            std::memcpy(&word, surface.vertices.data() + i, sizeof word);
            bits = (bits ^ word) * 0x9E3779B97F4A7C15ull;
        }
        r.values[0] *= 1 + 1e-2 * (static_cast<double>(bits >> 11) * 0x1p-53 - 0.5);
    }));
    EXPECT_FALSE(check.passed());
    EXPECT_NE(check.tests[0].verdict.find("noisy"), std::string::npos) << check.tests[0].verdict;
}

TEST(GradientCheck, IsRepeatableAndRefusesWrongOptions) {
    const Problem problem = checked({VariableKind::load});
    GradientCheckOptions options;
    options.level = 1;
    const GradientCheck a = check_gradients(problem, options), b = check_gradients(problem, options);
    EXPECT_EQ(a.tests[0].steps[3].value, b.tests[0].steps[3].value);
    options.seed = 2;
    EXPECT_NE(a.tests[0].slope, check_gradients(problem, options).tests[0].slope);
    options.level = 7;
    EXPECT_THROW(check_gradients(problem, options), InvalidInput);
    options.level = 1;
    options.away = 0;
    EXPECT_THROW(check_gradients(problem, options), InvalidInput);
    Problem empty = problem;
    empty.objective.clear();
    empty.constraints.clear();
    EXPECT_THROW(check_gradients(empty), InvalidInput);
}

TEST(GradientCheck, AShapeThatIsRefusedMovesThePointTowardsTheStart) {
    GradientCheckOptions options;
    options.away = 40;
    Problem problem = checked({VariableKind::load});
    problem.parameters.max_displacement = 0.2;
    try {
        const GradientCheck check = check_gradients(problem, options);
        EXPECT_FALSE(check.notes.empty());
        EXPECT_LT(check.size, 40);
    } catch (const SolverError& error) {
        EXPECT_NE(std::string(error.what()).find("no value to begin with"), std::string::npos);
    }
}

}  // namespace strake
