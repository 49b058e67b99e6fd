#include "optimize/nlp/multistart.hpp"
#include "optimize/nlp/program/finite_differences.hpp"
#include "programs.hpp"

#include <gtest/gtest.h>

using namespace strake;
using Eigen::VectorXd;

TEST(Starts, ManyFindTheLowestMinimumAndShareTheBudget) {
    const KnownProgram known = rastrigin();
    MinimizeOptions o = tight_options(Method::sqp, 4000);
    EXPECT_GT(minimize(known.program, o).best.objective, known.value + 0.9);
    o.starts = 200;
    std::vector<std::string> events;
    int calls = 0, best_calls = 0;
    o.on_event = [&](const std::string& e) {
        if (e.rfind("start ", 0) == 0) events.push_back(e);
    };
    double lowest = std::numeric_limits<double>::infinity();
    o.on_step = [&](const MinimizeStep& s) {
        ++calls;
        best_calls += s.is_best;
        EXPECT_EQ(s.is_best, s.evaluation.objective < lowest);
        lowest = std::min(lowest, s.evaluation.objective);
        return true;
    };
    const MinimizeResult r = minimize(known.program, o);
    EXPECT_NEAR(r.best.objective, known.value, 1e-6) << r.reason;
    EXPECT_EQ(r.best.objective, lowest);
    EXPECT_EQ(calls, r.evaluations);
    EXPECT_LE(calls, 4000);
    EXPECT_EQ(events.size(), 200u);
    EXPECT_NE(r.reason.find("best of 200 starts"), std::string::npos);
}

TEST(Starts, AreSeededAndWithinTheBounds) {
    NonlinearProgram p = rastrigin().program;
    p.lower[0] = p.upper[0] = p.start[0] = 4;
    const VectorXd a = random_start(p, 1, 1);
    EXPECT_EQ(a, random_start(p, 1, 1));
    EXPECT_NE(a, random_start(p, 2, 1));
    EXPECT_NE(a, random_start(p, 1, 2));
    EXPECT_EQ(a[0], 4);
    EXPECT_TRUE(a[1] >= -5 && a[1] <= 5);
    MinimizeOptions o;
    o.starts = 2;
    p.upper[1] = std::numeric_limits<double>::infinity();
    EXPECT_THROW(minimize(p, o), InvalidInput);
}

TEST(Starts, AFailingStartDoesNotEndTheOthers) {
    NonlinearProgram p = bowl().program;
    p.evaluate = [start = p.start](const VectorXd& x) {
        Evaluation s = bowl().program.evaluate(x);
        if (x == start) s.failure = "folded";
        return s;
    };
    MinimizeOptions o = tight_options(Method::sqp, 300);
    o.starts = 3;
    const MinimizeResult r = minimize(p, o);
    EXPECT_NE(r.stop, MinimizeStop::failed) << r.reason;
    EXPECT_NEAR(r.best.objective, 1, 1e-6);
}

TEST(Differences, ReachTheOptimumAndCount) {
    for (const bool central : {false, true})
        for (const KnownProgram& known : {bowl(), rosenbrock(), hock_schittkowski_71(), corner()}) {
            SCOPED_TRACE(known.name);
            NonlinearProgram p = known.program;
            int calls = 0;
            p.differentiate = nullptr;
            p.evaluate = [&](const VectorXd& x) {
                ++calls;
                EXPECT_TRUE(((x - p.lower).array() >= 0).all() && ((p.upper - x).array() >= 0).all());
                return known.program.evaluate(x);
            };
            Differences how;
            how.central = central;
            how.step = central ? 1e-4 : 1e-6;
            MinimizeOptions o = tight_options(Method::sqp, 2000);
            o.objective_tolerance = 1e-8;
            const MinimizeResult r = minimize(with_differences(p, how), o);
            EXPECT_NEAR(r.best.objective, known.value, 1e-5 * known.value) << r.reason;
            EXPECT_TRUE(r.is_feasible);
            EXPECT_EQ(r.evaluations, calls);
            EXPECT_FALSE(r.gradient_inconsistent);
            int limited = calls = 0;
            o.max_evaluations = 7;
            limited = minimize(with_differences(p, how), o).evaluations;
            EXPECT_LE(limited, 7);
            EXPECT_EQ(limited, calls);
        }
}

TEST(Differences, AreExactToTheirOrder) {
    const KnownProgram known = hock_schittkowski_71();
    const VectorXd x = vec({1, 4.2, 3.3, 5});  // at two bounds
    Evaluation right = known.program.evaluate(x);
    known.program.differentiate(x, right);
    const auto error = [&](double step, bool central) {
        Differences how;
        how.step = step;
        how.central = central;
        Evaluation s = known.program.evaluate(x);
        EXPECT_TRUE(differentiate_by_differences(with_differences(known.program, how), x, s, known.program.evaluate));
        return std::pair{(s.gradient - right.gradient).norm(), (s.jacobian - right.jacobian).norm()};
    };
    EXPECT_NEAR(error(1e-2, false).first / error(1e-3, false).first, 10, 0.5);
    EXPECT_NEAR(error(1e-2, false).second / error(1e-3, false).second, 10, 0.5);
    EXPECT_LT(error(1e-4, true).second, error(1e-4, false).second);
}

TEST(Differences, OnlyWhatIsNamedIsReplaced) {
    const KnownProgram known = hock_schittkowski_71();
    Differences how;
    how.objective = false;
    how.rows = {0, 1};
    Evaluation s = known.program.evaluate(known.optimum);
    s.gradient = VectorXd::Constant(4, 7);
    s.jacobian = Eigen::MatrixXd::Constant(2, 4, 7);
    ASSERT_TRUE(
        differentiate_by_differences(with_differences(known.program, how), known.optimum, s, known.program.evaluate));
    EXPECT_EQ(s.gradient, VectorXd::Constant(4, 7));
    EXPECT_EQ(s.jacobian.row(0), Eigen::RowVectorXd::Constant(4, 7));
    EXPECT_NEAR(s.jacobian(1, 3), known.optimum[3] / 20, 1e-4);
}

TEST(Differences, AFailingPointIsReplacedByTheOtherSide) {
    NonlinearProgram p = bowl().program;
    const VectorXd x = vec({0.1, 0.1, 0.1});
    const auto fails_above = [&](const VectorXd& at) {
        Evaluation s = bowl().program.evaluate(at);
        if (at[1] > x[1]) s.failure = "folded";
        return s;
    };
    Evaluation s = p.evaluate(x), right = s;
    p.differentiate(x, right);
    ASSERT_TRUE(differentiate_by_differences(with_differences(p, {}), x, s, fails_above));
    EXPECT_LT((s.gradient - right.gradient).norm(), 1e-2);
    const auto fails_beside = [&](const VectorXd& at) {
        Evaluation there = bowl().program.evaluate(at);
        if (at[1] != x[1]) there.failure = "folded";
        return there;
    };
    Evaluation t = p.evaluate(x);
    EXPECT_FALSE(differentiate_by_differences(with_differences(p, {}), x, t, fails_beside));
    EXPECT_EQ(t.gradient.size(), 0);
    Differences wrong;
    wrong.step = 0;
    EXPECT_THROW(with_differences(p, wrong), InvalidInput);
    wrong.step = 1e-4;
    wrong.rows = {1};
    EXPECT_THROW(with_differences(p, wrong), InvalidInput);
}

TEST(Differences, AWideStepSeesThroughNoise) {
    const KnownProgram known = bowl();
    NonlinearProgram p = known.program;
    p.differentiate = nullptr;
    p.evaluate = [&](const VectorXd& x) {
        Evaluation s = known.program.evaluate(x);
        s.objective += 1e-6 * std::sin(1e9 * x.sum());
        return s;
    };
    MinimizeOptions o;
    o.max_evaluations = 300;
    Differences how;
    how.step = 1e-2;
    how.central = true;
    EXPECT_LT(minimize(with_differences(p, how), o).best.objective, known.value + 1e-4);
    how.step = 1e-8;  // measures the noise only
    EXPECT_GT(minimize(with_differences(p, how), o).best.objective, known.value + 1e-4);
}

TEST(Methods, AreNamedInTheTable) {
    EXPECT_EQ(all_methods().size(), 18u);
    for (const MethodFacts& facts : all_methods()) {
        EXPECT_EQ(method_named(facts.name), &method_facts(facts.method));
        EXPECT_EQ(&facts - all_methods().data(), static_cast<int>(facts.method));
    }
    EXPECT_EQ(method_named("newton"), nullptr);
}

TEST(Methods, AliasesAreUnderstood) {
    for (const char* name : {"sqp", "SQP", "slsqp", "SLSQP", "LD_SLSQP", "NLOPT_LD_SLSQP", "nlopt_ld_slsqp"})
        EXPECT_EQ(method_named(name), &method_facts(Method::sqp)) << name;
    for (const char* name : {"nlopt_slsqp", "NLOPT_SLSQP"})
        EXPECT_EQ(method_named(name), &method_facts(Method::nlopt_slsqp)) << name;
    for (const char* name : {"lbfgs", "L-BFGS", "NLOPT_LD_LBFGS"})
        EXPECT_EQ(method_named(name), &method_facts(Method::lbfgs)) << name;
}
