#include "bench/shell_cases.hpp"

#include <benchmark/benchmark.h>

/// The shell on the example wing, root fixed, lift on the outer part that moves it by 10 % of the diagonal.
namespace {

using namespace strake;

HeldShell loaded_wing(const benchmark::State& state) {
    HeldShell wing(example::wing(static_cast<int>(state.range(0))));
    wing.scale_loads(0.1);
    return wing;
}

void cold_equilibrium(benchmark::State& state) {
    const HeldShell wing = loaded_wing(state);
    PrimoShell shell(wing.mesh, wing.options);
    for (auto _ : state) {
        shell.reset();
        if (shell.solve(wing.loads).status != SolveStatus::converged) state.SkipWithError("not converged");
    }
}
BENCHMARK(cold_equilibrium)->Arg(5000)->Arg(22000)->Arg(83000)->Unit(benchmark::kMillisecond);

/// Loads changed to and fro by 1 %, with the factor of the design before.
void warm_equilibrium(benchmark::State& state) {
    const HeldShell wing = loaded_wing(state);
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
    const HeldShell wing = loaded_wing(state);
    PrimoShell shell(wing.mesh, wing.options);
    shell.solve(wing.loads);
    for (auto _ : state) benchmark::DoNotOptimize(shell.adjoint({wing.loads.force}).front().force.data());
}
BENCHMARK(adjoint)->Arg(5000)->Arg(22000)->Arg(83000)->Unit(benchmark::kMillisecond);

}  // namespace
