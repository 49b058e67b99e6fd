#include "core/formats/io.hpp"

#include <benchmark/benchmark.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <vector>

/// Reading and welding a binary STL of a million triangles, as a file in memory (/tmp or what TMPDIR says).
namespace {

using namespace strake;

/// A sphere of rows x columns quads, row by row, as exporters write their patches.
std::filesystem::path written_sphere(int rows, int columns) {
    const auto file =
        std::filesystem::temp_directory_path() / ("strake-read-bench-" + std::to_string(::getpid()) + ".stl");
    std::ofstream out(file, std::ios::binary);
    const std::uint32_t count = 2u * static_cast<std::uint32_t>(rows) * static_cast<std::uint32_t>(columns);
    out.write(std::vector<char>(80).data(), 80).write(reinterpret_cast<const char*>(&count), 4);
    const auto corner = [&](int i, int j, float* to) {
        const double v = std::numbers::pi * (i + 0.01) / (rows + 0.02),
                     u = 2 * std::numbers::pi * (j % columns) / columns;
        to[0] = static_cast<float>(std::sin(v) * std::cos(u));
        to[1] = static_cast<float>(std::sin(v) * std::sin(u));
        to[2] = static_cast<float>(std::cos(v));
    };
    float record[13] = {};
    for (int i = 0; i < rows; ++i)
        for (int j = 0; j < columns; ++j)
            for (int half = 0; half < 2; ++half) {
                corner(i, j, record + 3);
                corner(i + 1, half ? j + 1 : j, record + 6);
                corner(half ? i : i + 1, j + 1, record + 9);
                out.write(reinterpret_cast<const char*>(record), 50);
            }
    return file;
}

void read_and_weld_binary_stl(benchmark::State& state) {
    const auto file = written_sphere(500, static_cast<int>(state.range(0)) / 1000);
    int vertices = 0;
    for (auto _ : state) vertices = read_surface(file).mesh.num_vertices();
    state.counters["vertices"] = vertices;
    state.SetItemsProcessed(state.iterations() * state.range(0));
    std::filesystem::remove(file);
}
BENCHMARK(read_and_weld_binary_stl)->Arg(100'000)->Arg(1'000'000)->Unit(benchmark::kMillisecond);

}  // namespace
