#include "cases/geometry/lifting_body.hpp"
#include "core/patches/automatic.hpp"
#include "core/patches/segmentation.hpp"

#include <benchmark/benchmark.h>

/// Patches of the example lifting body: adjacency, tensor and three levels.
namespace {

using namespace strake;

void three_levels_at_angles(benchmark::State& state) {
    const TriMesh mesh = example::lifting_body(static_cast<int>(state.range(0)));
    for (auto _ : state) benchmark::DoNotOptimize(segment(mesh, adjacency(mesh), {10, 5, 2.5}).levels.size());
    state.SetItemsProcessed(state.iterations() * mesh.num_triangles());
}
BENCHMARK(three_levels_at_angles)->Arg(30000)->Arg(131000)->Arg(418000)->Unit(benchmark::kMillisecond);

void three_automatic_levels(benchmark::State& state) {
    const TriMesh mesh = example::lifting_body(static_cast<int>(state.range(0)));
    for (auto _ : state) benchmark::DoNotOptimize(segment_automatically(mesh, adjacency(mesh)).levels.size());
    state.SetItemsProcessed(state.iterations() * mesh.num_triangles());
}
BENCHMARK(three_automatic_levels)->Arg(30000)->Arg(131000)->Arg(418000)->Unit(benchmark::kMillisecond);

}  // namespace
