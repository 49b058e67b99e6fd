#include "optimize/nlp/program/first_order.hpp"

#include "programs.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <random>

using namespace strake;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

Evaluation evaluation_at(const NonlinearProgram& p, const VectorXd& x) {
    Evaluation s = p.evaluate(x);
    p.differentiate(x, s);
    return s;
}

/// Most of a linear gain under a limit on the size of x, whose unit ball is a hundredth of what the bounds allow; the
/// metric has that shape, and its eigenvalues lie a factor of 5 000 apart. Two variables end at their bounds. Beside
/// it a limit that is one hundredth away and that nothing within the bounds reaches.
struct Swelling {
    int n = 6;
    double unit = 1;  ///< of the values
    MatrixXd metric;
    VectorXd gain;
    double limit = 2.5e-3;

    Swelling() {
        VectorXd size(n);
        size << 1e-3, 2.4e-2, 0.13, 0.14, 1.1, 4.6;
        MatrixXd basis(n, n);
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j)
                basis(i, j) = std::cos(M_PI * (i + 0.5) * j / n) * std::sqrt((j ? 2.0 : 1.0) / n);
        metric = basis * size.asDiagonal() * basis.transpose();
        gain = 0.02 * basis * vec({0.3, 0.1, 1, 0.5, 1, 1});
    }

    NonlinearProgram program() const {
        const MatrixXd M = metric;
        const VectorXd g = gain;
        const double u = unit, l = limit;
        NonlinearProgram p = program_of(
            VectorXd::Zero(n), VectorXd::Constant(n, -0.3), VectorXd::Constant(n, 0.3), 2, 0,
            [=](const VectorXd& x) {
                return vec(
                    {u * (-1 - g.dot(x) + 0.2 * std::pow(g.dot(x), 2)), 1e-4 * x.sum() - 0.0099, x.dot(M * x) / l - 1});
            },
            [=](const VectorXd& x) {
                MatrixXd slopes(3, x.size());
                slopes.row(0) = u * (-1 + 0.4 * g.dot(x)) * g.transpose();
                slopes.row(1).setConstant(1e-4);
                slopes.row(2) = 2 / l * (M * x).transpose();
                return slopes;
            });
        p.metric = metric;
        return p;
    }
};

}  // namespace

/// Problem 71 of Hock & Schittkowski has 0.55229366 (product >= 25) and 0.16146857 (sum of squares = 40), here by the
/// scaled constraints 25 and 40 times as much; its first variable is at its bound.
TEST(Multipliers, AreThoseOfTheLiteratureWhereABoundIsActive) {
    const KnownProgram hs71 = hock_schittkowski_71();
    const Evaluation s = evaluation_at(hs71.program, hs71.optimum);
    const VectorXd lambda = multipliers(hs71.program, hs71.optimum, s);
    ASSERT_EQ(lambda.size(), 2);
    EXPECT_NEAR(lambda[0], 25 * 0.55229366, 1e-5);  // the optimum is known to eight digits
    EXPECT_NEAR(lambda[1], 40 * 0.16146857, 1e-5);
    const VectorXd slope = s.gradient + s.jacobian.transpose() * lambda;
    EXPECT_GT(slope[0], 0.1);
    EXPECT_LT(slope.tail(3).lpNorm<Eigen::Infinity>(), 1e-5);
    // By all variables, as if none were held, they come out as something else.
    const VectorXd all = least_squares_multipliers(MatrixXd::Identity(4, 4), s.gradient, s.jacobian, 1,
                                                   {.rows = {0, 1}, .variables = {0, 1, 2, 3}});
    EXPECT_GT(std::abs(all[0] - lambda[0]), 0.1);
}

TEST(Multipliers, AConstraintIsNearWhereAShortStepLeads) {
    const NonlinearProgram p = Swelling().program();
    // A hundredth away, but farther than any step leads: no multiplier; the active one has all of it.
    VectorXd x = Swelling().metric.llt().solve(Swelling().gain);
    x *= std::sqrt(Swelling().limit / x.dot(Swelling().metric * x));
    const Evaluation s = evaluation_at(p, x);
    EXPECT_NEAR(s.constraints[1], 0, 1e-12);
    EXPECT_GT(s.constraints[0], -0.0101);
    const VectorXd lambda = multipliers(p, x, s);
    EXPECT_EQ(lambda[0], 0);
    EXPECT_GT(lambda[1], 0);
}

TEST(Multipliers, ASwellingUnderALimitTakesFewEvaluationsInAnyUnit) {
    VectorXd first;
    int evaluations = 0;
    for (const double unit : {1.0, 1e9, 0.0254}) {
        Swelling problem;
        problem.unit = unit;
        const MinimizeResult r = minimize(problem.program(), MinimizeOptions());
        SCOPED_TRACE(unit);
        EXPECT_EQ(r.stop, MinimizeStop::converged) << r.reason;
        EXPECT_LE(r.evaluations, 9) << r.reason;  // 7; 13 where whatever is a hundredth away counts as active
        EXPECT_LE(r.violation, 1e-6);
        if (first.size() == 0) first = r.x, evaluations = r.evaluations;
        EXPECT_EQ(r.evaluations, evaluations);
        EXPECT_LT((r.x - first).lpNorm<Eigen::Infinity>(), 1e-6);
    }
    // As far as another method gets with a tolerance that is a thousand times tighter.
    MinimizeOptions tight = tight_options(Method::mma, 2000);
    const MinimizeResult other = minimize(Swelling().program(), tight);
    const MinimizeResult own = minimize(Swelling().program(), MinimizeOptions());
    EXPECT_LT(own.best.objective, other.best.objective + 1e-6);
}

/// More motion limits are active than there are directions in which they differ, but for rounding: multipliers that
/// only cancel would make the Lagrangian's gradient huge, and the largest one is what convergence is measured by.
TEST(Multipliers, OfLimitsThatDependOnEachOtherDoNotBlowUp) {
    constexpr int n = 6, rows = 20;
    std::mt19937 random(4);
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (int round = 0; round < 20; ++round) {
        const MatrixXd plane = MatrixXd::NullaryExpr(n, 3, [&] { return uniform(random); });
        const MatrixXd weights = MatrixXd::NullaryExpr(rows, 3, [&] { return uniform(random); });
        const MatrixXd noise = MatrixXd::NullaryExpr(rows, n, [&] { return 1e-11 * uniform(random); });
        NonlinearProgram p;
        p.start = VectorXd::Zero(n);
        p.lower = VectorXd::Constant(n, -1);
        p.upper = VectorXd::Constant(n, 1);
        p.num_inequalities = 1;
        Evaluation s;
        s.gradient = VectorXd::NullaryExpr(n, [&] { return uniform(random); });
        s.constraints = VectorXd::Zero(1);
        s.jacobian = MatrixXd::NullaryExpr(1, n, [&] { return uniform(random); });
        s.limits = {VectorXd::Zero(rows), weights * plane.transpose() + noise};
        const Multipliers found = all_multipliers(p, p.start, s);
        EXPECT_GE(found.limits.minCoeff(), 0);
        EXPECT_GE(found.constraints.minCoeff(), 0);
        EXPECT_LT(found.limits.maxCoeff(), 1e6);
        // The least length over all multipliers that are not negative: no row would shorten it.
        const VectorXd left = lagrangian_gradient(p, p.start, s);
        EXPECT_LE(left.norm(), s.gradient.norm());
        EXPECT_GT((s.limits.slopes * left).minCoeff(), -1e-6);
        EXPECT_GT((s.jacobian * left)[0], -1e-6);
        EXPECT_NEAR(left.dot(left - s.gradient), 0, 1e-6);
    }
}
