#include "core/mesh/geometry.hpp"
#include "core/mesh/io.hpp"
#include "objectives/external/external.hpp"
#include "optimize/journal.hpp"

#include <benchmark/benchmark.h>
#include <unistd.h>
#include <cmath>
#include <fstream>

/// What Strake itself adds to an evaluation by a program, at 131 072 triangles: the surface, the program, its answer,
/// the journal. Real time, in the folder STRAKE_BENCH_DIR (default: that of temporary files).
namespace strake {
namespace {

namespace fs = std::filesystem;

TriMesh sheet(int n) {
    TriMesh mesh;
    mesh.vertices.resize((n + 1) * (n + 1), 3);
    mesh.triangles.resize(2 * n * n, 3);
    for (int i = 0; i <= n; ++i)
        for (int j = 0; j <= n; ++j)
            mesh.vertices.row(i * (n + 1) + j) << i / 7.0, j / 9.0, std::sin(0.01 * i) * std::cos(0.02 * j);
    for (int i = 0, t = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            const int v = i * (n + 1) + j;
            mesh.triangles.row(t++) << v, v + n + 1, v + 1;
            mesh.triangles.row(t++) << v + 1, v + n + 1, v + n + 2;
        }
    return mesh;
}

/// A folder with the answer that the program copies: a gradient with 17 digits.
class Scene {
public:
    Scene() {
        const char* where = std::getenv("STRAKE_BENCH_DIR");
        std::string name = ((where ? fs::path(where) : fs::temp_directory_path()) / "strake-bench-XXXXXX").string();
        if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no folder");
        folder = name;
        std::ofstream gradient(folder / "g.csv");
        gradient.precision(17);
        for (int v = 0; v < mesh.num_vertices(); ++v)
            gradient << v << ',' << std::sin(v) << ',' << std::cos(v) << ',' << 1e-3 * std::sin(3 * v) << '\n';
    }
    ~Scene() { fs::remove_all(folder); }
    ExternalCommand command(const std::string& format, bool gradient) const {
        ExternalCommand command;
        command.name = "bulk";
        command.format = format;
        command.case_dir = folder;
        command.evaluations_dir = folder / "evaluations";
        command.diagonal = box_diagonal(mesh);
        command.has_gradients = gradient;
        // A hard link is the cheapest program that leaves a gradient of its own.
        command.command = {"sh", "-c",
                           gradient
                               ? "ln ../../g.csv g.csv; echo '{\"value\": 1.5, \"gradient\": \"g.csv\"}' > result.json"
                               : "echo '{\"value\": 1.5}' > result.json"};
        return command;
    }
    TriMesh mesh = sheet(256);
    fs::path folder;
};

/// All of an evaluation, but for the deformation.
void evaluation(benchmark::State& state, const std::string& format, bool gradient) {
    const Scene scene;
    const Quantity quantity = external(scene.command(format, gradient));
    JournalFacts facts;
    facts.case_yaml = "case: bench\n";
    facts.values = {"bulk"};
    const auto journal = Journal::create(scene.folder / "journal.sqlite", facts, {0, 100000, 0});
    int number = 0;
    for (auto _ : state) {
        QuantityRequest request{scene.mesh, gradient, ++number, 1, {}, {}};
        request.surface_hash = content_hash(scene.mesh);
        JournalCall call{number, "bulk", "program", request.surface_hash, quantity.evaluate(request), 0.1};
        if (call.result.failure) state.SkipWithError(call.result.failure->message.c_str());
        journal->add(call);
        JournalEvaluation row;
        row.number = number;
        row.status = "ok";
        row.x = Eigen::VectorXd::Zero(50);
        row.values = {1.5};
        journal->add(row);
        state.PauseTiming();
        fs::remove_all(scene.folder / "evaluations");
        state.ResumeTiming();
    }
}

void surface(benchmark::State& state, const std::string& format) {
    const Scene scene;
    for (auto _ : state) {
        write_surface(scene.folder / "surface", scene.mesh, format_named(format));
    }
}

void hash(benchmark::State& state) {
    const TriMesh mesh = sheet(256);
    for (auto _ : state) benchmark::DoNotOptimize(content_hash(mesh));
}

void journal_call(benchmark::State& state) {
    const Scene scene;
    JournalFacts facts;
    facts.case_yaml = "case: bench\n";
    const auto journal = Journal::create(scene.folder / "journal.sqlite", facts, {0, 100000, 0});
    QuantityResult result;
    result.values = {1};
    if (state.range(0) > 0) result.dJ_dv.assign(static_cast<std::size_t>(state.range(0)), scene.mesh.vertices);
    int number = 0;
    for (auto _ : state) journal->add(JournalCall{++number, "bulk", "program", "surface", result, 0.1});
}

BENCHMARK_CAPTURE(surface, stl, "stl")->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(surface, obj, "obj")->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(evaluation, stl_values, "stl", false)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(evaluation, stl_gradient, "stl", true)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(evaluation, obj_gradient, "obj", true)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(hash)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(journal_call)->Arg(0)->Arg(1)->Arg(3)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace strake
