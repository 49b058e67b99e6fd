#include "optimize/nlp/model/quadratic_model.hpp"

#include "derivatives.hpp"
#include "optimize/nlp/model/least_distance.hpp"

#include <gtest/gtest.h>
#include <Eigen/Dense>

using namespace strake;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

MatrixXd random_matrix(int rows, int columns, unsigned seed) {
    const VectorXd entries = random_vector(rows * columns, seed);
    return Eigen::Map<const MatrixXd>(entries.data(), rows, columns);
}

MatrixXd vec_row(std::initializer_list<double> entries) {
    return Eigen::Map<const Eigen::RowVectorXd>(entries.begin(), static_cast<Eigen::Index>(entries.size()));
}

QuadraticModel random_model(int n, int rows, int inequalities, double hessian_scale, unsigned seed) {
    QuadraticModel m;
    const MatrixXd R = random_matrix(n, n, seed);
    m.hessian = hessian_scale * (R * R.transpose() / n + 0.01 * MatrixXd::Identity(n, n));
    m.gradient = random_vector(n, seed + 1);
    m.lower = VectorXd::Constant(n, -0.5);
    m.upper = VectorXd::Constant(n, 0.5);
    m.constraints = 0.3 * random_vector(rows, seed + 2).cwiseAbs();
    m.jacobian = random_matrix(rows, n, seed + 3);
    m.num_inequalities = inequalities;
    return m;
}

/// Largest violation of the Karush-Kuhn-Tucker conditions: the gradient of the Lagrangian on variables that are not at
/// a bound, its sign on the others, and the constraints.
double kkt_error(const QuadraticModel& m, const VectorXd& d) {
    constexpr double near = 1e-7;
    std::vector<int> inside;
    for (int j = 0; j < d.size(); ++j)
        if (d[j] > m.lower[j] + near && d[j] < m.upper[j] - near) inside.push_back(j);
    const VectorXd c = m.constraints + m.jacobian * d;
    std::vector<int> active;
    double error = 0;
    for (int i = 0; i < c.size(); ++i) {
        error = std::max(error, i < m.num_inequalities ? c[i] : std::abs(c[i]));
        if (i >= m.num_inequalities || c[i] > -near) active.push_back(i);
    }
    VectorXd g = m.gradient + m.hessian * d;
    const double size = 1 + g.norm();
    if (!active.empty()) {
        const MatrixXd A = m.jacobian(active, Eigen::all);
        const VectorXd lambda = MatrixXd(A(Eigen::all, inside)).transpose().colPivHouseholderQr().solve(-g(inside));
        g += A.transpose() * lambda;
        for (std::size_t i = 0; i < active.size(); ++i)
            if (active[i] < m.num_inequalities) error = std::max(error, -lambda[static_cast<Eigen::Index>(i)] / size);
    }
    for (int j = 0; j < d.size(); ++j) {
        const bool at_lower = d[j] <= m.lower[j] + near, at_upper = d[j] >= m.upper[j] - near;
        error = std::max(error, (at_lower ? -g[j] : at_upper ? g[j] : std::abs(g[j])) / size);
    }
    return error;
}

}  // namespace

TEST(QuadraticModel, MeetsTheOptimalityConditions) {
    for (const int n : {2, 18, 60, 150})
        for (const double scale : {1e-6, 1.0, 1e3})
            for (unsigned seed = 1; seed < 5; ++seed) {
                const QuadraticModel m = random_model(n, n > 2 ? 3 : 1, n > 2 ? 2 : 1, scale, seed);
                const VectorXd d = solve_model(m);
                ASSERT_EQ(d.size(), n);
                EXPECT_LT(kkt_error(m, d), 1e-6) << n << " " << scale << " " << seed;
            }
}

TEST(QuadraticModel, UnitOfTheObjectiveDoesNotMatter) {
    QuadraticModel m = random_model(12, 1, 1, 1, 3);
    const VectorXd d = solve_model(m);
    m.gradient *= 1e20;
    m.hessian *= 1e20;
    EXPECT_LT((solve_model(m) - d).norm(), 1e-9);
}

TEST(QuadraticModel, UnreachableConstraintIsApproached) {
    QuadraticModel m = random_model(6, 1, 1, 1, 4);
    m.constraints[0] = 100;
    const VectorXd d = solve_model(m);
    ASSERT_EQ(d.size(), 6);
    EXPECT_NEAR((m.constraints + m.jacobian * d)[0], 100 - 0.5 * m.jacobian.row(0).lpNorm<1>(), 1e-3);
}

/// From where the objective is stationary, too, curvature shortens the way to a constraint.
TEST(QuadraticModel, DampingShortensAStepWithoutAGradient) {
    QuadraticModel m;
    m.gradient = VectorXd::Zero(2);
    m.lower = VectorXd::Constant(2, -10);
    m.upper = VectorXd::Constant(2, 10);
    m.constraints = VectorXd::Constant(1, 3);
    m.jacobian = vec_row({-1, 0});
    m.num_inequalities = 1;
    double before = 3.1;
    for (const double damping : {0.0, 1e6, 1e7, 1e8}) {
        m.hessian = (1 + damping) * MatrixXd::Identity(2, 2);
        m.min_step = 1e-3 / (1 + damping);
        const VectorXd d = solve_model(m);
        ASSERT_EQ(d.size(), 2);
        if (damping == 0) {
            EXPECT_NEAR(d[0], 3, 1e-2);
        } else {
            EXPECT_LT(d[0], 0.1 * before) << damping;
        }
        EXPECT_GT(d[0], 0) << damping;
        before = d[0];
    }
}

TEST(QuadraticModel, IndefiniteHessianHasNoStep) {
    QuadraticModel m = random_model(6, 1, 1, 1, 4);
    m.hessian(2, 2) = -1;
    EXPECT_EQ(solve_model(m).size(), 0);
}

/// Bounds that hold nothing change nothing, not even the way to the step.
TEST(QuadraticModel, InfiniteBoundsAreNone) {
    QuadraticModel m = random_model(20, 3, 2, 1, 5);
    m.lower.setConstant(-1e3);
    m.upper.setConstant(1e3);
    const VectorXd d = solve_model(m);
    m.lower.setConstant(-std::numeric_limits<double>::infinity());
    m.upper.setConstant(std::numeric_limits<double>::infinity());
    const VectorXd free = solve_model(m);
    ASSERT_EQ(free.size(), 20);
    EXPECT_LT((free - d).norm(), 1e-9 * d.norm());
}

/// The corner of a cone far away: rows become active and leave again on the way, also equal ones.
TEST(LeastDistance, NearestPointMeetsTheOptimalityConditions) {
    for (unsigned seed = 1; seed < 20; ++seed) {
        const int n = 12, rows = 40;
        LeastDistance p;
        p.q = 5 * random_vector(n, seed);
        p.inequality_rows = random_matrix(rows, n, seed + 100).rowwise().normalized();
        p.inequality_rows.row(1) = p.inequality_rows.row(0);
        p.inequality_limits = random_vector(rows, seed + 200).cwiseAbs();
        p.inequality_limits[1] = p.inequality_limits[0];
        p.equality_rows = random_matrix(2, n, seed + 300);
        p.equality_limits = 0.1 * random_vector(2, seed + 400);
        const VectorXd w = nearest_point(p);
        ASSERT_EQ(w.size(), n) << seed;
        EXPECT_LT((p.equality_rows * w - p.equality_limits).lpNorm<Eigen::Infinity>(), 1e-9);
        const VectorXd slack = p.inequality_limits - p.inequality_rows * w;
        EXPECT_GT(slack.minCoeff(), -1e-10);
        // w + q = - sum of multipliers times rows, those of the inequalities not negative: by non-negative projection
        // no direction that all active rows allow leads nearer.
        std::vector<int> active;
        for (int i = 0; i < rows; ++i)
            if (slack[i] < 1e-9 && i != 1) active.push_back(i);
        MatrixXd normals(n, 2 + static_cast<Eigen::Index>(active.size()));
        normals.leftCols(2) = p.equality_rows.transpose();
        normals.rightCols(static_cast<Eigen::Index>(active.size())) = p.inequality_rows(active, Eigen::all).transpose();
        const VectorXd multipliers = normals.colPivHouseholderQr().solve(-(w + p.q));
        EXPECT_LT((normals * multipliers + w + p.q).norm(), 1e-8 * p.q.norm()) << seed;
        EXPECT_GT(multipliers.tail(multipliers.size() - 2).minCoeff(), -1e-9) << seed;
    }
}

TEST(LeastDistance, ContradictingRowsHaveNoPoint) {
    LeastDistance p;
    p.q = VectorXd::Zero(2);
    p.inequality_rows = MatrixXd(2, 2);
    p.inequality_rows << 1, 0, -1, 0;
    p.inequality_limits = VectorXd::Constant(2, -1);  // x <= -1 and x >= 1
    p.equality_rows.resize(0, 2);
    p.equality_limits.resize(0);
    EXPECT_EQ(nearest_point(p).size(), 0);
    p.inequality_limits[1] = 2;  // -2 <= x <= -1
    ASSERT_EQ(nearest_point(p).size(), 2);
    EXPECT_NEAR(nearest_point(p)[0], -1, 1e-12);
}
