#include "optimize/nlp/surrogate/known_constraints.hpp"

#include "core/error.hpp"

#include <gtest/gtest.h>
#include <cmath>

namespace strake {
namespace {

using Eigen::VectorXd;

/// Two inequalities, of which only the first is known: |x|^2 <= 1, and its cheap program with its slope.
struct OutsideOfACircle {
    NonlinearProgram program;
    MinimizeOptions options;

    OutsideOfACircle() {
        program.start = VectorXd::Zero(2);
        program.lower = VectorXd::Constant(2, -5);
        program.upper = VectorXd::Constant(2, 5);
        program.num_inequalities = 2;
        NonlinearProgram cheap = program;
        cheap.evaluate = [](const VectorXd& x) {
            Evaluation at;
            if (x.norm() > 4) at.failure = "no shape";
            at.objective = 0;
            at.constraints = Eigen::Vector2d(0.5 * (x.squaredNorm() - 1), 7);
            return at;
        };
        cheap.differentiate = [](const VectorXd& x, Evaluation& at) {
            at.gradient = VectorXd::Zero(2);
            at.jacobian = Eigen::MatrixXd::Zero(2, 2);
            at.jacobian.row(0) = x.transpose();
        };
        program.low_fidelity = LowFidelity{std::make_shared<const NonlinearProgram>(cheap),
                                           {LowFidelityValue::none, LowFidelityValue::same, LowFidelityValue::none},
                                           nullptr};
    }
};

TEST(KnownConstraints, TellsThoseThatTheCheapProgramTells) {
    OutsideOfACircle circle;
    const Guard guard(circle.program, circle.options);
    const KnownConstraints known(guard);
    EXPECT_TRUE(known.has(0));
    EXPECT_FALSE(known.has(1));
    const auto found = known.at(Eigen::Vector2d(2, 0), true);
    ASSERT_TRUE(found && found->has_slopes());
    EXPECT_DOUBLE_EQ(found->constraints[0], 1.5);
    EXPECT_DOUBLE_EQ(found->jacobian(0, 0), 2);
    EXPECT_FALSE(known.are_met(*found)) << "the second is unknown, and does not count";
    EXPECT_TRUE(known.are_met(*known.at(Eigen::Vector2d(0.5, 0), false)));
    EXPECT_FALSE(known.at(Eigen::Vector2d(4.5, 0), true)) << "no shape";
}

/// Towards the centre: (3, 4) / 5. Along the slope at (1.2, 1.6), corrected by the values found.
TEST(KnownConstraints, TheNearestPointIsOnTheCircle) {
    OutsideOfACircle circle;
    const Guard guard(circle.program, circle.options);
    const KnownConstraints known(guard);
    const VectorXd x = Eigen::Vector2d(1.2, 1.6), nearest = known.nearest(x, *known.at(x, true));
    EXPECT_LT((nearest - VectorXd(Eigen::Vector2d(0.6, 0.8))).norm(), 0.06);
    const auto there = known.at(nearest, true);
    EXPECT_LT((known.nearest(nearest, *there) - VectorXd(Eigen::Vector2d(0.6, 0.8))).norm(), 1e-4);
    const VectorXd inside = Eigen::Vector2d(0.3, 0.1);
    EXPECT_LT((known.nearest(inside, *known.at(inside, true)) - inside).norm(), 1e-12);
}

/// c = 0.02 x0 + |x|^2 - 0.001: along its slope at 0, corrected by its values, one ends at the bounds.
TEST(KnownConstraints, WhereCurvatureOutweighsTheSlopeNothingIsViolatedMore) {
    OutsideOfACircle circle;
    NonlinearProgram cheap = *circle.program.low_fidelity->program;
    const auto value = [](const VectorXd& x) { return 0.02 * x[0] + x.squaredNorm() - 0.001; };
    cheap.evaluate = [=](const VectorXd& x) {
        Evaluation at;
        at.objective = 0;
        at.constraints = Eigen::Vector2d(value(x), 7);
        return at;
    };
    cheap.differentiate = [](const VectorXd& x, Evaluation& at) {
        at.jacobian = Eigen::MatrixXd::Zero(2, 2);
        at.jacobian.row(0) = (0.02 * VectorXd::Unit(2, 0) + 2 * x).transpose();
    };
    circle.program.low_fidelity->program = std::make_shared<const NonlinearProgram>(cheap);
    circle.program.metric = (Eigen::Matrix2d() << 2, 0.5, 0.5, 1).finished();
    const Guard guard(circle.program, circle.options);
    const KnownConstraints known(guard);
    const auto at_start = known.at(VectorXd::Zero(2), true);
    ASSERT_TRUE(at_start && at_start->has_slopes());
    for (int k = 0; k < 16; ++k) {
        const VectorXd x = 0.3 * Eigen::Vector2d(std::cos(0.4 * k), std::sin(0.4 * k));
        const VectorXd from_start = known.nearest(x, *at_start), from_there = known.nearest(x, *known.at(x, true));
        EXPECT_LE(value(from_start), value(x));
        EXPECT_LT(from_start.norm(), 1);
        EXPECT_LT(value(from_there), 0.3 * value(x)) << "its own slope is a good one";
    }
}

/// The plane x0 + x1 = 1 from (2, 0), where one may move along x0 only, and not below 1.2.
TEST(KnownConstraints, BoundsAndFixedVariablesAreKept) {
    OutsideOfACircle circle;
    circle.program.num_inequalities = 0, circle.program.num_equalities = 2;
    NonlinearProgram cheap = *circle.program.low_fidelity->program;
    cheap.evaluate = [](const VectorXd& x) {
        Evaluation at;
        at.objective = 0;
        at.constraints = Eigen::Vector2d(x.sum() - 1, 7);
        return at;
    };
    cheap.differentiate = [](const VectorXd&, Evaluation& at) { at.jacobian = Eigen::MatrixXd::Ones(2, 2); };
    circle.program.low_fidelity->program = std::make_shared<const NonlinearProgram>(cheap);
    const VectorXd x = Eigen::Vector2d(2, 0);
    circle.program.lower[1] = circle.program.upper[1] = 0;
    const Guard free_below(circle.program, circle.options);
    const KnownConstraints known(free_below);
    EXPECT_LT((known.nearest(x, *known.at(x, true)) - VectorXd(Eigen::Vector2d(1, 0))).norm(), 1e-6);
    circle.program.lower[0] = 1.2;
    const Guard bounded(circle.program, circle.options);
    const KnownConstraints within(bounded);
    EXPECT_LT((within.nearest(x, *within.at(x, true)) - VectorXd(Eigen::Vector2d(1.2, 0))).norm(), 1e-6);
}

TEST(KnownConstraints, SlopesThatFailAreNone) {
    OutsideOfACircle circle;
    NonlinearProgram cheap = *circle.program.low_fidelity->program;
    cheap.differentiate = [](const VectorXd&, Evaluation&) { throw SolverError("the adjoint did not converge"); };
    circle.program.low_fidelity->program = std::make_shared<const NonlinearProgram>(cheap);
    const VectorXd x = Eigen::Vector2d(1.2, 1.6);
    const Guard guard(circle.program, circle.options);
    const KnownConstraints known(guard);
    const auto found = known.at(x, true);
    ASSERT_TRUE(found.has_value());
    EXPECT_FALSE(found->has_slopes());
    EXPECT_DOUBLE_EQ(found->constraints[0], 1.5);
    EXPECT_EQ(known.nearest(x, *found), x);
}

TEST(KnownConstraints, WithoutSlopesNothingMoves) {
    OutsideOfACircle circle;
    NonlinearProgram cheap = *circle.program.low_fidelity->program;
    cheap.differences = Differences();
    cheap.differences->rows = {1, 0};
    circle.program.low_fidelity->program = std::make_shared<const NonlinearProgram>(cheap);
    const Guard guard(circle.program, circle.options);
    const KnownConstraints known(guard);
    const VectorXd x = Eigen::Vector2d(1.2, 1.6);
    const auto found = known.at(x, true);
    ASSERT_TRUE(found.has_value());
    EXPECT_FALSE(found->has_slopes());
    EXPECT_EQ(known.nearest(x, *found), x);
    circle.program.low_fidelity.reset();
    const Guard bare(circle.program, circle.options);
    EXPECT_FALSE(KnownConstraints(bare).at(x, true)) << "nothing is known";
}

}  // namespace
}  // namespace strake
