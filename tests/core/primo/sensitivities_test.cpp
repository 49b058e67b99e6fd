#include <gtest/gtest.h>

#include <cmath>

#include "shells.hpp"

using namespace strake;

namespace {

/// A body with a fixed end, a strained patch, a load and weak springs, at a stated displacement.
struct Fixture {
    TriMesh mesh = ellipsoid({1, 0.5, 0.3}, 2);
    ShellOptions options = uniform(mesh, 0.1);
    Loads loads;
    std::vector<RigidMotion> motions{RigidMotion{{0.02, 0.1, -0.05}, {0.01, 0.02, 0.05}, {0, 0, 0.3}}};
    Points weights;
    Fixture(double share, bool symmetric, bool strained) {
        pin_where(mesh, options, fixed_prism, [](const Eigen::Vector3d& c) { return c.x() < -0.6; });
        if (strained)
            pin_where(mesh, options, 1, [](const Eigen::Vector3d& c) { return c.z() > 0.22; });
        else
            motions.clear();
        if (symmetric) cut();
        PrimoShell shell(mesh, without_pins());
        loads = traction_where(mesh, {0.2, 0.3, 1}, [](const Eigen::Vector3d& c) { return c.x() > 0.3; });
        if (share > 0)
            loads = scaled_to(shell, mesh, loads, share);
        else
            loads.force.setZero();
        loads.spring = 0.01 * vertex_areas(mesh);
        weights = Points::Map(random_vector(3 * mesh.num_vertices(), 5).eval().data(), mesh.num_vertices(), 3);
    }
    ShellOptions without_pins() const {
        ShellOptions o = options;
        for (int& pin : o.pin)
            if (pin > 0) pin = free_prism;
        return o;
    }
    /// Keeps the half y >= 0 and couples it to its mirror image.
    void cut() {
        std::vector<int> keep;
        for (int t = 0; t < mesh.num_triangles(); ++t) {
            bool above = true;
            for (int k = 0; k < 3; ++k) above &= mesh.vertices(mesh.triangles(t, k), 1) > -1e-9;
            if (above) keep.push_back(t);
        }
        ShellOptions o = options;
        o.pin.clear();
        Triangles triangles(keep.size(), 3);
        for (std::size_t i = 0; i < keep.size(); ++i)
            triangles.row(i) = mesh.triangles.row(keep[i]), o.pin.push_back(options.pin[keep[i]]);
        mesh.triangles = triangles;
        options = o;
        options.symmetry = SymmetryPlane{Eigen::Vector3d::UnitY(), 0};
    }
    /// A nonlinear functional of the vertices.
    double value(const Points& v) const {
        return (weights.cwiseProduct(v)).sum() + 0.5 * (v - mesh.vertices).squaredNorm();
    }
    Points dJ_dv(const Points& v) const { return weights + v - mesh.vertices; }
    Points shape(const Loads& l, const std::vector<RigidMotion>& m, const Eigen::VectorXd& height) const {
        ShellOptions o = options;
        o.prism_height = height;
        PrimoShell shell(mesh, o);
        const Equilibrium end = shell.solve(l, m);
        EXPECT_EQ(end.status, SolveStatus::converged) << end.reason;
        return shell.vertices();
    }
};

/// Along `size` with the signs of g, so that the slope is not small beside the curvature and the control can fail.
void expect_order_two(const std::function<double(const Eigen::VectorXd&)>& J, const Eigen::VectorXd& x,
                      const Eigen::VectorXd& g, const Eigen::VectorXd& size, double h, const char* what) {
    const Eigen::VectorXd p = size.cwiseAbs().cwiseProduct(g.cwiseSign());
    EXPECT_NEAR(taylor_order(J, x, g, p, h), 2, 0.15) << what;
    EXPECT_NEAR(taylor_order(J, x, 1.5 * g, p, h), 1, 0.15) << what << " (control)";
}

void check_all(const Fixture& f, bool with_motion) {
    PrimoShell shell(f.mesh, f.options);
    const Equilibrium end = shell.solve(f.loads, f.motions);
    ASSERT_EQ(end.status, SolveStatus::converged) << end.reason;
    const ShellSensitivities s = shell.adjoint({f.dJ_dv(shell.vertices())}).at(0);
    const int n = f.mesh.num_vertices();
    const double size = std::max(f.loads.force.cwiseAbs().maxCoeff(), 1e-4);

    Eigen::VectorXd p = size * random_vector(3 * n, 11);
    const Eigen::VectorXd F = Eigen::VectorXd::Map(f.loads.force.data(), 3 * n),
                          dF = Eigen::VectorXd::Map(s.force.data(), 3 * n);
    expect_order_two(
        [&](const Eigen::VectorXd& x) {
            Loads l = f.loads;
            l.force = Points::Map(x.data(), n, 3);
            return f.value(f.shape(l, f.motions, f.options.prism_height));
        },
        F, dF, p, 0.1, "loads");
    // The smooth parts of springs and heights: one common factor on a smooth field.
    const Eigen::VectorXd spring = f.loads.spring;
    expect_order_two(
        [&](const Eigen::VectorXd& x) {
            Loads l = f.loads;
            l.spring = x;
            return f.value(f.shape(l, f.motions, f.options.prism_height));
        },
        spring, s.spring, spring.cwiseProduct(Eigen::VectorXd::Ones(n) + 0.5 * random_vector(n, 3)), 0.1, "springs");
    const Eigen::VectorXd h = f.options.prism_height;
    expect_order_two([&](const Eigen::VectorXd& x) { return f.value(f.shape(f.loads, f.motions, x)); }, h,
                     s.prism_height, h.cwiseProduct(Eigen::VectorXd::Ones(n) + 0.5 * random_vector(n, 9)), 0.05,
                     "heights");
    if (!with_motion) return;
    const RigidMotion m = f.motions[0];
    Eigen::VectorXd x0(6), q = random_vector(6, 21) * 0.3;
    x0 << m.rotation, m.translation;
    expect_order_two(
        [&](const Eigen::VectorXd& x) {
            return f.value(f.shape(f.loads, {RigidMotion{x.head<3>(), x.tail<3>(), m.about}}, f.options.prism_height));
        },
        x0, s.motion[0], q, 0.01, "strain motion");
}

}  // namespace

TEST(Sensitivities, TaylorOrderTwoNearRest) { check_all(Fixture(0.01, false, true), true); }
TEST(Sensitivities, TaylorOrderTwoAtLargeDeformation) { check_all(Fixture(0.3, false, true), true); }
TEST(Sensitivities, TaylorOrderTwoOfAHalfModel) { check_all(Fixture(0.2, true, false), false); }

TEST(Sensitivities, LoadsAtRest) {
    const Fixture f(0, false, false);
    PrimoShell shell(f.mesh, f.options);
    ASSERT_EQ(shell.solve(f.loads).status, SolveStatus::converged);
    const ShellSensitivities s = shell.adjoint({f.dJ_dv(shell.vertices())}).at(0);
    const int n = f.mesh.num_vertices();
    const Eigen::VectorXd g = Eigen::VectorXd::Map(s.force.data(), 3 * n);
    expect_order_two(
        [&](const Eigen::VectorXd& x) {
            Loads l = f.loads;
            l.force = Points::Map(x.data(), n, 3);
            return f.value(f.shape(l, {}, f.options.prism_height));
        },
        Eigen::VectorXd::Zero(3 * n), g, 1e-3 * random_vector(3 * n, 4), 0.01, "loads at rest");
}

TEST(Sensitivities, ForwardAndAdjointAgree) {
    const Fixture f(0.2, false, true);
    PrimoShell shell(f.mesh, f.options);
    ASSERT_EQ(shell.solve(f.loads, f.motions).status, SolveStatus::converged);
    const Points dJ = f.dJ_dv(shell.vertices());
    const ShellSensitivities s = shell.adjoint({dJ}).at(0);
    const Points dF = Points::Map(random_vector(3 * f.mesh.num_vertices(), 8).eval().data(), f.mesh.num_vertices(), 3);
    const double forward = shell.response({dF}).at(0).cwiseProduct(dJ).sum(), backward = s.force.cwiseProduct(dF).sum();
    EXPECT_NEAR(forward, backward, 1e-9 * std::abs(backward));
    const auto motion = shell.motion_response().at(0);
    for (int c = 0; c < 6; ++c)
        EXPECT_NEAR(motion[c].cwiseProduct(dJ).sum(), s.motion[0][c], 1e-9 * s.motion[0].norm());
}

TEST(Sensitivities, WarmSolveWithAKeptFactorEndsAtTheSameShape) {
    const Fixture f(0.3, false, false);
    PrimoShell cold(f.mesh, f.options), warm(f.mesh, f.options);
    Loads near = f.loads;
    near.force *= 0.95;
    SolveOptions keep;
    keep.keep_factor = true;
    ASSERT_EQ(warm.solve(near, {}, keep).status, SolveStatus::converged);
    ASSERT_EQ(warm.solve(f.loads, {}, keep).status, SolveStatus::converged);
    ASSERT_EQ(cold.solve(f.loads).status, SolveStatus::converged);
    EXPECT_LT((warm.vertices() - cold.vertices()).cwiseAbs().maxCoeff(), 1e-10);
}

TEST(Sensitivities, AdjointsDoNotDependOnThoseOfOtherDesignsAndFunctionals) {
    const Fixture f(0.2, false, true);
    const auto functional = [&](int seed) {
        return Points(
            Points::Map(random_vector(3 * f.mesh.num_vertices(), seed).eval().data(), f.mesh.num_vertices(), 3));
    };
    Loads other = f.loads;
    other.force *= 0.9;
    PrimoShell shell(f.mesh, f.options), fresh(f.mesh, f.options);
    ASSERT_EQ(shell.solve(other, f.motions).status, SolveStatus::converged);
    shell.adjoint({functional(1), functional(2), functional(2), Points::Zero(f.mesh.num_vertices(), 3)});
    ASSERT_EQ(shell.solve(f.loads, f.motions).status, SolveStatus::converged);
    ASSERT_EQ(fresh.solve(f.loads, f.motions).status, SolveStatus::converged);
    for (const std::vector<Points>& asked : {std::vector<Points>{functional(2), functional(3)}, {functional(4)}}) {
        const auto one = shell.adjoint(asked);
        for (std::size_t k = 0; k < asked.size(); ++k) {
            const ShellSensitivities same = fresh.adjoint({asked[k]})[0];
            EXPECT_LE((one[k].force - same.force).norm(), 1e-7 * same.force.norm()) << k;
        }
    }
}
