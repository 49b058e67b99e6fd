#include "cases/geometry/wing.hpp"
#include "core/mesh/geometry.hpp"
#include "core/primo/shell.hpp"

#include <benchmark/benchmark.h>

/// The shell on the example wing, root fixed, lift on the outer part that moves it by 10 % of the diagonal.
namespace {

using namespace strake;

struct LoadedWing {
    TriMesh mesh;
    ShellOptions options;
    Loads loads;

    explicit LoadedWing(int triangles) : mesh(example::wing(triangles)) {
        const double diagonal = box_diagonal(mesh);
        options.prism_height = Eigen::VectorXd::Constant(mesh.num_vertices(), 0.02 * diagonal);
        options.pin.assign(mesh.num_triangles(), free_prism);
        const Points centroid = triangle_centroids(mesh);
        Points traction = Points::Zero(mesh.num_triangles(), 3);
        for (int t = 0; t < mesh.num_triangles(); ++t) {
            if (centroid(t, 1) < 0.03) options.pin[t] = fixed_prism;
            if (centroid(t, 1) > 0.3) traction(t, 2) = 1;
        }
        loads.force = traction_forces(mesh, traction);
        PrimoShell shell(mesh, options);
        loads.force *= 0.1 * diagonal / (shell.linear_response(loads) - mesh.vertices).rowwise().norm().maxCoeff();
    }
};

void cold_equilibrium(benchmark::State& state) {
    const LoadedWing wing(static_cast<int>(state.range(0)));
    PrimoShell shell(wing.mesh, wing.options);
    for (auto _ : state) {
        shell.reset();
        if (shell.solve(wing.loads).status != SolveStatus::converged) state.SkipWithError("not converged");
    }
}
BENCHMARK(cold_equilibrium)->Arg(5000)->Arg(22000)->Arg(83000)->Unit(benchmark::kMillisecond);

/// Loads changed to and fro by 1 %, with the factor of the design before.
void warm_equilibrium(benchmark::State& state) {
    const LoadedWing wing(static_cast<int>(state.range(0)));
    Loads other = wing.loads;
    other.force *= 1.01;
    PrimoShell shell(wing.mesh, wing.options);
    SolveOptions options;
    options.keep_factor = true;
    shell.solve(wing.loads, {}, options);
    bool changed = false;
    for (auto _ : state) {
        changed = !changed;
        if (shell.solve(changed ? other : wing.loads, {}, options).status != SolveStatus::converged)
            state.SkipWithError("not converged");
    }
}
BENCHMARK(warm_equilibrium)->Arg(5000)->Arg(22000)->Arg(83000)->Unit(benchmark::kMillisecond);

void adjoint(benchmark::State& state) {
    const LoadedWing wing(static_cast<int>(state.range(0)));
    PrimoShell shell(wing.mesh, wing.options);
    shell.solve(wing.loads);
    for (auto _ : state) benchmark::DoNotOptimize(shell.adjoint({wing.loads.force}).front().force.data());
}
BENCHMARK(adjoint)->Arg(5000)->Arg(22000)->Arg(83000)->Unit(benchmark::kMillisecond);

}  // namespace
