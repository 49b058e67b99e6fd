#include <gtest/gtest.h>
#include <tuple>

#include "cases/geometry/lifting_body.hpp"
#include "core/parallel.hpp"
#include "shells.hpp"

/// The number of threads does not change a bit of what a shell answers.
namespace strake {
namespace {

struct Answers {
    Points cold, warm, linear, force;
    Eigen::VectorXd height;
    std::vector<double> energies;
};

Answers answers(LinearSolver solver, double spring, bool half, int threads) {
    set_num_threads(threads);
    const TriMesh made = example::lifting_body(9000);
    const TriMesh mesh = half ? renumbered(made, 5) : made;  // scattered, to be made local inside
    ShellOptions options = uniform(mesh, 0.03 * box_diagonal(mesh));
    options.solver = solver;
    const Box box = bounding_box(mesh);
    const double root = box.min.x() + 0.1 * (box.max.x() - box.min.x());
    pin_where(mesh, options, half ? 1 : fixed_prism, [&](const Eigen::Vector3d& c) { return c.x() < root; });
    Loads loads = traction_where(mesh, {0, 0, 1}, [&](const Eigen::Vector3d& c) { return c.x() > 4 * root; });
    std::vector<RigidMotion> motions(half ? 1 : 0);
    if (half) motions[0].rotation = {0, 0.05, 0.02};
    PrimoShell shell(mesh, options);
    Answers a;
    a.linear = shell.linear_response(loads, motions);
    loads.force *= 0.1 * box_diagonal(mesh) / (a.linear - mesh.vertices).rowwise().norm().maxCoeff();
    if (spring > 0) loads.spring = loads.force.rowwise().norm() / spring;
    SolveOptions keep;
    keep.keep_factor = true;
    const auto solve = [&] {
        const Equilibrium end = shell.solve(loads, motions, keep);
        EXPECT_EQ(end.status, SolveStatus::converged) << end.reason;
        for (const SolveRecord& record : end.records) a.energies.push_back(record.energy);
        return shell.vertices();
    };
    a.cold = solve();
    loads.force *= 1.03;
    a.warm = solve();
    const std::vector<ShellSensitivities> s = shell.adjoint({a.warm - mesh.vertices, a.cold});
    a.force = s[0].force + s[1].force;
    a.height = s[1].prism_height;
    set_num_threads(0);
    return a;
}

class Threads : public testing::TestWithParam<std::tuple<LinearSolver, double, bool>> {};

TEST_P(Threads, SameBits) {
    const auto [solver, spring, half] = GetParam();
    const Answers one = answers(solver, spring, half, 1);
    for (const int threads : {2, 3}) {
        const Answers more = answers(solver, spring, half, threads);
        EXPECT_EQ(more.linear, one.linear);
        EXPECT_EQ(more.cold, one.cold);
        EXPECT_EQ(more.warm, one.warm);
        EXPECT_EQ(more.energies, one.energies);
        EXPECT_EQ(more.force, one.force);
        EXPECT_EQ(more.height, one.height);
    }
}

INSTANTIATE_TEST_SUITE_P(Shells, Threads,
                         testing::Values(std::tuple(LinearSolver::direct, 0.0, false),
                                         std::tuple(LinearSolver::direct, 1.0, true),
                                         std::tuple(LinearSolver::multigrid, 0.0, true),
                                         std::tuple(LinearSolver::multigrid, 1.0, false)));

}  // namespace
}  // namespace strake
