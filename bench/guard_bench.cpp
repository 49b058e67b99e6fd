#include "bench/shell_cases.hpp"
#include "core/mesh/intersection_tree.hpp"
#include "optimize/evaluate/validity.hpp"

#include <benchmark/benchmark.h>

/// The validity guard beside the evaluation that it guards: the same surfaces, loaded on their outer part so that they
/// move by 5 % of the diagonal, with the load changed to and fro by 1 %.
namespace {

using namespace strake;

enum Surface { wing, lifting_body };

HeldShell loaded(const benchmark::State& state) {
    HeldShell body(state.range(0) == wing ? example::wing(static_cast<int>(state.range(1)))
                                          : example::lifting_body(static_cast<int>(state.range(1))));
    body.scale_loads(0.05);
    return body;
}

void arguments(benchmark::internal::Benchmark* b) {
    for (const int surface : {wing, lifting_body})
        for (const int triangles : {22000, 131000}) b->Args({surface, triangles});
    b->Unit(benchmark::kMillisecond);
}

void warm_equilibrium(benchmark::State& state) {
    const HeldShell body = loaded(state);
    Loads other = body.loads;
    other.force *= 1.01;
    PrimoShell shell(body.mesh, body.options);
    SolveOptions options;
    options.keep_factor = true;
    shell.solve(body.loads, {}, options);
    bool changed = false;
    for (auto _ : state) {
        changed = !changed;
        if (shell.solve(changed ? other : body.loads, {}, options).status != SolveStatus::converged)
            state.SkipWithError("not converged");
    }
}
BENCHMARK(warm_equilibrium)->Apply(arguments)->Iterations(6);

void guard(benchmark::State& state) {
    const HeldShell body = loaded(state);
    PrimoShell shell(body.mesh, body.options);
    if (shell.solve(body.loads).status != SolveStatus::converged) return state.SkipWithError("not converged");
    const Points vertices = shell.vertices();
    const Poses poses = shell.poses();
    const ValidityGuard guard(body.mesh, adjacency(body.mesh));
    for (auto _ : state)
        if (!guard.defect(vertices, poses).empty()) state.SkipWithError("refused");
}
BENCHMARK(guard)->Apply(arguments);

/// Once a run: the guard with its tree.
void guard_setup(benchmark::State& state) {
    const HeldShell body = loaded(state);
    const Adjacency adjacent = adjacency(body.mesh);
    for (auto _ : state) benchmark::DoNotOptimize(ValidityGuard(body.mesh, adjacent));
}
BENCHMARK(guard_setup)->Apply(arguments);

}  // namespace
