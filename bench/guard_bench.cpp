#include "cases/geometry/lifting_body.hpp"
#include "cases/geometry/wing.hpp"
#include "core/mesh/geometry.hpp"
#include "core/mesh/intersection_tree.hpp"
#include "optimize/validity.hpp"

#include <benchmark/benchmark.h>

/// The validity guard beside the evaluation that it guards: the same surfaces, loaded on their outer part so that they
/// move by 5 % of the diagonal, with the load changed to and fro by 1 %.
namespace {

using namespace strake;

enum Surface { wing, lifting_body };

struct Loaded {
    TriMesh mesh;
    ShellOptions options;
    Loads loads;

    explicit Loaded(const benchmark::State& state)
        : mesh(state.range(0) == wing ? example::wing(static_cast<int>(state.range(1)))
                                      : example::lifting_body(static_cast<int>(state.range(1)))) {
        const double diagonal = box_diagonal(mesh);
        options.prism_height = Eigen::VectorXd::Constant(mesh.num_vertices(), 0.02 * diagonal);
        options.pin.assign(mesh.num_triangles(), free_prism);
        const Points centroid = triangle_centroids(mesh);
        const Box box = bounding_box(mesh);
        int axis = 0;
        const double length = (box.max - box.min).maxCoeff(&axis);
        Points traction = Points::Zero(mesh.num_triangles(), 3);
        for (int t = 0; t < mesh.num_triangles(); ++t) {
            const double at = (centroid(t, axis) - box.min[axis]) / length;
            if (at < 0.05) options.pin[t] = fixed_prism;
            if (at > 0.3) traction(t, 2) = 1;
        }
        loads.force = traction_forces(mesh, traction);
        PrimoShell shell(mesh, options);
        loads.force *= 0.05 * diagonal / (shell.linear_response(loads) - mesh.vertices).rowwise().norm().maxCoeff();
    }
};

void arguments(benchmark::internal::Benchmark* b) {
    for (const int surface : {wing, lifting_body})
        for (const int triangles : {22000, 131000}) b->Args({surface, triangles});
    b->Unit(benchmark::kMillisecond);
}

void warm_equilibrium(benchmark::State& state) {
    const Loaded body(state);
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
    const Loaded body(state);
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
    const Loaded body(state);
    const Adjacency adjacent = adjacency(body.mesh);
    for (auto _ : state) benchmark::DoNotOptimize(ValidityGuard(body.mesh, adjacent));
}
BENCHMARK(guard_setup)->Apply(arguments);

}  // namespace
