#include "optimize/nlp/surrogate/model_search.hpp"
#include "core/error.hpp"
#include "derivatives.hpp"
#include "optimize/nlp/surrogate/spread.hpp"
#include "programs.hpp"

#include <gtest/gtest.h>
#include <Eigen/Cholesky>
#include <algorithm>

/// method: model.
namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

NonlinearProgram by_values(NonlinearProgram p) {
    p.differentiate = nullptr;
    return p;
}

MinimizeOptions few(int evaluations, int batch = 8) {
    MinimizeOptions how;
    how.method = Method::model;
    how.max_evaluations = evaluations;
    how.batch = batch;
    return how;
}

/// A bowl of `n` variables, condition 100, whose bottom is about 1 away.
NonlinearProgram long_bowl(int n) {
    NonlinearProgram p;
    p.start = VectorXd::Zero(n);
    p.lower = VectorXd::Constant(n, -3);
    p.upper = VectorXd::Constant(n, 3);
    p.evaluate = [n](const VectorXd& x) {
        Evaluation at;
        at.objective = 0;
        for (int j = 0; j < n; ++j) {
            const double d = x[j] - (j % 2 == 0 ? 1 : -1) / std::sqrt(n);
            at.objective += std::pow(100, double(j) / n) * d * d;
        }
        return at;
    };
    return p;
}

/// A bowl under one inequality, which its cheap program tells with its slope.
NonlinearProgram bowl_under(const std::function<double(const VectorXd&)>& limit,
                            const std::function<VectorXd(const VectorXd&)>& slope) {
    NonlinearProgram p = long_bowl(6);
    p.num_inequalities = 1;
    const auto limited = [=](Evaluation at, const VectorXd& x) {
        at.constraints = vec({limit(x)});
        return at;
    };
    p.evaluate = [=, inner = p.evaluate](const VectorXd& x) { return limited(inner(x), x); };
    NonlinearProgram cheap = p;
    cheap.evaluate = [=](const VectorXd& x) {
        Evaluation none;
        none.objective = 0;
        return limited(none, x);
    };
    cheap.differentiate = [=](const VectorXd& x, Evaluation& at) {
        at.gradient = VectorXd::Zero(6);
        at.jacobian = slope(x).transpose();
    };
    p.low_fidelity = LowFidelity{
        std::make_shared<const NonlinearProgram>(cheap), {LowFidelityValue::none, LowFidelityValue::same}, nullptr};
    return p;
}

MinimizeOptions by_gradients() {
    MinimizeOptions how = few(3000);
    how.method = Method::sqp;
    return how;
}

}  // namespace

TEST(ModelSearch, FindsKnownOptimaInFewEvaluations) {
    for (const KnownProgram& known : {bowl(), corner(), hock_schittkowski_71()}) {
        MinimizeOptions how = few(100);
        how.constraint_tolerance = 1e-4;
        const MinimizeResult r = minimize(by_values(known.program), how);
        EXPECT_TRUE(r.is_feasible) << known.name;
        const double off = (r.best.objective - known.value) / std::abs(known.value);
        EXPECT_LT(off, 1e-2) << known.name << ": " << r.best.objective << " after " << r.evaluations << ": "
                             << r.reason;
    }
}

/// From 24.2 above it at the start, in 25 batches.
TEST(ModelSearch, LearnsACurvedValley) {
    const MinimizeResult r = minimize(by_values(rosenbrock().program), few(200));
    EXPECT_LT(r.best.objective - 1, 0.3) << r.reason;
}

/// A bowl that is as round as its metric: what one direction tells holds for all.
TEST(ModelSearch, ARoundBowlTakesLittleMoreThanItsSlopes) {
    constexpr int n = 27;
    NonlinearProgram p = long_bowl(n);
    p.evaluate = [](const VectorXd& x) {
        Evaluation at;
        at.objective = (x.array() - 1 / std::sqrt(n)).square().sum();
        return at;
    };
    MinimizeOptions how = few(48);
    EXPECT_LT(minimize(p, how).best.objective, 0.01);  // of 1 at the start
    how.learns_as_before = true;
    EXPECT_GT(minimize(p, how).best.objective, 0.01);
}

/// One variable after another, each without what those before it can do; those that known designs moved come last.
TEST(ModelSearch, TriesInOrderWhereItIsTold) {
    NonlinearProgram p = long_bowl(6);
    const MatrixXd mix = MatrixXd::Identity(6, 6) + 0.3 * MatrixXd::Ones(6, 6);
    p.metric = mix * mix.transpose();
    std::vector<VectorXd> evaluated;
    p.evaluate = [&, inner = p.evaluate](const VectorXd& x) {
        evaluated.push_back(x);
        return inner(x);
    };
    MinimizeOptions how = few(4, 3);
    how.tries_in_order = true;
    const auto whitened = [&](const VectorXd& x) { return VectorXd(p.metric.llt().matrixU() * x); };
    const auto axis = [&](std::size_t i) {
        const VectorXd z = whitened(evaluated.at(i));
        Eigen::Index k = 0;
        const double longest = z.cwiseAbs().maxCoeff(&k);
        return (z.cwiseAbs().array() > 1e-9 * longest).count() == 1 ? static_cast<int>(k) : -1;
    };
    minimize(p, how);
    EXPECT_EQ((std::vector<int>{axis(1), axis(2), axis(3)}), (std::vector<int>{0, 1, 2}));
    p.known = [&] {
        const VectorXd x = 0.2 * p.metric.llt().matrixU().solve(VectorXd(VectorXd::Unit(6, 0) + VectorXd::Unit(6, 1)));
        return std::vector<KnownPoint>{{x, long_bowl(6).evaluate(x)}};
    };
    how.max_evaluations = 9;
    how.batch = 8;
    evaluated.clear();
    minimize(p, how);
    std::vector<int> alone;
    for (std::size_t i = 1; i < evaluated.size(); ++i) alone.push_back(axis(i));
    EXPECT_EQ(std::ranges::count(alone, 0) + std::ranges::count(alone, 1), 0) << "the known ones are tried again";
    how.tries_in_order = false;
    p.known = nullptr;
    evaluated.clear();
    minimize(p, how);
    for (std::size_t i = 1; i < evaluated.size(); ++i) EXPECT_EQ(axis(i), -1) << i;
}

/// Half of the first batch, twice as far; the batches after it are whole.
TEST(ModelSearch, BeginsWithFewWhereItIsTold) {
    std::vector<std::vector<double>> lengths;  // of each batch
    NonlinearProgram p = long_bowl(12);
    p.expect = [&](const std::vector<VectorXd>& batch) {
        lengths.emplace_back();
        for (const VectorXd& x : batch) lengths.back().push_back(std::sqrt(x.dot(p.metric * x)));
    };
    p.metric = 4 * MatrixXd::Identity(12, 12);
    MinimizeOptions how = few(17, 8);
    how.tries_in_order = true;
    const auto first = [&](bool with_few, int batch) {
        how.begins_with_few = with_few;
        how.batch = batch;
        lengths.clear();
        minimize(p, how);
        return lengths.at(0);
    };
    const std::vector<double> whole = first(false, 8), half = first(true, 8);
    EXPECT_EQ(lengths.at(1).size(), 8u);
    EXPECT_EQ(first(true, 5).size(), 3u);
    EXPECT_EQ(first(true, 1).size(), 1u);
    EXPECT_EQ(first(true, 13).size(), 13u) << "more than there are variables";
    ASSERT_EQ(whole.size(), 8u);
    ASSERT_EQ(half.size(), 4u);
    for (std::size_t k = 0; k < half.size(); ++k) EXPECT_NEAR(half[k], 2 * whole[k], 1e-12);
}

/// Differences have no step yet.
TEST(ModelSearch, HasGainedBeforeAGradientByDifferencesIsPaid) {
    const auto left = [](Method method) {
        NonlinearProgram p = long_bowl(20);
        MinimizeOptions how = few(21);
        how.method = method;
        if (method == Method::sqp) p.differences = Differences{};
        return minimize(p, how).best.objective;
    };
    EXPECT_LT(left(Method::model), 0.6 * left(Method::sqp));
}

TEST(ModelSearch, AsksInBatchesWhosePointsDifferAndNeedsNoMoreThanTheLimit) {
    for (const int batch : {1, 3, 8}) {
        NonlinearProgram p = by_values(bowl().program);
        std::vector<std::vector<VectorXd>> asked;
        std::vector<VectorXd> evaluated;
        p.expect = [&](const std::vector<VectorXd>& points) { asked.push_back(points); };
        p.evaluate = [&, inner = p.evaluate](const VectorXd& x) {
            evaluated.push_back(x);
            return inner(x);
        };
        const MinimizeResult r = minimize(p, few(30, batch));
        EXPECT_LE(r.evaluations, 30);
        EXPECT_EQ(static_cast<int>(evaluated.size()), r.evaluations);
        std::size_t next = 1;  // after the start
        for (const auto& points : asked) {
            EXPECT_LE(static_cast<int>(points.size()), batch);
            for (std::size_t i = 0; i < points.size(); ++i) {
                ASSERT_LT(next, evaluated.size());
                EXPECT_EQ(points[i], evaluated[next++]);  // in the order of proposal
                for (std::size_t k = 0; k < i; ++k) EXPECT_GT((points[i] - points[k]).norm(), 0);
            }
        }
        EXPECT_EQ(next, evaluated.size());
    }
}

TEST(ModelSearch, GivesTheSameBitsTwice) {
    const MinimizeResult a = minimize(long_bowl(6), few(40)), b = minimize(long_bowl(6), few(40));
    EXPECT_EQ(a.x, b.x);
    EXPECT_EQ(a.best.objective, b.best.objective);
}

TEST(ModelSearch, KnownPointsCountAsIfTheyHadBeenEvaluated) {
    NonlinearProgram p = long_bowl(5);
    const auto after_one_batch = [&] { return minimize(p, few(9)).best.objective; };
    const double alone = after_one_batch();
    p.known = [&] {
        std::vector<KnownPoint> known;
        const MatrixXd cube = sobol_points(1, 60, 5);
        for (Eigen::Index i = 0; i < cube.rows(); ++i) {
            const VectorXd x = 3 * cube.row(i).array() - 1.5;
            known.push_back({x, p.evaluate(x)});
        }
        known.push_back(known.front());  // equal designs do no harm
        return known;
    };
    EXPECT_LT(after_one_batch(), 0.1 * alone);
}

TEST(ModelSearch, NoiseDoesNotEndItEarly) {
    NonlinearProgram p = long_bowl(4);
    unsigned calls = 0;
    p.evaluate = [&, inner = p.evaluate](const VectorXd& x) {
        Evaluation at = inner(x);
        at.objective += 0.01 * random_vector(1, ++calls)[0];
        return at;
    };
    const MinimizeResult r = minimize(p, few(100));
    Evaluation exact = long_bowl(4).evaluate(r.x);
    EXPECT_LT(exact.objective, 0.05);
}

TEST(ModelSearch, GoesAlongABorderOfFailures) {
    NonlinearProgram p = by_values(bowl().program);
    p.evaluate = [inner = p.evaluate](const VectorXd& x) {
        Evaluation at = inner(x);
        if (x[0] > 0.1) at.failure = "too far";
        return at;
    };
    const MinimizeResult r = minimize(p, few(100));
    // Beyond x0 = 0.1 nothing has a value: the best there is 1 + 0.09.
    EXPECT_LT(r.best.objective, 1.2) << r.reason;
    EXPECT_GT(r.failures, 0);
    EXPECT_LT(r.failures, r.evaluations / 2);
}

/// Far from linear, and to be met to 1e-6: its model alone never gets there.
TEST(ModelSearch, WhatIsKnownExactlyIsMet) {
    NonlinearProgram p = long_bowl(6);
    p.num_equalities = 1;
    const auto with_volume = [](Evaluation at, const VectorXd& x) {
        at.constraints = vec({0.1 * x.sum() + 0.3 * x.squaredNorm() + 0.2 * std::sin(2 * x[0])});
        return at;
    };
    int cheap_evaluations = 0;
    p.evaluate = [=, inner = long_bowl(6).evaluate](const VectorXd& x) { return with_volume(inner(x), x); };
    const double start = p.evaluate(p.start).objective;
    MinimizeOptions how = few(30);
    how.leaves_equations = true;  // those that values tell
    EXPECT_DOUBLE_EQ(minimize(p, how).best.objective, start) << "else it shows nothing";
    NonlinearProgram cheap = p;
    cheap.evaluate = [&](const VectorXd& x) {
        ++cheap_evaluations;
        Evaluation none;
        none.objective = 0;
        return with_volume(none, x);
    };
    p.low_fidelity = LowFidelity{
        std::make_shared<const NonlinearProgram>(cheap), {LowFidelityValue::none, LowFidelityValue::same}, nullptr};
    const MinimizeResult r = minimize(p, how);
    EXPECT_TRUE(r.is_feasible);
    EXPECT_LT(r.best.objective, 0.7 * start) << start;
    EXPECT_EQ(r.evaluations, 30);
    EXPECT_GT(cheap_evaluations, 0);
    p.low_fidelity->values[1] = LowFidelityValue::approximate;
    EXPECT_DOUBLE_EQ(minimize(p, how).best.objective, start) << "another value is none that is known";
}

/// As a wing that may be no thinner at many places, all of them at their limit at the start: along the models' slopes,
/// which few points do not tell, hardly a design keeps them.
TEST(ModelSearch, ManyLimitsThatAreKnownWithTheirSlopesAreKept) {
    constexpr int variables = 40, limits = 25;
    const auto limited = [](Evaluation at, const VectorXd& x) {
        at.constraints.resize(limits);
        at.jacobian.resize(limits, x.size());
        for (int i = 0; i < limits; ++i) {
            const VectorXd normal = VectorXd::NullaryExpr(
                x.size(), [i](Eigen::Index j) { return std::sin(1.0 + 0.7 * static_cast<double>((i + 1) * (j + 1))); });
            at.constraints[i] = 0.2 * normal.dot(x) + 0.05 * x.squaredNorm();
            at.jacobian.row(i) = (0.2 * normal + 0.1 * x).transpose();
        }
        return at;
    };
    NonlinearProgram p = long_bowl(variables);
    p.num_inequalities = limits;
    p.start.setZero();
    int kept = 0;
    p.evaluate = [&, inner = long_bowl(variables).evaluate](const VectorXd& x) {
        Evaluation at = limited(inner(x), x);
        at.jacobian.resize(0, 0);
        kept += at.constraints.maxCoeff() <= 1e-6;
        return at;
    };
    p.differentiate = nullptr;
    NonlinearProgram cheap = p;
    cheap.evaluate = [&](const VectorXd& x) {
        Evaluation none;
        none.objective = 0;
        none.constraints = limited(none, x).constraints;
        return none;
    };
    cheap.differentiate = [&](const VectorXd& x, Evaluation& at) {
        at.gradient = VectorXd::Zero(variables);
        at.jacobian = limited(at, x).jacobian;
    };
    std::vector<LowFidelityValue> known(limits + 1, LowFidelityValue::same);
    known[0] = LowFidelityValue::none;
    p.low_fidelity = LowFidelity{std::make_shared<const NonlinearProgram>(cheap), known, nullptr};
    const double start = p.evaluate(p.start).objective;
    MinimizeOptions how = few(24);
    const auto run = [&] {
        kept = 0;
        return minimize(p, how);
    };
    const MinimizeResult r = run();
    const int with_slopes = kept;
    how.limits_by_models = true;
    const MinimizeResult before = run();
    EXPECT_TRUE(r.is_feasible);
    EXPECT_GT(with_slopes, 12) << "of 24";
    EXPECT_GT(with_slopes, 2 * kept);
    EXPECT_GT(start - r.best.objective, 1.2 * (start - before.best.objective)) << start << " " << before.best.objective;
}

/// All points lie on a limit: its model has rounding for a slope. What the next search begins with has the slope
/// itself.
TEST(ModelSearch, SlopesOfKnownLimitsAreTold) {
    NonlinearProgram p = long_bowl(8);
    p.num_equalities = 1;
    VectorXd normal = VectorXd::Constant(8, 0.3);
    normal[2] = -0.5;
    p.evaluate = [=, inner = long_bowl(8).evaluate](const VectorXd& x) {
        Evaluation at = inner(x);
        at.constraints = vec({normal.dot(x)});
        return at;
    };
    NonlinearProgram cheap = p;
    cheap.differentiate = [=](const VectorXd&, Evaluation& at) {
        at.gradient = VectorXd::Zero(8);
        at.jacobian = normal.transpose();
    };
    p.low_fidelity = LowFidelity{
        std::make_shared<const NonlinearProgram>(cheap), {LowFidelityValue::none, LowFidelityValue::same}, nullptr};
    const MinimizeOptions how = few(9);
    Guard guard(p, how);
    Evaluation start;
    ASSERT_TRUE(guard.try_at(p.start, false, start));
    const ModelEnd end = minimize_by_model(guard);
    ASSERT_EQ(end.at.jacobian.rows(), 1);
    EXPECT_LT((end.at.jacobian.row(0).transpose() - normal).norm(), 1e-12) << end.at.jacobian;
    EXPECT_LT(guard.penalty, 100) << "of multipliers of rounding it would be 1e10";
}

/// As an angle of attack beside the variables of a shape: first by itself, to where there is more room; the others that
/// are tried while only the start is known are orthogonal to it.
TEST(ModelSearch, VariablesThatStandForThemselvesAreTriedAloneFirst) {
    NonlinearProgram p = long_bowl(10);
    p.start[9] = 2;
    p.metric = MatrixXd::Identity(10, 10);
    p.metric(9, 9) = 4;
    p.metric(3, 9) = p.metric(9, 3) = 0.5;
    std::vector<VectorXd> steps;
    p.evaluate = [&, inner = long_bowl(10).evaluate, start = p.start](const VectorXd& x) {
        steps.push_back(x - start);
        return inner(x);
    };
    MinimizeOptions how = few(9);
    how.first_alone = {9};
    minimize(p, how);
    ASSERT_EQ(steps.size(), 9u);
    const double length = 0.3 * how.first_step / 2;  // of 1 in the metric is 1/2 of this variable
    EXPECT_LT((steps[1] + length * VectorXd::Unit(10, 9)).norm(), 1e-12) << steps[1].transpose();
    for (std::size_t k = 2; k < steps.size(); ++k)
        EXPECT_NEAR(steps[k].dot(p.metric * steps[1]), 0, 1e-12) << "orthogonal in the metric";
    how.first_alone.clear();
    steps.clear();
    minimize(p, how);
    EXPECT_GT(steps[1].head(9).norm(), 1e-3) << "else it shows nothing";
}

/// The start is beyond a limit that is known exactly: what its model errs by says nothing, and the way to it is no end.
TEST(ModelSearch, FromBeyondKnownLimitsTheSearchGetsWithinAndGoesOn) {
    const NonlinearProgram p =
        bowl_under([](const VectorXd& x) { return 0.3 + 0.4 * x[0] + 0.1 * x.squaredNorm(); },
                   [](const VectorXd& x) { return VectorXd(0.4 * VectorXd::Unit(6, 0) + 0.2 * x); });
    const MinimizeResult r = minimize(p, few(60)), exact = minimize(p, by_gradients());
    EXPECT_TRUE(r.is_feasible) << r.reason;
    EXPECT_LT(r.best.objective, 1.02 * exact.best.objective) << exact.best.objective << ": " << r.reason;
}

/// The optimum lies where a limit of motion and one that is known exactly meet.
TEST(ModelSearch, TheLimitOfMotionAndExactLimitsAreMetTogether) {
    NonlinearProgram p = bowl_under(
        [](const VectorXd& x) { return 0.4 * x[1] + 0.3 * x[0] + 0.2 * x.squaredNorm() - 0.2; },
        [](const VectorXd& x) { return VectorXd(0.3 * VectorXd::Unit(6, 0) + 0.4 * VectorXd::Unit(6, 1) + 0.4 * x); });
    const VectorXd normal = VectorXd::Unit(6, 0) + 0.3 * VectorXd::Ones(6);
    const auto beyond = [=](const VectorXd& x) { return normal.dot(x) - 0.4; };
    p.within = [=](const VectorXd& x) -> VectorXd {
        return beyond(x) > 1e-9 ? VectorXd(x - (beyond(x) + 1e-9) / normal.squaredNorm() * normal) : x;
    };
    p.beyond = [=](const VectorXd& from, const VectorXd& to) {
        StepLimits limits;
        if (beyond(to) <= 1e-9) return limits;
        limits.values = vec({beyond(from)});
        limits.slopes = normal.transpose();
        return limits;
    };
    MinimizeOptions together = few(50), by_turns = few(50);
    by_turns.limits_by_turns = true;
    const double exact = minimize(p, by_gradients()).best.objective, start = p.evaluate(p.start).objective;
    const MinimizeResult r = minimize(p, together), before = minimize(p, by_turns);
    EXPECT_TRUE(r.is_feasible) << r.reason;
    EXPECT_GT(start - r.best.objective, 0.99 * (start - exact)) << exact << " " << start << " " << r.best.objective;
    EXPECT_GT(r.best.objective, exact - 1e-6) << "nothing beyond a limit";
    EXPECT_LT(r.best.objective, before.best.objective) << "else this shows nothing";
}

/// The last batch keeps its distance from an inequality that only a model tells.
TEST(ModelSearch, TheLastBatchMeetsAConstraintThatModelsTell) {
    for (const int evaluations : {17, 25, 33}) {
        NonlinearProgram p = long_bowl(4);
        p.num_inequalities = 1;
        double lowest = 1e300;
        int calls = 0;
        bool is_met_at_the_end = false;
        p.evaluate = [&, inner = long_bowl(4).evaluate](const VectorXd& x) {
            Evaluation at = inner(x);
            at.constraints = vec({0.4 * x[0] - 0.3 * x[1] + 0.3 * x.squaredNorm() + 0.1 * std::sin(5 * x[2]) - 0.1});
            const bool is_met = at.constraints[0] <= 1e-6;
            if (is_met) lowest = std::min(lowest, at.objective);
            if (++calls > evaluations - 8) is_met_at_the_end |= is_met;
            return at;
        };
        minimize(p, few(evaluations));
        EXPECT_TRUE(is_met_at_the_end) << evaluations;
    }
}

/// A curved equation that only values tell, to 1e-6: the search leaves it by what its models err by, and leads back.
TEST(ModelSearch, EquationsAreMetWhileTheSearchGains) {
    constexpr int n = 20;
    NonlinearProgram p = long_bowl(n);
    p.num_equalities = 1;
    p.evaluate = [inner = p.evaluate](const VectorXd& x) {
        Evaluation at = inner(x);
        at.constraints = vec({x.sum() + std::sin(x.squaredNorm()) - 0.1 * x[0] * x[1]});
        return at;
    };
    Evaluation start = p.evaluate(p.start);
    for (const int batch : {1, 8}) {
        MinimizeOptions how = few(80, batch);
        const MinimizeResult r = minimize(p, how);
        EXPECT_TRUE(r.is_feasible);
        EXPECT_LT(r.best.objective, 0.7 * start.objective) << batch << ": " << r.reason;
        EXPECT_LE(r.evaluations, 80);
        if (batch == 1) continue;  // one after another they come near to it by themselves
        how.leaves_equations = true;
        EXPECT_EQ(minimize(p, how).best.objective, start.objective) << "else this says nothing";
    }
}

/// Half of the space has no shape, the bottom of the bowl is there, and the search goes along the border.
TEST(ModelSearch, DesignsWithoutAShapeAreNotEvaluated) {
    NonlinearProgram p = long_bowl(6);
    int failed = 0;
    const auto has_shape = [](const VectorXd& x) { return x[0] - x[1] <= 0.3; };
    p.is_defined = has_shape;
    p.refusal = [has_shape](const VectorXd& x) { return std::string(has_shape(x) ? "" : "no shape"); };
    p.evaluate = [&failed, has_shape, inner = p.evaluate](const VectorXd& x) {
        Evaluation at = inner(x);
        if (!has_shape(x)) at.failure = "no shape", ++failed;
        return at;
    };
    MinimizeOptions how = few(120);
    const MinimizeResult r = minimize(p, how);
    EXPECT_EQ(failed, 0);
    EXPECT_LE(r.evaluations, 120);
    how.pays_without_shape = true;
    const MinimizeResult before = minimize(p, how);
    EXPECT_GT(failed, 0) << "else this says nothing";
    EXPECT_LT(r.best.objective, before.best.objective + 1e-3 * std::abs(before.best.objective));
}

TEST(ModelSearch, FewerEvaluationsThanVariablesStillGain) {
    const NonlinearProgram p = long_bowl(40);
    const double start = p.evaluate(p.start).objective;
    const MinimizeResult r = minimize(p, few(25));
    EXPECT_LT(r.best.objective, 0.8 * start);
    EXPECT_EQ(r.evaluations, 25);
    EXPECT_EQ(minimize(p, few(1)).evaluations, 1);
    EXPECT_EQ(minimize(p, few(3)).evaluations, 3);
}

TEST(ModelSearch, SaysWhatIsWrongWithTheProblem) {
    NonlinearProgram flat = long_bowl(3);
    flat.evaluate = [](const VectorXd&) {
        Evaluation at;
        at.objective = 4;
        return at;
    };
    const MinimizeResult constant = minimize(flat, few(60));
    EXPECT_TRUE(constant.is_flat);
    EXPECT_NE(constant.reason.find("check that it depends on the variables"), std::string::npos) << constant.reason;

    NonlinearProgram idle = long_bowl(6);  // the last two variables have no effect
    idle.evaluate = [inner = long_bowl(4).evaluate](const VectorXd& x) { return inner(x.head(4)); };
    EXPECT_LT(minimize(idle, few(80)).best.objective, 0.05);

    NonlinearProgram torn = long_bowl(2);
    torn.num_inequalities = 2;
    torn.evaluate = [inner = torn.evaluate](const VectorXd& x) {
        Evaluation at = inner(x);
        at.constraints = vec({x[0] - 0.2, 0.6 - x[0]});
        return at;
    };
    const MinimizeResult conflict = minimize(torn, few(200));
    EXPECT_FALSE(conflict.is_feasible);
    EXPECT_EQ(conflict.conflict, (std::vector<int>{0, 1})) << conflict.reason;
    EXPECT_THROW(minimize(long_bowl(2), few(10, 0)), InvalidInput);
}

}  // namespace strake
