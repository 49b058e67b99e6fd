#include "optimize/nlp/surrogate/model_minimum.hpp"

#include "derivatives.hpp"
#include "programs.hpp"

#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>

/// Minima of models in the directions that few points tell of, beside those in all variables.
namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int n = 40, num_points = 16;

/// A bowl under one limit that models tell, in a metric that couples neighbours.
struct FewPoints {
    NonlinearProgram program;
    MinimizeOptions options;
    ProposalRegion region;

    explicit FewPoints(double bound) {
        program.start = VectorXd::Zero(n);
        program.lower = VectorXd::Constant(n, -bound);
        program.upper = VectorXd::Constant(n, bound);
        program.num_inequalities = 1;
        program.metric = 2 * MatrixXd::Identity(n, n);
        for (int i = 0; i + 1 < n; ++i) program.metric(i, i + 1) = program.metric(i + 1, i) = 0.6;
        program.evaluate = [](const VectorXd& x) {
            Evaluation at;
            at.objective = (x.array() - 0.3).square().sum();
            at.constraints = vec({x.sum() / n + 0.2 * x.squaredNorm() - 0.05});
            return at;
        };
        region.centre = VectorXd::Zero(n);
        region.radius = 0.5;
        region.margin = vec({0.01});
        region.offset = vec({0.002});
    }

    /// What is expected at the minimum, and where it is.
    struct Found {
        double objective, constraint;
        VectorXd z, x;
    };
    Found minimum(bool in_variables, double deviations) {
        Guard guard(program, options);
        SampledPoints points(guard);
        for (int i = 0; i < num_points; ++i) {
            const VectorXd x = i == 0 ? program.start : VectorXd(0.1 * random_vector(n, static_cast<unsigned>(i)));
            points.add(x, program.evaluate(x));
        }
        const LocalModels models(points, region.centre, 0.5, true, nullptr);
        region.is_in_variables = in_variables;
        const VectorXd from = deviations > 0 ? VectorXd(0.1 * random_vector(n, 77)) : region.centre;
        const VectorXd z = model_minimum(program, points, models, region, deviations, from);
        double value = models[0].mean(z);
        if (deviations > 0) value -= deviations * std::sqrt(models[0].variance(z));
        return {value, models[1].mean(z) + region.margin[0] + region.offset[0], z, points.variables(z)};
    }
};

void expect_the_same(FewPoints& few, double deviations) {
    const FewPoints::Found all = few.minimum(true, deviations), known = few.minimum(false, deviations);
    const double start = few.program.evaluate(few.program.start).objective;
    ASSERT_TRUE(known.z.allFinite());
    EXPECT_GT(start - all.objective, 0.05 * start) << "else this shows nothing";
    // Both end once an iteration gains less than 1e-5 of all.
    EXPECT_NEAR(known.objective, all.objective, 5e-3 * (start - all.objective));
    EXPECT_LE(known.constraint, 1e-6);
    EXPECT_LE(known.z.norm(), few.region.radius * (1 + 1e-6));
}

}  // namespace

TEST(ModelMinimum, FewPointsTellOfFewDirections) {
    for (const double deviations : {0.0, 2.0}) {
        SCOPED_TRACE(deviations);
        FewPoints few(3);
        expect_the_same(few, deviations);
    }
}

/// The least value is beyond bounds that the search in known directions has to learn.
TEST(ModelMinimum, BoundsAreMetThere) {
    FewPoints free(3), bounded(0.03);
    expect_the_same(bounded, 0);
    const VectorXd x = bounded.minimum(false, 0).x;
    EXPECT_GT(free.minimum(false, 0).x.cwiseAbs().maxCoeff(), 0.04) << "else this shows nothing";
    EXPECT_GT((x.array().abs() > 0.03 - 1e-6).count(), 2);
}

/// Conditions on the step, a border of failures and tilted limits are no combinations of points.
TEST(ModelMinimum, ConditionsAreMetThere) {
    FewPoints few(3);
    const FewPoints::Found unlimited = few.minimum(false, 0);
    few.region.limits.values = vec({-0.01});
    few.region.limits.slopes = random_vector(n, 5).normalized().transpose();
    if ((few.region.limits.slopes * unlimited.z)[0] < 0) few.region.limits.slopes *= -1;
    few.region.cut = FailureCut{VectorXd::Unit(n, 3), 0.5 * unlimited.x[3]};
    few.region.tilt = 0.05 * random_vector(n, 6).transpose();
    const auto beyond = [&](const VectorXd& z) { return (few.region.limits.values + few.region.limits.slopes * z)[0]; };
    const FewPoints::Found found = few.minimum(false, 0), all = few.minimum(true, 0);
    ASSERT_GT(unlimited.x[3], 1e-3) << "else this shows nothing";
    ASSERT_GT(beyond(unlimited.z), 1e-3) << "else this shows nothing";
    EXPECT_LE(beyond(found.z), 1e-6);
    EXPECT_LE(found.x[3], few.region.cut->limit + 1e-6);
    EXPECT_LE(found.constraint + (few.region.tilt * found.z)[0], 1e-6);
    EXPECT_NEAR(found.objective, all.objective, 2e-3 * std::abs(all.objective));
}

}  // namespace strake
