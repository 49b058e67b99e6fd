#include "optimize/nlp/program/partial_gradient.hpp"
#include "optimize/nlp/program/methods.hpp"
#include "problems.hpp"
#include "programs.hpp"

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>
#include <algorithm>

/// Gradients by differences that are inherited and guessed as far as they are known.
namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int n = 24, coarse = 6;

/// Half of it in the metric, and a softer or stiffer part of each eigenvector: what a level meets.
struct Quadratic {
    MatrixXd metric, hessian;
    VectorXd bottom;
    std::vector<std::size_t> paid;  ///< per gradient

    Quadratic() {
        const VectorXd entries = random_vector(n * n, 3);
        const MatrixXd A = Eigen::Map<const MatrixXd>(entries.data(), n, n);
        metric = A * A.transpose() + MatrixXd::Identity(n, n);
        const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(metric);
        VectorXd times(n);
        for (int j = 0; j < n; ++j) times[j] = 1 + 0.5 * std::sin(7.0 * j);
        hessian = eigen.eigenvectors() * eigen.eigenvalues().cwiseProduct(times).asDiagonal() *
                  eigen.eigenvectors().transpose();
        // Mostly in a few directions of the metric.
        VectorXd along = 0.01 * random_vector(n, 5);
        along.tail(4).setConstant(0.5);
        bottom = eigen.eigenvectors() * along.cwiseQuotient(eigen.eigenvalues().cwiseSqrt());
    }
    VectorXd gradient(const VectorXd& x) const { return hessian * (x - bottom); }
    double at(const VectorXd& x) const { return 0.5 * (x - bottom).dot(hessian * (x - bottom)); }

    NonlinearProgram program() {
        NonlinearProgram p;
        p.start = VectorXd::Zero(n);
        p.lower = VectorXd::Constant(n, -3);
        p.upper = VectorXd::Constant(n, 3);
        p.metric = metric;
        p.evaluate = [this](const VectorXd& x) {
            Evaluation s;
            s.objective = at(x);
            return s;
        };
        p.expect = [this](const std::vector<VectorXd>& points) { paid.push_back(points.size()); };
        p.differences.emplace().step = 1e-6;
        return p;
    }
    /// Of a parent whose variables are the first `coarse` ones and their neighbours.
    MatrixXd prolongation() const {
        MatrixXd P = MatrixXd::Zero(n, coarse);
        for (int j = 0; j < n; ++j) P(j, j % coarse) = 1;
        return P;
    }
    std::optional<StartGradient> inherited(const VectorXd& x) const {
        Evaluation parent;
        parent.gradient = prolongation().transpose() * gradient(x);
        parent.jacobian.resize(0, coarse);
        return inherited_gradient(parent, {}, prolongation(), metric);
    }
};

Evaluation differentiated(const NonlinearProgram& p, const VectorXd& x, const GradientGuess& guess) {
    Evaluation s = p.evaluate(x);
    s.constraints.resize(0);
    EXPECT_TRUE(differentiate_along(p, x, s, guess, p.evaluate, p.expect));
    return s;
}

TEST(InheritedGradient, OnlyTheDetailsArePaid) {
    Quadratic q;
    const NonlinearProgram p = q.program();
    const auto known = q.inherited(p.start);
    ASSERT_TRUE(known);
    EXPECT_EQ(known->unknown_directions.cols(), n - coarse);
    EXPECT_LT((q.prolongation().transpose() * (known->gradient - q.gradient(p.start))).norm(), 1e-9);
    const Evaluation s =
        differentiated(p, p.start, {known->gradient, known->jacobian, known->unknown_directions, q.metric, true});
    EXPECT_EQ(q.paid, std::vector<std::size_t>{n - coarse});
    EXPECT_LT((s.gradient - q.gradient(p.start)).norm(), 1e-3 * q.gradient(p.start).norm());
}

TEST(InheritedGradient, IsNotTakenFromALevelThatCouldDoMore) {
    Quadratic q;
    Evaluation parent;
    parent.gradient = VectorXd::Ones(n + 1);
    parent.jacobian.resize(0, n + 1);
    EXPECT_FALSE(inherited_gradient(parent, {}, MatrixXd::Ones(n, n + 1), q.metric));
    parent.gradient.resize(0);
    EXPECT_FALSE(inherited_gradient(parent, {}, q.prolongation(), q.metric));
}

TEST(PartialGradient, VariablesAtTheirBoundsAreDifferentiatedInward) {
    Quadratic q;
    NonlinearProgram p = q.program();
    VectorXd x = random_vector(n, 9);
    for (const int j : {2, 7, 11}) p.upper[j] = x[j];
    for (const int j : {3, 8}) p.lower[j] = x[j];
    int outside = 0;
    p.evaluate = [&, evaluate = p.evaluate](const VectorXd& at) {
        outside += (at.array() > p.upper.array()).any() || (at.array() < p.lower.array()).any();
        return evaluate(at);
    };
    const Evaluation s = differentiated(
        p, x,
        {VectorXd::Zero(n), MatrixXd(0, n), MatrixXd::Identity(n, n) + 0.1 * MatrixXd::Ones(n, n), q.metric, true});
    EXPECT_EQ(outside, 0);
    EXPECT_LT((s.gradient - q.gradient(x)).norm(), 1e-3 * q.gradient(x).norm());
}

TEST(PartialGradient, PointsThatFailAreReplacedByTheirOtherSides) {
    Quadratic q;
    NonlinearProgram p = q.program();
    const VectorXd x = random_vector(n, 4);
    p.evaluate = [&, evaluate = p.evaluate](const VectorXd& at) {
        Evaluation s = evaluate(at);
        if (at[5] > x[5]) s.failure = "too far";
        return s;
    };
    const GradientGuess all{VectorXd::Zero(n), MatrixXd(0, n), MatrixXd::Identity(n, n), q.metric, true};
    const Evaluation s = differentiated(p, x, all);
    EXPECT_LT((s.gradient - q.gradient(x)).norm(), 1e-3 * q.gradient(x).norm());
    p.evaluate = [&](const VectorXd&) {
        Evaluation failed;
        failed.failure = "on either side";
        return failed;
    };
    Evaluation kept;
    kept.constraints.resize(0);
    EXPECT_FALSE(differentiate_along(p, x, kept, all, p.evaluate));
    EXPECT_EQ(kept.gradient.size(), 0);
}

TEST(GradientError, GrowsWithWhatTheModelExpectsAndEndsWhereItIsPaid) {
    const Quadratic q;
    GradientError gradient_error(q.metric, {});
    EXPECT_TRUE(gradient_error.is_exact());
    gradient_error.add_change(q.gradient(VectorXd::Zero(n)));
    const std::vector<int> most = gradient_error.largest(0.9);
    EXPECT_LE(most.size(), 5u);
    EXPECT_EQ(gradient_error.largest(1).size(), std::size_t(n));
    gradient_error.clear(most);
    EXPECT_FALSE(gradient_error.is_exact());
    EXPECT_EQ(gradient_error.largest(1).size(), n - most.size());
    const GradientError handed_on(q.metric, gradient_error.remaining());
    EXPECT_FALSE(handed_on.is_exact());
    gradient_error.clear_all();
    EXPECT_TRUE(gradient_error.is_exact());
}

MinimizeResult minimized(Quadratic& q, bool inherits, double tolerance, double until = 0) {
    NonlinearProgram p = q.program();
    if (inherits) p.start_gradient = q.inherited(p.start);
    MinimizeOptions how;
    how.max_evaluations = 5000;
    how.objective_tolerance = tolerance;
    how.gained_before = q.at(p.start);
    how.on_step = [&, from = q.at(p.start)](const MinimizeStep& step) {
        return step.evaluation.objective > until * from;
    };
    return minimize(p, how);
}

TEST(PartialGradient, PaysOnlyWhatIsUnknown) {
    Quadratic q;
    const MinimizeResult partial = minimized(q, true, 1e-9, 1e-3);
    EXPECT_LT(partial.best.objective, 1e-3 * q.at(VectorXd::Zero(n)));
    EXPECT_EQ(q.paid.front(), std::size_t(n - coarse));
    EXPECT_LT(*std::min_element(q.paid.begin(), q.paid.end()), std::size_t(n) / 3);
}

/// That nothing is left to gain is believed only where the whole gradient is known.
TEST(PartialGradient, IsCompletedAtTheEnd) {
    Quadratic q;
    const MinimizeResult r = minimized(q, true, 1e-4);
    EXPECT_EQ(r.stop, MinimizeStop::converged) << r.reason;
    EXPECT_FALSE(r.best.is_partly_guessed);
    EXPECT_EQ(r.gradient_error.cols(), 0);
    EXPECT_LT((r.best.gradient - q.gradient(r.x)).norm(), 1e-3 * q.gradient(VectorXd::Zero(n)).norm());
    EXPECT_LT(q.at(r.x), 1e-3 * q.at(VectorXd::Zero(n)));
}

/// What is left for something else pays nothing at the point where it is left: its gradient is what the model and the
/// values say, exact along the last step, with its error.
TEST(PartialGradient, ASearchThatIsLeftPaysNoFurtherDifferences) {
    Quadratic q;
    const NonlinearProgram p = q.program();
    MinimizeOptions how;
    how.max_evaluations = 5000;
    int points = 0;
    std::vector<VectorXd> bests{p.start};
    how.on_step = [&](const MinimizeStep& step) {
        if (step.is_best) bests.push_back(step.x);
        return true;
    };
    std::vector<VectorXd> accepted{p.start};
    how.before_differences = [&] {
        accepted.push_back(bests.back());
        return ++points < 2;
    };
    const MinimizeResult r = minimize(p, how);
    EXPECT_EQ(r.stop, MinimizeStop::outpaced) << r.reason;
    ASSERT_EQ(points, 2);
    EXPECT_EQ(std::ranges::count(q.paid, std::size_t(n)), 2) << "at the start and after the first step";
    EXPECT_EQ(r.x, accepted.back());
    EXPECT_TRUE(r.best.is_partly_guessed);
    ASSERT_EQ(r.best.gradient.size(), n);
    const VectorXd d = accepted[2] - accepted[1];
    EXPECT_NEAR(r.best.gradient.dot(d), q.gradient(r.x).dot(d), 1e-4 * std::abs(q.gradient(accepted[1]).dot(d)));
    EXPECT_GT(r.gradient_error.cols(), 0);
    EXPECT_GT((r.best.gradient - q.gradient(r.x)).norm(), 1e-3 * q.gradient(r.x).norm()) << "a guess elsewhere";
}

/// x + d misses a bound by rounding where d = bound - x: the search is where it has evaluated, not beside it, or what
/// is paid there at the end would not be part of the best point.
TEST(PartialGradient, IsCompletedAtBoundsThatRoundingMisses) {
    int at_bounds = 0;
    for (const double bound : {0.1, 0.07, 0.013, 0.0301}) {
        SCOPED_TRACE(bound);
        Quadratic q;
        NonlinearProgram p = q.program();
        for (int j = 0; j < n; ++j) p.lower[j] = -bound * (1 + 0.1 * j), p.upper[j] = bound * (1 + 0.07 * j);
        p.start = 0.37 * p.upper;
        p.start_gradient = q.inherited(p.start);
        MinimizeOptions how;
        how.max_evaluations = 5000;
        how.objective_tolerance = 1e-4;
        const MinimizeResult r = minimize(p, how);
        EXPECT_EQ(r.stop, MinimizeStop::converged) << r.reason;
        at_bounds += r.active_bounds;
        EXPECT_FALSE(r.best.is_partly_guessed);
        ASSERT_EQ(r.best.gradient.size(), n);
        EXPECT_LT((r.best.gradient - q.gradient(r.x)).norm(), 1e-3 * q.gradient(p.start).norm());
    }
    EXPECT_GT(at_bounds, 0) << "else nothing is shown";
}

}  // namespace
}  // namespace strake
