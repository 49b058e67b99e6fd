#include "core/formats/io.hpp"
#include "core/mesh/geometry.hpp"
#include "objectives/external/external.hpp"
#include "optimize/journal/journal.hpp"

#include <benchmark/benchmark.h>
#include <sys/resource.h>
#include <unistd.h>
#include <algorithm>
#include <cmath>
#include <fstream>

/// What Strake itself adds to an evaluation by a program, at 131 072 triangles: the surface, the program, its answer,
/// the journal. Real time, in the folder STRAKE_BENCH_DIR (default: that of temporary files); `cpu_ms` is the median of
/// the processor's time for a call, user and system, the program's own included.
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

double seconds(const timeval& t) { return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec); }

/// Of this process and its children that have ended.
double cpu_seconds() {
    double sum = 0;
    for (const int who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
        rusage used;
        ::getrusage(who, &used);
        sum += seconds(used.ru_utime) + seconds(used.ru_stime);
    }
    return sum;
}

/// Adds up nothing: calls are few, and some meet what else the machine does.
class MedianCpu {
public:
    void begin() { start_ = cpu_seconds(); }
    void end() { milliseconds_.push_back(1e3 * (cpu_seconds() - start_)); }
    void tell(benchmark::State& state) {
        const auto middle = milliseconds_.begin() + static_cast<std::ptrdiff_t>(milliseconds_.size() / 2);
        std::nth_element(milliseconds_.begin(), middle, milliseconds_.end());
        state.counters["cpu_ms"] = *middle;
    }

private:
    double start_ = 0;
    std::vector<double> milliseconds_;
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
    MedianCpu cpu;
    for (auto _ : state) {
        cpu.begin();
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
        cpu.end();
        fs::remove_all(scene.folder / "evaluations");
        state.ResumeTiming();
    }
    cpu.tell(state);
}

void surface(benchmark::State& state, const std::string& format) {
    const Scene scene;
    MedianCpu cpu;
    for (auto _ : state) {
        cpu.begin();
        write_surface(scene.folder / "surface", scene.mesh, format_named(format));
        cpu.end();
    }
    cpu.tell(state);
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

constexpr int calls = 31;
BENCHMARK_CAPTURE(surface, stl, "stl")->Unit(benchmark::kMillisecond)->UseRealTime()->Iterations(calls);
BENCHMARK_CAPTURE(surface, obj, "obj")->Unit(benchmark::kMillisecond)->UseRealTime()->Iterations(calls);
BENCHMARK_CAPTURE(evaluation, stl_values, "stl", false)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->Iterations(calls);
BENCHMARK_CAPTURE(evaluation, stl_gradient, "stl", true)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->Iterations(calls);
BENCHMARK_CAPTURE(evaluation, obj_gradient, "obj", true)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->Iterations(calls);
BENCHMARK(hash)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(journal_call)->Arg(0)->Arg(1)->Arg(3)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace strake
