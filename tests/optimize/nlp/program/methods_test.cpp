#include "programs.hpp"

#include <gtest/gtest.h>

using namespace strake;
using Eigen::VectorXd;

namespace {

class EveryMethod : public testing::TestWithParam<MethodFacts> {};
std::string name_of(const testing::TestParamInfo<MethodFacts>& info) { return info.param.name; }

/// What a method can be asked for: to a relative error of the objective.
double accuracy(const MethodFacts& m) { return m.needs_gradients || m.is_global ? 1e-6 : 1e-3; }

void expect_optimum(const KnownProgram& known, const MethodFacts& method, int budget) {
    SCOPED_TRACE(known.name);
    const MinimizeResult r = minimize(known.program, tight_options(method.method, budget));
    EXPECT_TRUE(r.is_feasible) << r.violation << " " << r.reason;
    EXPECT_LE(r.violation, 1e-6);
    // What the tolerance of the constraints is worth comes on top.
    const double slack = known.program.num_equalities > 0 ? 2e-6 : 0;
    EXPECT_NEAR(r.best.objective, known.value, (accuracy(method) + slack) * known.value) << r.reason;
    EXPECT_LE(r.evaluations, budget);
    if (std::getenv("STRAKE_TELL"))
        std::cout << known.name << " " << r.best.objective - known.value << " violation " << r.violation << " after "
                  << r.evaluations << ": " << r.reason << "\n";
}

}  // namespace

TEST_P(EveryMethod, FindsTheBottomOfTheBowl) { expect_optimum(bowl(), GetParam(), 3000); }

TEST_P(EveryMethod, FollowsTheValley) { expect_optimum(rosenbrock(), GetParam(), 10000); }

TEST_P(EveryMethod, MeetsInequalitiesAndEqualities) { expect_optimum(hock_schittkowski_71(), GetParam(), 20000); }

TEST_P(EveryMethod, FindsTheCornerOfTheBoundsAndCountsThem) {
    const KnownProgram known = corner();
    expect_optimum(known, GetParam(), 3000);
    const MinimizeResult r = minimize(known.program, tight_options(GetParam().method, 3000));
    EXPECT_EQ(r.active_bounds, 3) << r.x.transpose();
}

TEST_P(EveryMethod, FindsTheLowestOfManyMinimaIfItIsGlobal) {
    if (!GetParam().is_global) return;
    if (GetParam().method != Method::isres) return expect_optimum(rastrigin(), GetParam(), 6000);
    // The evolution strategy gets into the neighbourhood: one of the five lowest of about a hundred.
    const KnownProgram known = rastrigin();
    EXPECT_LT(minimize(known.program, tight_options(Method::isres, 6000)).best.objective, known.value + 1);
}

TEST_P(EveryMethod, TakesASingleVariable) {
    KnownProgram known = rosenbrock();
    known.program.lower[0] = known.program.upper[0] = known.program.start[0] = 0.5;
    const MinimizeResult r = minimize(known.program, tight_options(GetParam().method, 1000));
    EXPECT_NEAR(r.x[1], 0.25, 1e-3) << r.reason;
    EXPECT_EQ(r.x[0], 0.5);
}

TEST_P(EveryMethod, AsksWithinTheBoundsOnly) {
    for (KnownProgram known : {rosenbrock(), hock_schittkowski_71(), corner()}) {
        const NonlinearProgram p = known.program;
        known.program.evaluate = [&](const VectorXd& x) {
            EXPECT_TRUE(((x - p.lower).array() >= 0).all() && ((p.upper - x).array() >= 0).all()) << x.transpose();
            return p.evaluate(x);
        };
        minimize(known.program, tight_options(GetParam().method, 300));
    }
}

TEST_P(EveryMethod, SameBitsTwice) {
    const KnownProgram known = hock_schittkowski_71();
    const MinimizeOptions o = tight_options(GetParam().method, 700);
    const MinimizeResult a = minimize(known.program, o), b = minimize(known.program, o);
    EXPECT_EQ(a.x, b.x);
    EXPECT_EQ(a.evaluations, b.evaluations);
}

TEST_P(EveryMethod, FlatObjectiveIsToldSo) {
    KnownProgram known = bowl();
    known.program.evaluate = [](const VectorXd&) {
        Evaluation s;
        s.objective = 3;
        return s;
    };
    known.program.differentiate = [](const VectorXd& x, Evaluation& s) { s.gradient = VectorXd::Zero(x.size()); };
    const MinimizeResult r = minimize(known.program, tight_options(GetParam().method, 400));
    EXPECT_TRUE(r.is_flat);
    EXPECT_TRUE(r.reason.find("does not change") != std::string::npos ||
                r.reason.find("been the same") != std::string::npos)
        << r.reason;
}

TEST_P(EveryMethod, LimitsOfEvaluationsAndTimeHold) {
    for (const KnownProgram& known : {rosenbrock(), hock_schittkowski_71()}) {
        for (const int limit : {1, 2, 5, 8}) {
            int calls = 0;
            NonlinearProgram p = known.program;
            p.evaluate = [&](const VectorXd& x) { return ++calls, known.program.evaluate(x); };
            const MinimizeResult r = minimize(p, tight_options(GetParam().method, limit));
            EXPECT_LE(calls, limit);
            EXPECT_EQ(calls, r.evaluations);
            EXPECT_NE(r.stop, MinimizeStop::converged) << r.reason;
        }
        MinimizeOptions o = tight_options(GetParam().method, 1000000);
        o.objective_tolerance = o.step_tolerance = 0;
        o.max_seconds = 0.05;
        const auto begin = std::chrono::steady_clock::now();
        minimize(known.program, o);
        EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(), 2);
    }
}

INSTANTIATE_TEST_SUITE_P(Methods, EveryMethod, testing::ValuesIn(all_methods()), name_of);
