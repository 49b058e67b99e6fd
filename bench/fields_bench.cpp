#include "bench/shell_cases.hpp"
#include "core/fields/displacement_fields.hpp"

#include <benchmark/benchmark.h>

/// Displacement fields on the example wing, root fixed: set-up, and a design that differs in fields alone, against an
/// equilibrium and a factorization of the shell.
namespace {

using namespace strake;

FieldConditions held_root(const HeldShell& wing) {
    FieldConditions conditions;
    for (std::size_t t = 0; t < wing.options.pin.size(); ++t)
        if (wing.options.pin[t] == fixed_prism) conditions.held.push_back(static_cast<int>(t));
    return conditions;
}

void set_up(benchmark::State& state) {
    const HeldShell wing(example::wing(static_cast<int>(state.range(0))));
    const FieldConditions conditions = held_root(wing);
    const FieldOptions options{static_cast<int>(state.range(1)), {}};
    for (auto _ : state)
        benchmark::DoNotOptimize(DisplacementFields(wing.mesh, conditions, options).frame().half.data());
}
BENCHMARK(set_up)->Args({22000, 27})->Args({22000, 60})->Args({22000, 192})->Unit(benchmark::kMillisecond);

void factorization(benchmark::State& state) {
    HeldShell wing(example::wing(static_cast<int>(state.range(0))));
    wing.scale_loads(0.1);
    PrimoShell shell(wing.mesh, wing.options);
    shell.solve(wing.loads);
    for (auto _ : state) shell.refresh_tangent();
}
BENCHMARK(factorization)->Arg(22000)->Unit(benchmark::kMillisecond);

/// Displacement, rotations of the prisms and gradient: all that a change of fields costs beside the guard and the
/// quantities.
void change_of_fields(benchmark::State& state) {
    const HeldShell wing(example::wing(static_cast<int>(state.range(0))));
    const DisplacementFields fields(wing.mesh, held_root(wing), {static_cast<int>(state.range(1)), {}});
    const Eigen::VectorXd z = 0.01 * wing.diagonal * Eigen::VectorXd::Ones(fields.size()) / fields.size();
    for (auto _ : state) {
        const Points moved = fields.displacement(z);
        benchmark::DoNotOptimize(moved.data());
        benchmark::DoNotOptimize(fields.rotations(z).data());
        benchmark::DoNotOptimize(fields.gradient(moved).data());
    }
}
BENCHMARK(change_of_fields)->Args({22000, 27})->Args({22000, 60})->Args({22000, 192})->Unit(benchmark::kMillisecond);

void warm_equilibrium(benchmark::State& state) {
    HeldShell wing(example::wing(static_cast<int>(state.range(0))));
    wing.scale_loads(0.1);
    Loads other = wing.loads;
    other.force *= 1.01;
    PrimoShell shell(wing.mesh, wing.options);
    SolveOptions options;
    options.keep_factor = true;
    shell.solve(wing.loads, {}, options);
    bool is_changed = false;
    for (auto _ : state) {
        is_changed = !is_changed;
        if (shell.solve(is_changed ? other : wing.loads, {}, options).status != SolveStatus::converged)
            state.SkipWithError("not converged");
    }
}
BENCHMARK(warm_equilibrium)->Arg(22000)->Unit(benchmark::kMillisecond);

}  // namespace
