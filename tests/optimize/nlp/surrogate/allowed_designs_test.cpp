#include "optimize/nlp/surrogate/allowed_designs.hpp"

#include <gtest/gtest.h>
#include <cmath>

namespace strake {
namespace {

using Eigen::VectorXd;

/// |x| <= 1 is known exactly, there is no shape beyond |x| = 4, and the limit of motion is x0 + x1 / 4 >= 0.9: what
/// is left is a narrow piece of the circle.
struct CircleAndLine {
    NonlinearProgram program;
    MinimizeOptions options;
    VectorXd normal = Eigen::Vector2d(-1, -0.25);
    VectorXd from = Eigen::Vector2d(0.95, 0.1);

    CircleAndLine() {
        program.start = VectorXd::Zero(2);
        program.lower = VectorXd::Constant(2, -20);
        program.upper = VectorXd::Constant(2, 20);
        program.num_inequalities = 1;
        NonlinearProgram cheap = program;
        cheap.evaluate = [](const VectorXd& x) {
            Evaluation at;
            if (x.norm() > 4) at.failure = "no shape";
            at.objective = 0;
            at.constraints = VectorXd::Constant(1, 0.5 * (x.squaredNorm() - 1));
            return at;
        };
        cheap.differentiate = [](const VectorXd& x, Evaluation& at) {
            at.gradient = VectorXd::Zero(2);
            at.jacobian = x.transpose();
        };
        program.low_fidelity = LowFidelity{
            std::make_shared<const NonlinearProgram>(cheap), {LowFidelityValue::none, LowFidelityValue::same}, nullptr};
        program.is_defined = [](const VectorXd& x) { return x.norm() <= 4; };
        program.within = [this](const VectorXd& x) -> VectorXd {
            return x - std::max(0.0, beyond(x)) / normal.squaredNorm() * normal;
        };
        program.beyond = [this](const VectorXd& from, const VectorXd& to) {
            StepLimits limits;
            if (beyond(to) <= 1e-12) return limits;
            limits.values = VectorXd::Constant(1, beyond(from));
            limits.slopes = normal.transpose();
            return limits;
        };
    }
    double beyond(const VectorXd& x) const { return normal.dot(x) + 0.9; }
    double missed(const VectorXd& x) const { return 0.5 * (x.squaredNorm() - 1); }
    /// Where the circle and the line meet, above.
    VectorXd corner() const {
        const double n2 = normal.squaredNorm(), along = std::sqrt(1 - 0.81 / n2);
        return -0.9 / n2 * normal + along / std::sqrt(n2) * Eigen::Vector2d(normal[1], -normal[0]);
    }
};

/// What a search by models leads back from: the design that it looks from, beside the circle by more than rounding.
TEST(AllowedDesigns, TellWhetherTheSearchStandsBesideAnExactLimit) {
    CircleAndLine both;
    Guard guard(both.program, both.options);
    AllowedDesigns allowed(guard);
    const VectorXd beside = Eigen::Vector2d(1.001, 0.1), inside = Eigen::Vector2d(0.95, 0.1);
    EXPECT_FALSE(allowed.is_beside(beside)) << "nothing is known yet";
    allowed.look_from(beside);
    EXPECT_TRUE(allowed.is_beside(beside));
    EXPECT_FALSE(allowed.is_beside(inside)) << "one looks from elsewhere";
    allowed.look_from(inside);
    EXPECT_FALSE(allowed.is_beside(inside));
}

TEST(AllowedDesigns, BothLimitsAreMetTogether) {
    CircleAndLine both;
    Guard guard(both.program, both.options);
    AllowedDesigns allowed(guard);
    allowed.look_from(both.from);
    ASSERT_TRUE(allowed.knows_slopes());
    const VectorXd asked = Eigen::Vector2d(0.54, 1.04);
    const VectorXd nearest = allowed.nearest(asked), by_turns = allowed.nearest_by_turns(asked);
    EXPECT_LE(both.missed(nearest), 0.5e-6);
    EXPECT_LE(both.beyond(nearest), 1e-9);
    EXPECT_LT((nearest - both.corner()).norm(), 1e-4) << nearest.transpose() << "; " << both.corner().transpose();
    EXPECT_GT(both.missed(by_turns), 1e-5) << "else this shows nothing";
    EXPECT_LE(both.missed(by_turns), both.missed(both.program.within(asked)));
}

TEST(AllowedDesigns, WhatOneLimitAllowsTheOtherDecides) {
    CircleAndLine both;
    Guard guard(both.program, both.options);
    AllowedDesigns allowed(guard);
    allowed.look_from(both.from);
    const VectorXd within = Eigen::Vector2d(0.93, 0.2), beyond_line = Eigen::Vector2d(0.4, -0.1);
    EXPECT_EQ(allowed.nearest(within), within);
    EXPECT_LT((allowed.nearest(beyond_line) - both.program.within(beyond_line)).norm(), 1e-12);
    EXPECT_LT((allowed.nearest(Eigen::Vector2d(1.6, 0.2)) - VectorXd(Eigen::Vector2d(8, 1) / std::sqrt(65))).norm(),
              1e-2);
}

/// In a metric that is none of distances the nearest is another one, and still allowed.
TEST(AllowedDesigns, TheMetricDecidesWhatIsNearest) {
    CircleAndLine both;
    both.program.metric = (Eigen::Matrix2d() << 2, 0.5, 0.5, 1).finished();
    Guard guard(both.program, both.options);
    AllowedDesigns allowed(guard);
    allowed.look_from(both.from);
    for (int k = 0; k < 24; ++k) {
        const double turn = 0.26 * k;
        const VectorXd asked = (1.5 + 0.05 * k) * Eigen::Vector2d(std::cos(turn), std::sin(turn));
        const VectorXd nearest = allowed.nearest(asked), way = asked - nearest;
        EXPECT_LE(both.missed(nearest), 0.5e-6) << k;
        EXPECT_LE(both.beyond(nearest), 1e-9) << k;
        const double distance = std::sqrt(way.dot(both.program.metric * way));
        for (int j = 0; j < 2000; ++j) {
            const double angle = M_PI * j / 1000;
            const VectorXd other = Eigen::Vector2d(std::cos(angle), std::sin(angle));
            if (both.beyond(other) > 0) continue;
            const VectorXd to_other = asked - other;
            EXPECT_LE(distance, 1.1 * std::sqrt(to_other.dot(both.program.metric * to_other)))
                << k << ": " << other.transpose();
        }
    }
}

TEST(AllowedDesigns, WithoutAShapeTheWayIsShortened) {
    CircleAndLine both;
    Guard guard(both.program, both.options);
    AllowedDesigns allowed(guard);
    const VectorXd far = both.from + VectorXd(Eigen::Vector2d(10, 0));
    allowed.look_from(both.from);
    const VectorXd there = allowed.with_shape(far).x;
    EXPECT_LT((there - both.from - VectorXd(Eigen::Vector2d(10 * 0.6 * 0.6 * 0.6, 0))).norm(), 1e-12)
        << there.transpose();
    EXPECT_LE(both.missed(allowed.nearest(far)), 0.5e-6);
    const VectorXd shape = Eigen::Vector2d(2, 1);
    EXPECT_EQ(allowed.with_shape(shape).x, shape);
    EXPECT_FALSE(allowed.with_shape(shape).is_shortened);
    EXPECT_TRUE(allowed.with_shape(far).is_shortened);
}

/// x0^2 + x1^2 = 1 under the same limit, also from where neither is met.
TEST(AllowedDesigns, EqualitiesAreMetFromAnywhere) {
    CircleAndLine both;
    both.program.num_inequalities = 0, both.program.num_equalities = 1;
    for (const VectorXd& from : {both.from, VectorXd(Eigen::Vector2d(0.5, -0.3))}) {
        Guard guard(both.program, both.options);
        AllowedDesigns allowed(guard);
        allowed.look_from(from);
        for (const VectorXd& asked : {VectorXd(Eigen::Vector2d(0.92, 0.2)), VectorXd(Eigen::Vector2d(2, 1)),
                                      VectorXd(Eigen::Vector2d(0.4, -0.9))}) {
            const VectorXd nearest = allowed.nearest(asked);
            EXPECT_LE(std::abs(both.missed(nearest)), 0.5e-6) << asked.transpose();
            EXPECT_LE(both.beyond(nearest), 1e-9) << asked.transpose();
        }
    }
}

/// The cheap program fails by chance where one looks from: it is asked again.
TEST(AllowedDesigns, WhatFailedByChanceIsAskedAgain) {
    CircleAndLine both;
    NonlinearProgram cheap = *both.program.low_fidelity->program;
    int calls = 0;
    cheap.evaluate = [&, inner = cheap.evaluate](const VectorXd& x) {
        Evaluation at = inner(x);
        if (++calls == 1) at.failure = "by chance";
        return at;
    };
    both.program.low_fidelity->program = std::make_shared<const NonlinearProgram>(cheap);
    Guard guard(both.program, both.options);
    AllowedDesigns allowed(guard);
    allowed.look_from(both.from);
    EXPECT_FALSE(allowed.knows_slopes());
    allowed.look_from(both.from);
    EXPECT_TRUE(allowed.knows_slopes());
    allowed.look_from(both.from);
    EXPECT_EQ(calls, 2);
}

}  // namespace
}  // namespace strake
