#include "shells.hpp"

#include <gtest/gtest.h>

/// Whatever is asked of it, a solve ends within its limits, in a proven equilibrium or with a named failure.
namespace strake {
namespace {

bool all_finite(const PrimoShell& shell) { return shell.vertices().allFinite(); }

TEST(BoundedSolve, AbsurdLoadsEndWithANameAndFinitePoses) {
    const TriMesh mesh = strip(1, 0.3, 10, 3);
    ShellOptions options = uniform(mesh, 0.02);
    pin_where(mesh, options, fixed_prism, [](const Eigen::Vector3d& c) { return c.x() < 0.1; });
    for (const Eigen::Vector3d& direction : {Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(-1, 0, 1e-3)})
        for (const double share : {1e1, 1e3, 1e6, 1e12, 1e100, 1e300}) {
            SCOPED_TRACE(share);
            PrimoShell shell(mesh, options);
            const Loads unit = traction_where(mesh, direction, [](const Eigen::Vector3d& c) { return c.x() > 0.8; });
            Equilibrium end;
            int told = 0;
            SolveOptions how;
            how.max_iterations = 25;
            try {
                end = shell.solve(scaled_to(shell, mesh, unit, share), {}, how,
                                  [&](const SolveRecord&) { return ++told < 1000; });
            } catch (const std::exception& e) {  // refused in words
                EXPECT_STRNE(e.what(), "");
                continue;
            }
            EXPECT_LE(end.iterations, 25 + 4);
            EXPECT_LT(told, 1000);
            EXPECT_TRUE(all_finite(shell));
            if (end.status == SolveStatus::converged) {
                EXPECT_TRUE(end.stable);
                EXPECT_TRUE(std::isfinite(end.energy));
            } else {
                EXPECT_FALSE(end.reason.empty());
                EXPECT_EQ(shell.vertices(), mesh.vertices);  // back where it was
            }
        }
}

TEST(BoundedSolve, ACompressedStripIsNotCalledAnEquilibriumOnItsUnstableSide) {
    const TriMesh mesh = strip(1, 0.1, 20, 2);
    ShellOptions options = uniform(mesh, 0.01);
    pin_where(mesh, options, fixed_prism, [](const Eigen::Vector3d& c) { return c.x() < 0.05; });
    PrimoShell shell(mesh, options);
    const Loads unit =
        traction_where(mesh, Eigen::Vector3d(-1, 0, 0), [](const Eigen::Vector3d& c) { return c.x() > 0.9; });
    const Equilibrium end = shell.solve(scaled_to(shell, mesh, unit, 0.05));  // far beyond Euler's load
    EXPECT_TRUE(end.status != SolveStatus::converged || end.stable) << end.reason;
    EXPECT_TRUE(all_finite(shell));
}

TEST(BoundedSolve, LoadsThatAreNotFiniteAreRefused) {
    const TriMesh mesh = strip(1, 0.3, 4, 2);
    ShellOptions options = uniform(mesh, 0.02);
    pin_where(mesh, options, fixed_prism, [](const Eigen::Vector3d& c) { return c.x() < 0.3; });
    for (const double wrong : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
        PrimoShell shell(mesh, options);
        Loads loads{Points::Zero(mesh.num_vertices(), 3), {}};
        loads.force(3, 1) = wrong;
        bool refused = false;
        try {
            refused = shell.solve(loads).status != SolveStatus::converged;
        } catch (const std::exception&) {
            refused = true;
        }
        EXPECT_TRUE(refused);
        EXPECT_TRUE(all_finite(shell));
    }
}

}  // namespace
}  // namespace strake
