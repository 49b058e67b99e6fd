#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "cases/geometry/wing.hpp"
#include "core/formats/io.hpp"
#include "shells.hpp"

using namespace strake;

namespace {

/// Solves for loads of the stated linear sizes and checks what "reached, not approached" means.
void expect_equilibria(const TriMesh& mesh, ShellOptions options, const Loads& unit, const std::vector<double>& shares,
                       double gradient_floor) {
    PrimoShell shell(mesh, options);
    for (const double share : shares) {
        shell.reset();
        const Loads loads = scaled_to(shell, mesh, unit, share);
        const Equilibrium end = shell.solve(loads);
        ASSERT_EQ(end.status, SolveStatus::converged) << share << ": " << end.reason;
        EXPECT_LT(end.iterations, 30) << share;
        EXPECT_LT(end.factorizations, 8) << share;
        EXPECT_EQ(end.load_steps, 1) << share;
        EXPECT_LT(end.last_step, 1e-9) << share;
        EXPECT_LT(end.relative_gradient, gradient_floor) << share;
        EXPECT_TRUE(end.stable) << share;
        const Points v = shell.vertices();
        for (int k = 0; k < v.rows(); ++k)
            if (shell.fixed_vertices()[k]) {
                ASSERT_TRUE((v.row(k).array() == mesh.vertices.row(k).array()).all());
            }
    }
}

}  // namespace

TEST(LargeDeformation, WingFromOneToFiftyPercent) {
    const TriMesh mesh = example::wing(22000);
    ShellOptions options = uniform(mesh, 0.02 * box_diagonal(mesh));
    options.symmetry = SymmetryPlane{Eigen::Vector3d::UnitY(), 0};
    pin_where(mesh, options, fixed_prism, [](const Eigen::Vector3d& c) { return c.y() < 0.03; });
    const Loads lift = traction_where(mesh, {0, 0, 1}, [](const Eigen::Vector3d& c) { return c.y() > 0.3; });
    expect_equilibria(mesh, options, lift, {0.01, 0.1, 0.5}, 5e-8);
}

TEST(LargeDeformation, BunnyPulledAtAnEar) {
    const char* folder = std::getenv("STRAKE_DATA");
    if (!folder) GTEST_SKIP() << "STRAKE_DATA names no folder of surfaces";  // the surfaces are not ours to ship
    const TriMesh mesh = read_surface(std::filesystem::path(folder) / "bunny_closed_cgal.off").mesh;
    ShellOptions options = uniform(mesh, 0.02 * box_diagonal(mesh));
    const double low = mesh.vertices.col(1).minCoeff(), high = mesh.vertices.col(1).maxCoeff();
    pin_where(mesh, options, fixed_prism, [&](const Eigen::Vector3d& c) { return c.y() < low + 0.03 * (high - low); });
    const Loads pull =
        traction_where(mesh, {0.5, 0, -1}, [&](const Eigen::Vector3d& c) { return c.y() > low + 0.85 * (high - low); });
    expect_equilibria(mesh, options, pull, {0.3}, 1e-7);
}
