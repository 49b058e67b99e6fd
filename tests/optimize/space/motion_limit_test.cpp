#include "optimize/space/motion_limit.hpp"

#include "optimize/space/rest_shell.hpp"
#include "optimize/space/scaling.hpp"
#include "problems.hpp"

#include <gtest/gtest.h>

namespace strake {
namespace {

std::shared_ptr<const RestFacts> limited(const std::function<void(Parameters&)>& set) {
    Problem problem = ellipsoid_problem(2, 1);
    set(problem.parameters);
    return rest_facts(problem);
}

}  // namespace

TEST(MotionLimit, IsADistanceFromTheDatum) {
    const auto rest = limited([](Parameters& p) { p.max_displacement = 0.01; });
    const double L = 0.01 * rest->diagonal;
    const MotionLimit limit(*rest, rest->surface.vertices);
    Points moved = rest->surface.vertices;
    EXPECT_EQ(limit.excess(moved), "");
    EXPECT_TRUE(limit.rows(moved, 0.5, 24).empty());
    moved.row(7) += L * Eigen::RowVector3d(0.6, 0, 0.8);
    EXPECT_EQ(limit.excess(moved), "");
    EXPECT_FALSE(limit.is_within(moved, 1e-6));
    EXPECT_NEAR(limit.max_use(moved, 0.9).share, 1, 1e-12);
    moved.row(7) += 1e-8 * L * Eigen::RowVector3d(0.6, 0, 0.8);
    EXPECT_NE(limit.excess(moved).find("vertex 7 is 1.00000001 % of the diagonal from its datum"), std::string::npos)
        << limit.excess(moved);
    const auto rows = limit.rows(moved, 0.5, 24);
    ASSERT_EQ(rows.size(), 1u);
    EXPECT_EQ(rows[0].vertex, 7);
    EXPECT_NEAR((rows[0].direction - Eigen::RowVector3d(0.6, 0, 0.8)).norm(), 0, 1e-9);
    EXPECT_NEAR(rows[0].value, 1e-8 * L, 1e-12 * L);
}

TEST(MotionLimit, SidesAreAlongTheNormalOfTheDatum) {
    const auto rest = limited([](Parameters& p) {
        p.max_outward = Eigen::VectorXd::Constant(162, 0.01);
        p.max_inward = Eigen::VectorXd::Constant(162, 0);
    });
    ASSERT_EQ(rest->surface.num_vertices(), 162);
    const MotionLimit limit(*rest, rest->surface.vertices);
    int top = 0;
    rest->surface.vertices.col(2).maxCoeff(&top);
    const auto moved_by = [&](double x, double z) {
        Points moved = rest->surface.vertices;
        moved.row(top) += rest->diagonal * Eigen::RowVector3d(x, 0, z);
        return moved;
    };
    EXPECT_EQ(limit.excess(moved_by(0, 0.0099)), "");
    EXPECT_NE(limit.excess(moved_by(0, 0.0101)), "");
    EXPECT_NE(limit.excess(moved_by(0, -1e-6)), "");       // inward
    EXPECT_NE(limit.excess(moved_by(0.0101, 0.001)), "");  // sideways: the larger of both limits
    EXPECT_EQ(limit.excess(moved_by(0.0099, 0.001)), "");
}

TEST(MotionLimit, WithoutOneNothingIsRefused) {
    Parameters p;
    EXPECT_TRUE(limits_motion(p));
    EXPECT_FALSE(limits_motion(with_stated_limit(p)));
    EXPECT_EQ(variable_scale(with_stated_limit(p)), 0.05);  // units stay
    p.is_limit_stated = true;
    EXPECT_TRUE(limits_motion(with_stated_limit(p)));
    p.limits_variables = true;
    EXPECT_FALSE(limits_motion(p));
}

/// Where normals cancel no side is known: the smaller limit holds in every direction.
TEST(MotionLimit, WithoutANormalTheSmallerLimitHolds) {
    const auto rest = limited([](Parameters& p) {
        p.max_outward = Eigen::VectorXd::Constant(162, 0.02);
        p.max_inward = Eigen::VectorXd::Constant(162, 0.005);
    });
    Points flat = rest->surface.vertices;  // the upper half lies on the lower one
    int rim = 0;
    flat.col(0).maxCoeff(&rim);
    ASSERT_NEAR(flat(rim, 2), 0, 1e-12);
    flat.col(2).setZero();
    const MotionLimit limit(*rest, flat);
    const auto moved_by = [&](double z) {
        Points moved = flat;
        moved(rim, 2) += z * rest->diagonal;
        return moved;
    };
    EXPECT_EQ(limit.excess(moved_by(0.0049)), "");
    EXPECT_NE(limit.excess(moved_by(0.0051)), "");
    EXPECT_NE(limit.excess(moved_by(-0.0051)), "");
}

/// No design whose surface is within the limit, to first order, is cut off; what one variable may do alone cuts most.
TEST(MotionLimit, RangesHoldEverySurfaceWithinIt) {
    Problem problem = ellipsoid_problem(2, 3);
    problem.parameters.kinds = {VariableKind::normal_load};
    problem.parameters.max_displacement = 0.01;
    const auto rest = rest_facts(problem);
    DesignSpace space = design_space(rest, 2);
    const Eigen::VectorXd alone = space.upper;
    ASSERT_EQ(alone, Eigen::VectorXd::Ones(space.size()));
    const double ratio = widen_to_limit(space);
    EXPECT_GT(ratio, 3) << "a closed body under even pressure hardly moves";
    EXPECT_EQ(ratio, space.upper.cwiseQuotient(alone).maxCoeff());
    EXPECT_EQ(space.lower, -space.upper);
    const auto shell = shell_at_rest(space);
    std::vector<Points> moved;
    design_response(space, shell.get(), [&](int, const Points& dv) { moved.push_back(dv); });
    int beyond_alone = 0;
    for (unsigned seed = 1; seed <= 200; ++seed) {
        // Long where the surface hardly moves.
        const Eigen::VectorXd x = space.metric.ldlt().solve(random_vector(space.size(), seed));
        Points sum = Points::Zero(problem.surface.num_vertices(), 3);
        for (int j = 0; j < space.size(); ++j) sum += x[j] * moved[static_cast<std::size_t>(j)];
        const double most = sum.rowwise().norm().maxCoeff() / (0.01 * rest->diagonal);
        const Eigen::VectorXd at_limit = x.cwiseAbs() / most;
        EXPECT_LE(at_limit.cwiseQuotient(space.upper).maxCoeff(), 1 + 1e-6) << seed;
        beyond_alone += at_limit.maxCoeff() > 1;
    }
    EXPECT_GT(beyond_alone, 20);
    EXPECT_EQ(widen_to_limit(space), 1) << "once is enough";
}

}  // namespace strake
