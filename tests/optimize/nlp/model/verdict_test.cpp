#include "programs.hpp"

#include <gtest/gtest.h>

using namespace strake;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

bool says(const MinimizeResult& r, const std::string& words) { return r.reason.find(words) != std::string::npos; }

/// min |x - (2, 1)|^2 within linear constraints a.x <= b (rows: a, b).
NonlinearProgram projection(const MatrixXd& rows, const VectorXd& start) {
    const VectorXd at = vec({2, 1});
    const MatrixXd a = rows.leftCols(2);
    const VectorXd b = rows.col(2);
    return program_of(
        start, VectorXd::Constant(2, -3), VectorXd::Constant(2, 3), static_cast<int>(rows.rows()), 0,
        [=](const VectorXd& x) {
            VectorXd v(1 + b.size());
            v << 1 + (x - at).squaredNorm(), a * x - b;
            return v;
        },
        [=](const VectorXd& x) {
            MatrixXd g(1 + b.size(), 2);
            g << 2 * (x - at).transpose(), a;
            return g;
        });
}

MatrixXd rows_of(std::initializer_list<std::initializer_list<double>> rows) {
    MatrixXd m(rows.size(), 3);
    Eigen::Index i = 0;
    for (const auto& row : rows) m.row(i++) = vec(row).transpose();
    return m;
}

/// With the gradient of the objective (or of a constraint) times a factor.
NonlinearProgram with_wrong_gradient(NonlinearProgram p, int row, double factor) {
    const auto right = p.differentiate;
    p.differentiate = [=](const VectorXd& x, Evaluation& s) {
        right(x, s);
        if (row < 0)
            s.gradient *= factor;
        else
            s.jacobian.row(row) *= factor;
    };
    return p;
}

}  // namespace

TEST(Verdict, AWrongGradientIsNamedAndMeasured) {
    for (const Method method : {Method::sqp, Method::mma, Method::lbfgs, Method::var2}) {
        SCOPED_TRACE(method_facts(method).name);
        const NonlinearProgram p = with_wrong_gradient(rosenbrock().program, -1, -1 / 0.52);
        const MinimizeResult r = minimize(p, tight_options(method, 500));
        EXPECT_TRUE(r.gradient_inconsistent) << r.reason;
        EXPECT_NEAR(r.slope_ratio, -0.52, 0.01);
        EXPECT_EQ(r.slope_of, -1);
        EXPECT_TRUE(says(r, "inconsistent") && says(r, "-0.52 of what")) << r.reason;
        EXPECT_NE(r.stop, MinimizeStop::converged);
    }
}

TEST(Verdict, TheConstraintWithTheWrongGradientIsNamed) {
    const NonlinearProgram p = with_wrong_gradient(hock_schittkowski_71().program, 1, -0.5);
    const MinimizeResult r = minimize(p, tight_options(Method::sqp, 500));
    EXPECT_TRUE(r.gradient_inconsistent) << r.reason;
    EXPECT_EQ(r.slope_of, 1);
    EXPECT_NEAR(r.slope_ratio, -2, 0.05);
}

TEST(Verdict, ARightGradientIsNotAccused) {
    for (const MethodFacts& method : all_methods())
        for (const KnownProgram& known : {bowl(), rosenbrock(), hock_schittkowski_71(), corner()}) {
            MinimizeOptions o = tight_options(method.method, 1000);
            o.objective_tolerance = o.step_tolerance = 0;  // down to what rounding leaves
            EXPECT_FALSE(minimize(known.program, o).gradient_inconsistent) << method.name << " " << known.name;
        }
}

TEST(Verdict, AnInfeasibleStartReachesTheFeasibleOptimum) {
    const NonlinearProgram p = projection(rows_of({{1, 1, -2}, {-1, 1, 1}}), vec({2.5, 2.5}));
    for (const MethodFacts& method : all_methods()) {
        SCOPED_TRACE(method.name);
        const MinimizeResult r = minimize(p, tight_options(method.method, 6000));
        EXPECT_TRUE(r.is_feasible) << r.reason;
        EXPECT_LT((r.x - vec({-0.5, -1.5})).norm(), 1e-2) << r.x.transpose() << " " << r.reason;
        EXPECT_TRUE(r.conflict.empty());
    }
}

TEST(Verdict, ExactlyTheConflictingPairIsNamed) {
    // x + y <= -1 and x + y >= 1 exclude each other; x - y <= 1 is met and can be.
    for (const MatrixXd& rows :
         {rows_of({{1, 1, -1}, {1, -1, 1}, {-1, -1, -1}}), rows_of({{1, 1, -1}, {1, -1, -0.5}, {-1, -1, -1.5}})})
        for (const MethodFacts& method : all_methods()) {
            SCOPED_TRACE(method.name);
            const MinimizeResult r = minimize(projection(rows, vec({0.2, 0.4})), tight_options(method.method, 6000));
            EXPECT_FALSE(r.is_feasible);
            EXPECT_EQ(r.conflict, (std::vector<int>{0, 2})) << r.reason;
            EXPECT_TRUE(says(r, "constraints 0, 2 are in conflict")) << r.reason;
            EXPECT_NE(r.stop, MinimizeStop::converged);
        }
}

TEST(Verdict, AConstraintThatTheBoundsExcludeIsNamedAlone) {
    const MatrixXd rows = rows_of({{1, -1, 1}, {-1, -1, -7}});
    const MinimizeResult r = minimize(projection(rows, vec({0, 0})), tight_options(Method::sqp, 300));
    EXPECT_EQ(r.conflict, std::vector<int>{1}) << r.reason;
    EXPECT_TRUE(says(r, "cannot be met within the bounds"));
}

TEST(Verdict, ADiscAndALineBeyondItAreInConflict) {
    const NonlinearProgram p = program_of(
        vec({-2, 0.5}), VectorXd::Constant(2, -3), VectorXd::Constant(2, 3), 2, 1,
        [](const VectorXd& x) {
            return vec({1 + x[0], x.squaredNorm() - 1, x[0] - 2, x[0] + x[1] - 2});
        },
        [](const VectorXd& x) {
            MatrixXd g(4, 2);
            g << 1, 0, 2 * x[0], 2 * x[1], 1, 0, 1, 1;
            return g;
        });
    const MinimizeResult r = minimize(p, tight_options(Method::sqp, 500));
    EXPECT_EQ(r.conflict, (std::vector<int>{0, 2})) << r.reason;
    EXPECT_GT(r.violation, 0.1);
}

TEST(Verdict, EverythingAtBoundsIsCounted) {
    const MinimizeResult r = minimize(corner().program, tight_options(Method::sqp, 100));
    EXPECT_EQ(r.stop, MinimizeStop::converged);
    EXPECT_EQ(r.active_bounds, 3);
    // One of three at a bound that does not push: not counted.
    KnownProgram known = bowl();
    known.program.upper[0] = known.optimum[0];
    known.program.upper[2] = 0.1;
    EXPECT_EQ(minimize(known.program, tight_options(Method::sqp, 300)).active_bounds, 1);
}

TEST(Verdict, ABudgetTooSmallIsNamed) {
    for (const MethodFacts& method : all_methods()) {
        const MinimizeResult r = minimize(rosenbrock().program, tight_options(method.method, 9));
        EXPECT_EQ(r.stop, MinimizeStop::evaluations) << method.name << " " << r.reason;
        EXPECT_TRUE(says(r, "limit of evaluations is reached (9)")) << r.reason;
        EXPECT_FALSE(r.gradient_inconsistent);
    }
}

TEST(Verdict, ATrueOptimumIsConvergedWithoutReservations) {
    const MinimizeResult r = minimize(hock_schittkowski_71().program, tight_options(Method::sqp, 200));
    EXPECT_EQ(r.stop, MinimizeStop::converged) << r.reason;
    EXPECT_FALSE(r.gradient_inconsistent || r.is_flat);
    EXPECT_TRUE(r.conflict.empty());
    EXPECT_EQ(r.active_bounds, 1);  // x_1 = 1
}

/// A soft direction in which long steps fail, and along which next to nothing is left to gain; next to the optimum all
/// steps fail.
TEST(Verdict, WhereShortStepsFailTheGradientIsNotAccused) {
    // Beyond the wall nothing has a value, however short the step; before it the gradient is right.
    constexpr double wall = 0.5;
    NonlinearProgram p = program_of(
        vec({1, 1}), VectorXd::Constant(2, -3), VectorXd::Constant(2, 3), 0, 0,
        [](const VectorXd& x) { return vec({x[0] + x[1] * x[1]}); },
        [](const VectorXd& x) {
            MatrixXd g(1, 2);
            g << 1, 2 * x[1];
            return g;
        });
    p.evaluate = [sound = p.evaluate](const VectorXd& x) {
        Evaluation s = sound(x);
        if (x[0] < wall) s.failure = "buckled", s.is_of_step = true;
        return s;
    };
    for (const double first_step : {0.5, 1e-2, 1e-3, 1e-4}) {
        SCOPED_TRACE(first_step);
        p.start = vec({first_step < 0.1 ? wall + 1e-9 : 1, 1});
        MinimizeOptions options;
        options.first_step = first_step;
        const MinimizeResult r = minimize(p, options);
        EXPECT_EQ(r.stop, MinimizeStop::no_valid_step) << r.reason;
        EXPECT_NE(r.reason.find("the last failure: buckled"), std::string::npos) << r.reason;
    }
}

TEST(Verdict, WhereFailuresOnlyKeepFromNothingTheSearchHasConverged) {
    constexpr double soft = 1e-9, good = 1 + 1e-7;
    NonlinearProgram p = program_of(
        vec({1, 1}), VectorXd::Constant(2, -3), VectorXd::Constant(2, 3), 0, 0,
        [](const VectorXd& x) { return vec({1 + x[0] * x[0] + std::pow(x[0], 4) + soft * x[1] * x[1]}); },
        [](const VectorXd& x) {
            MatrixXd g(1, 2);
            g << 2 * x[0] + 4 * std::pow(x[0], 3), 2 * soft * x[1];
            return g;
        });
    p.hessian = vec({2, 2 * soft}).asDiagonal();
    for (const double room : {0.3, 0.03, 0.003}) {
        SCOPED_TRACE(room);
        NonlinearProgram failing = p;
        VectorXd reached;
        failing.evaluate = [&, sound = p.evaluate](const VectorXd& x) {
            Evaluation s = sound(x);
            if (std::abs(x[1] - 1) > room || (reached.size() > 0 && x != reached))
                s.failure = "buckled", s.is_of_step = true;
            if (s.failure.empty() && s.objective < good) reached = x;
            return s;
        };
        const MinimizeResult r = minimize(failing, MinimizeOptions{});
        EXPECT_EQ(r.stop, MinimizeStop::converged) << r.reason;
        EXPECT_GT(r.failures, 0);
        EXPECT_EQ(r.x, reached);
        EXPECT_LE(r.evaluations, 30);
    }
    // Where much is left beyond the failures, it has not.
    p.evaluate = [sound = p.evaluate](const VectorXd& x) {
        Evaluation s = sound(x);
        if (x[0] < 0.5) s.failure = "buckled";
        return s;
    };
    const MinimizeResult r = minimize(p, MinimizeOptions{});
    EXPECT_EQ(r.stop, MinimizeStop::no_valid_step) << r.reason;
}
