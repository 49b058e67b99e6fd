#include "cases/geometry/wing.hpp"
#include "core/error.hpp"
#include "core/primo/conjugate_gradients.hpp"
#include "shells.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <fstream>
#include <random>

/// However a solve gets there (cold, from a neighbour with its factor, from far away), it ends in the equilibrium that
/// a plain Newton method finds; and what it calls stable is.
namespace strake {
namespace {

Eigen::MatrixXd exact_hessian(PrimoShell::Impl& shell, const Loads& loads) {
    const auto turn = rotation_differences(shell.poses);
    shell.assemble(turn, jumps(shell.rest, shell.poses, turn), loads, StressTerm::exact);
    const Eigen::Index n = 6L * shell.rest.num_free();
    Eigen::MatrixXd H(n, n);
    for (Eigen::Index c = 0; c < n; ++c) H.col(c) = shell.product(Eigen::VectorXd::Unit(n, c));
    return H;
}

Eigen::VectorXd residual(const PrimoShell::Impl& shell, const Loads& loads) {
    const auto turn = rotation_differences(shell.poses);
    const Eigen::MatrixXd g = energy_gradient(shell.rest, turn, jumps(shell.rest, shell.poses, turn), loads);
    Eigen::VectorXd free(6L * shell.rest.num_free());
    for (int f = 0; f < shell.rest.num_free(); ++f)
        free.segment<6>(6L * f) = g.row(shell.rest.free_prisms[f]).transpose();
    return free;
}

/// Newton's method with the exact Hessian, dense, in four load steps from rest, each to the floor.
Points by_plain_newton(const TriMesh& mesh, const ShellOptions& options, const Loads& given) {
    PrimoShell shell(mesh, options);
    PrimoShell::Impl& impl = shell.impl();
    const Loads loads = complete(given, mesh.num_vertices());
    impl.prepare(loads.spring);
    for (int step = 1; step <= 4; ++step) {
        Loads part = loads;
        part.force *= step / 4.0;
        for (int i = 0; i < 30; ++i) {
            const Eigen::VectorXd twist = exact_hessian(impl, part).ldlt().solve(-residual(impl, part));
            impl.advance(twist);
            if (step_size(impl.rest, twist) < 1e-12) break;
        }
    }
    return shell.vertices();
}

struct Body {
    TriMesh mesh = ellipsoid({1, 0.5, 0.35}, 1);
    ShellOptions options = uniform(mesh, 0.1);
    std::mt19937 random{7};

    Body() {
        pin_where(mesh, options, fixed_prism, [](const Eigen::Vector3d& c) { return c.x() < -0.5; });
    }
    /// Smooth forces at random, whose linear response is `share` of the diagonal; every other one with springs.
    Loads loads(double share, bool springs) {
        std::normal_distribution<double> normal;
        Loads result{Points::Zero(mesh.num_vertices(), 3), {}};
        const Eigen::Matrix3d A = Eigen::Matrix3d::NullaryExpr([&] { return normal(random); });
        const Eigen::Vector3d b = Eigen::Vector3d::NullaryExpr([&] { return normal(random); });
        for (int k = 0; k < mesh.num_vertices(); ++k)
            result.force.row(k) = (A * mesh.vertices.row(k).transpose() + b).transpose();
        PrimoShell shell(mesh, options);
        result = scaled_to(shell, mesh, result, share);
        if (springs) result.spring = result.force.rowwise().norm() / (2 * 0.3 * box_diagonal(mesh));
        return result;
    }
};

double apart(const Points& a, const Points& b, const TriMesh& mesh) {
    return (a - b).rowwise().norm().maxCoeff() / box_diagonal(mesh);
}

TEST(Schemes, EveryWayEndsWhereAPlainNewtonMethodDoes) {
    Body body;
    PrimoShell chain(body.mesh, body.options);  // goes from one load case to the next with what it has kept
    SolveOptions keep;
    keep.keep_factor = true;
    for (int k = 0; k < 10; ++k) {
        SCOPED_TRACE(k);
        const Loads loads = body.loads(0.02 + 0.01 * k, k % 2 == 1);
        const Points expected = by_plain_newton(body.mesh, body.options, loads);
        PrimoShell cold(body.mesh, body.options);
        ASSERT_EQ(cold.solve(loads).status, SolveStatus::converged);
        EXPECT_LT(apart(cold.vertices(), expected, body.mesh), 1e-8);
        const Equilibrium end = chain.solve(loads, {}, keep);
        ASSERT_EQ(end.status, SolveStatus::converged) << end.reason;
        EXPECT_LT(apart(chain.vertices(), expected, body.mesh), 1e-8);
        Loads near = loads;
        near.force *= 1.05;
        ASSERT_EQ(cold.solve(near, {}, keep).status, SolveStatus::converged);
        const Equilibrium back = cold.solve(loads, {}, keep);
        EXPECT_LE(back.factorizations, 1);
        EXPECT_LT(apart(cold.vertices(), expected, body.mesh), 1e-8);
    }
}

TEST(Schemes, TheProductIsTheDerivativeOfTheGradientAlsoWithSprings) {
    Body body;
    for (const bool springs : {false, true}) {
        const Loads loads = complete(body.loads(0.1, springs), body.mesh.num_vertices());
        PrimoShell shell(body.mesh, body.options);
        ASSERT_EQ(shell.solve(loads).status, SolveStatus::converged);
        PrimoShell::Impl& impl = shell.impl();
        const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(6L * impl.rest.num_free(), -1, 1.3).array().sin();
        const Eigen::VectorXd expected = impl.product(x);
        const Poses at = impl.poses;
        const double h = 1e-5;
        impl.advance(h * x);
        const Eigen::VectorXd ahead = residual(impl, loads);
        impl.poses = at;
        impl.advance(-h * x);
        EXPECT_LT(((ahead - residual(impl, loads)) / (2 * h) - expected).norm(), 1e-7 * expected.norm());
    }
}

/// Without loads the residual's own scale falls with it, and no solve may wait for their ratio.
TEST(Schemes, ADesignOfNoLoadsIsFoundFromAnyOther) {
    const TriMesh mesh = example::wing(1000);
    for (const LinearSolver solver : {LinearSolver::direct, LinearSolver::multigrid}) {
        ShellOptions options = uniform(mesh, 0.02 * box_diagonal(mesh));
        options.solver = solver;
        pin_where(mesh, options, fixed_prism, [](const Eigen::Vector3d& c) { return c.y() < 0.1; });
        const auto middle = [](const Eigen::Vector3d& c) { return c.y() > 0.4 && c.y() < 0.9; };
        PrimoShell without_pin(mesh, options);
        const Loads loads = scaled_to(without_pin, mesh, traction_where(mesh, {0, 0, 1}, middle), 0.003);
        pin_where(mesh, options, 1, [](const Eigen::Vector3d& c) { return c.y() > 1.1; });
        PrimoShell shell(mesh, options);
        EXPECT_THROW(shell.linear_response(loads), InvalidInput);
        SolveOptions keep;
        keep.keep_factor = true;
        keep.fallbacks = false;  // as in a run
        const RigidMotion still, turned{{0, 0.02, 0}, {0, 0, 0}, {0.4, 1.2, 0}};
        for (const double share : {1.0, -0.1, 1e-4}) {
            Loads part = loads;
            part.force *= share;
            for (const RigidMotion& motion : {still, turned}) {
                ASSERT_EQ(shell.solve(part, {motion}, keep).status, SolveStatus::converged);
                const Equilibrium back = shell.solve({}, {still}, keep);
                EXPECT_EQ(back.status, SolveStatus::converged) << back.reason;
                EXPECT_TRUE(back.stable);
                EXPECT_LE((shell.vertices() - mesh.vertices).rowwise().norm().maxCoeff(), 1e-9 * box_diagonal(mesh));
            }
        }
    }
}

/// A strip pressed beyond Euler's load in steps, each beside the factor of the one before: straight, it stays an
/// equilibrium, and nothing pushes it sideways.
TEST(Schemes, WhatIsCalledStableHasAPositiveDefiniteHessian) {
    const TriMesh mesh = strip(1, 0.1, 20, 2);
    ShellOptions options = uniform(mesh, 0.02);
    pin_where(mesh, options, fixed_prism, [](const Eigen::Vector3d& c) { return c.x() < 0.05; });
    const Loads unit =
        complete(traction_where(mesh, Eigen::Vector3d(-1, 0, 0), [](const Eigen::Vector3d& c) { return c.x() > 0.95; }),
                 mesh.num_vertices());
    const double euler = M_PI * M_PI / 4 * (4.0 / 3) * std::pow(0.02, 3) / 12 / 0.02 * 0.1;  // clamped, free end
    SolveOptions keep;
    keep.keep_factor = true;
    keep.fallbacks = false;
    PrimoShell shell(mesh, options);
    int stable = 0, refused = 0;
    for (double share = 0.1; share < 2; share += 0.1) {
        Loads loads = unit;
        loads.force *= share * euler / unit.force.col(0).cwiseAbs().sum();
        const Equilibrium end = shell.solve(loads, {}, keep);
        const Loads& under = end.status == SolveStatus::converged ? loads : shell.impl().loads;
        const double least = exact_hessian(shell.impl(), complete(under, mesh.num_vertices()))
                                 .selfadjointView<Eigen::Lower>()
                                 .eigenvalues()
                                 .minCoeff();
        (end.status == SolveStatus::converged ? stable : refused) += 1;
        EXPECT_GT(least, 0) << "at " << share << " of Euler's load";
    }
    EXPECT_GT(stable, 5);
    EXPECT_GT(refused, 3);
}

/// The twists of a strip bent to an arc of 0.6 rad, to first order, bring its far end near the end of the arc.
TEST(Schemes, AStepThatBendsKeepsLengths) {
    const TriMesh mesh = strip(1, 0.1, 40, 2);
    ShellOptions options = uniform(mesh, 0.02);
    pin_where(mesh, options, fixed_prism, [](const Eigen::Vector3d& c) { return c.x() < 0.02; });
    PrimoShell shell(mesh, options);
    const RestState& rest = shell.impl().rest;
    const double bend = 0.6;
    Eigen::VectorXd twist(6L * rest.num_free());
    for (int f = 0; f < rest.num_free(); ++f) {
        const double x = rest.centroid(rest.free_prisms[f], 0);
        twist.segment<6>(6L * f) << 0, -bend * x, 0, 0, 0, bend * x * x / 2;
    }
    shell.impl().advance(twist);
    Eigen::Index last = 0;
    mesh.vertices.col(0).maxCoeff(&last);
    const Eigen::RowVector3d end = shell.vertices().row(last);
    const double shortening = 1 - std::sin(bend) / bend;  // on straight ways there is none, on whole arcs 3/2 of it
    EXPECT_NEAR(1 - end.x(), shortening, 0.2 * shortening);
    EXPECT_NEAR(end.z(), (1 - std::cos(bend)) / bend, 0.01);
}

TEST(Schemes, MemoryStaysFlatOverWarmSolves) {
    if (!std::ifstream("/proc/self/statm")) GTEST_SKIP() << "needs /proc";
    const auto pages = [] {
        long total = 0, resident = 0;
        std::ifstream("/proc/self/statm") >> total >> resident;
        return resident;
    };
    Body body;
    const Loads loads = body.loads(0.1, false);
    PrimoShell shell(body.mesh, body.options);
    SolveOptions keep;
    keep.keep_factor = true;
    long after_ten = 0;
    for (int k = 0; k < 120; ++k) {
        Loads now = loads;
        now.force *= 1 + 0.02 * std::sin(k);
        ASSERT_EQ(shell.solve(now, {}, keep).status, SolveStatus::converged);
        shell.adjoint({loads.force});
        if (k == 10) after_ten = pages();
    }
    EXPECT_LT(pages() - after_ten, 512);  // 2 MB: a hundredth of all factors and vectors that were made
}

}  // namespace
}  // namespace strake
