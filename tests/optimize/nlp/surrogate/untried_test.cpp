#include "optimize/nlp/surrogate/untried.hpp"

#include "optimize/nlp/minimizer.hpp"
#include "programs.hpp"

#include <gtest/gtest.h>

/// What searches by models know nothing of.
namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

NonlinearProgram free_program(int variables) {
    NonlinearProgram p;
    p.start = VectorXd::Zero(variables);
    p.lower = VectorXd::Constant(variables, -3);
    p.upper = VectorXd::Constant(variables, 3);
    return p;
}

/// A Gaussian process of c |x|^2 + slope.x at the start and along the first axes.
GaussianProcess model_of(double c, const VectorXd& slope, int axes) {
    const auto d = slope.size();
    MatrixXd points = MatrixXd::Zero(1 + 2 * axes, d);
    for (int k = 0; k < axes; ++k) points(1 + 2 * k, k) = 0.2, points(2 + 2 * k, k) = -0.4;
    const VectorXd values = c * points.rowwise().squaredNorm() + points * slope;
    GaussianProcessOptions options;
    options.group.assign(static_cast<std::size_t>(d), 0);
    options.square_about = VectorXd::Zero(d);
    return {points, values, options};
}

constexpr int variables = 27;

/// Evaluations until nine tenths of all that `of` can gain are gained; one more than the limit: never.
int needed(const Values& of, double gain, MinimizeOptions how) {
    NonlinearProgram p = free_program(variables);
    int count = 0, found = 0;
    p.evaluate = [&](const VectorXd& x) {
        Evaluation at;
        at.objective = of(x)[0];
        ++count;
        if (found == 0 && -at.objective >= 0.9 * gain) found = count;
        return at;
    };
    how.method = Method::model;
    minimize(p, how);
    return found > 0 ? found : how.max_evaluations + 1;
}

MinimizeOptions at_a_time(int batch, bool stays = false) {
    MinimizeOptions how;
    how.batch = batch;
    how.max_evaluations = 80;
    how.tries_in_order = true;
    how.stays_where_models_are_sure = stays;
    return how;
}

/// Of |x|^2 with one slope alone.
int needed_for_axis(int axis, const MinimizeOptions& how) {
    return needed([=](const VectorXd& x) { return vec({x.squaredNorm() - 1.4 * x[axis]}); }, 0.49, how);
}

}  // namespace

TEST(TriedDirections, AreThoseOfTheStepsToAllPoints) {
    const NonlinearProgram p = free_program(4);
    Guard guard(p, {});
    SampledPoints points(guard);
    Evaluation value, failure;
    value.objective = 1;
    failure.failure = "diverged";
    points.add(p.start, value);
    const MatrixXd axes = MatrixXd::Identity(4, 4);
    EXPECT_EQ(TriedDirections(points, p.start, {}, 1).first_beyond(axes), VectorXd(axes.col(0)))
        << "nothing but the start";
    points.add(vec({1e-3, 0, 0, 0}), value);
    points.add(vec({0, 0, 0.7, 0}), failure);
    const TriedDirections tried(points, p.start, {vec({0.5, 0.3, 0, 0})}, 1);
    EXPECT_FALSE(tried.are_all());
    EXPECT_NEAR(tried.share_beyond(vec({1, 2, 3, 0})), 0, 1e-15) << "whatever the lengths of steps";
    EXPECT_NEAR(tried.share_beyond(vec({3, 0, 0, -4})), 0.8, 1e-15);
    EXPECT_EQ(tried.share_beyond(VectorXd::Zero(4)), 0);
    EXPECT_NEAR((tried.first_beyond(axes) - axes.col(3)).norm(), 0, 1e-15);
    EXPECT_NEAR((TriedDirections(points, p.start, {}, 0.5).first_beyond(axes) - axes.col(1)).norm(), 0, 1e-15);
    EXPECT_NEAR(TriedDirections(points, p.start, {}, 0.5).share_beyond(axes.col(2)), 1, 1e-15) << "failed, and farther";
    EXPECT_TRUE(TriedDirections(points, p.start, {vec({0, 1, 0, 0}), vec({0, 1, 0, 1})}, 1).are_all());
    EXPECT_FALSE(TriedDirections(points, p.start, {vec({0, 1, 0, 0}), vec({0, 1, 0, 0.01})}, 1).are_all())
        << "the same line";
}

/// The first direction of which half is left, without what was tried; where none has that, what has most.
TEST(TriedDirections, GoOnWithAPartOfADirection) {
    const NonlinearProgram p = free_program(3);
    Guard guard(p, {});
    SampledPoints points(guard);
    Evaluation value;
    value.objective = 1;
    points.add(p.start, value);
    points.add(vec({1, 0.3, 0}), value);
    const VectorXd left = TriedDirections(points, p.start, {}, 1).first_beyond(MatrixXd::Identity(3, 3));
    EXPECT_NEAR((left - vec({-0.3, 1, 0}).normalized()).norm(), 0, 1e-14) << left.transpose();
    const MatrixXd turned = MatrixXd::Constant(3, 3, -2.0 / 3) + MatrixXd::Identity(3, 3);
    const VectorXd most = TriedDirections(points, p.start, {vec({0, 1, 0})}, 1).first_beyond(turned);
    EXPECT_NEAR(std::abs(most[2]), 1, 1e-14) << most.transpose();
}

/// u = c r / sqrt(d) with the curvature c = 2 of |x|^2, of which eight points without a slope leave six of fourteen
/// parts of the variance; u^2 / 2 c.
TEST(UnknownSlopes, AreAsLargeAsTheRadiusSaysTheyMayBe) {
    const VectorXd z = VectorXd::Zero(9);
    const GaussianProcess bowl = model_of(1, VectorXd::Zero(9), 4);
    const double slope = 2 * 0.6 / 3 * std::sqrt(6.0 / 14);
    EXPECT_NEAR(unknown_slope(bowl, z, 0.6), slope, 1e-6);
    EXPECT_NEAR(unknown_decrease(bowl, z, 0.6), slope * slope / 4, 1e-6);
    const GaussianProcess cap = model_of(-1, VectorXd::Zero(9), 4);
    EXPECT_EQ(unknown_slope(cap, z, 0.6), 0);
    EXPECT_EQ(unknown_decrease(cap, z, 0.6), 0);
    EXPECT_EQ(shortfall(cap, z, 0.6), 1);
}

/// Values of a parabola leave the process nearly nothing; slopes leave it enough.
TEST(UnknownSlopes, AreWhatAProcessFallsShortOf) {
    const VectorXd z = VectorXd::Zero(9);
    VectorXd slope = VectorXd::Zero(9);
    slope.head(4) << 2, -1, 1.5, 1;
    EXPECT_EQ(shortfall(model_of(1, slope, 4), z, 0.1), 1);
    slope.setConstant(1e-4);
    const GaussianProcess sure = model_of(1, slope, 4);
    ASSERT_GT(sure.scale(), 0);
    EXPECT_GT(shortfall(sure, z, 0.6), 10);
    const double deviation = sure.scale() / sure.kernel().length[0];
    EXPECT_NEAR(shortfall(sure, z, 0.6) * deviation, unknown_slope(sure, z, 0.6), 1e-12);
}

/// One evaluation for each direction and half as many again, wherever it is. Models that are sure never find most.
TEST(UnknownSlopes, OneAloneIsFoundWhereverItIs) {
    for (const int batch : {1, 2, 4, 8}) {
        int lost = 0;
        for (int axis = 0; axis < variables; axis += 2) {
            EXPECT_LE(needed_for_axis(axis, at_a_time(batch)), 1.5 * variables + batch) << batch << ", " << axis;
            lost += needed_for_axis(axis, at_a_time(batch, true)) > 80;
        }
        if (batch < 8) {
            EXPECT_GE(lost, 3) << "runs of before, " << batch;
        }
    }
}

TEST(UnknownSlopes, AreLookedForWhereFifteenDirectionsAreFlat) {
    const auto flat_first = [](const VectorXd& x) {
        double sum = x.tail(12).squaredNorm() - 1.4 * x.tail(12).sum() / std::sqrt(12);
        for (int j = 0; j < 15; ++j) sum += (j % 2 == 0 ? 0.01 : 0.02) * x[j] * x[j];
        return vec({sum});
    };
    for (const int batch : {1, 2, 4}) EXPECT_LE(needed(flat_first, 0.49, at_a_time(batch)), 64) << batch;
    EXPECT_GT(needed(flat_first, 0.49, at_a_time(1, true)), 80) << "a run of before";
}

/// One design at a time had no place for what is not known.
TEST(UnknownSlopes, AreLearnedByOneEvaluationAfterAnother) {
    const VectorXd slope = VectorXd::LinSpaced(variables, -1, 1).array().sin() * 0.4;
    const auto bowl = [&](const VectorXd& x) { return vec({x.squaredNorm() - slope.dot(x)}); };
    const double gain = slope.squaredNorm() / 4;
    EXPECT_LE(needed(bowl, gain, at_a_time(1)), 70);
    EXPECT_GT(needed(bowl, gain, at_a_time(1, true)), 80);
}

/// What fails is tried nearer and nearer, and ends.
TEST(UnknownSlopes, AreTriedNearerWhereEvaluationsFail) {
    for (const double far : {0.02, 0.1}) {
        NonlinearProgram p = free_program(variables);
        double nearest = std::numeric_limits<double>::infinity();
        p.evaluate = [&](const VectorXd& x) {
            Evaluation at;
            at.objective = x.squaredNorm() - 0.1 * x.tail(25).sum();
            if (x.tail(25).norm() <= far) return at;
            at.failure = "diverged";
            nearest = std::min(nearest, x.norm());
            return at;
        };
        MinimizeOptions how = at_a_time(2);
        how.max_evaluations = 150;
        const MinimizeResult r = minimize(p, how);
        EXPECT_LT(nearest, 2 * far);
        EXPECT_LT(r.best.objective, -0.1 * 0.5 * far) << "some of the slope up to there";
    }
}

/// The start is at upper bounds of ten variables: their slopes are asked for on the other side.
TEST(UnknownSlopes, AreAskedForOnTheOtherSideOfBounds) {
    for (const int axis : {3, 16}) {
        NonlinearProgram p = free_program(20);
        p.upper.head(10).setZero();
        p.evaluate = [&](const VectorXd& x) {
            Evaluation at;
            at.objective = x.squaredNorm() + (axis < 10 ? 1.4 : -1.4) * x[axis];
            return at;
        };
        for (const int batch : {1, 2, 4})
            EXPECT_LT(minimize(p, at_a_time(batch)).best.objective, -0.9 * 0.49) << axis << ", " << batch;
    }
}

/// What cannot be tried, as a variable that hardly moves, does not keep a search from what it knows.
TEST(UnknownSlopes, OfWhatCannotBeTriedAreLeft) {
    for (const int batch : {1, 2, 4}) {
        NonlinearProgram p = free_program(8);
        p.lower[2] = -1e-8, p.upper[2] = 1e-8;
        const VectorXd slope = VectorXd::LinSpaced(8, 0.3, 1);
        p.evaluate = [&](const VectorXd& x) {
            Evaluation at;
            at.objective = x.squaredNorm() - slope.dot(x);
            return at;
        };
        MinimizeOptions how = at_a_time(batch);
        how.max_evaluations = 120;
        const double gain = (slope.squaredNorm() - slope[2] * slope[2]) / 4;
        EXPECT_LT(minimize(p, how).best.objective, -0.95 * gain) << batch;
    }
}

/// Of more directions than evaluations only some can be tried: such a search is what it was.
TEST(UnknownSlopes, ThatAreMoreThanEvaluationsAreLeftToTheModels) {
    std::vector<VectorXd> best;
    for (const bool stays : {false, true}) {
        NonlinearProgram p = free_program(60);
        p.evaluate = [](const VectorXd& x) {
            Evaluation at;
            at.objective = x.squaredNorm() - 0.2 * x.sum();
            return at;
        };
        MinimizeOptions how = at_a_time(4, stays);
        how.max_evaluations = 40;
        best.push_back(minimize(p, how).x);
    }
    EXPECT_EQ(best[0], best[1]);
}

}  // namespace strake
