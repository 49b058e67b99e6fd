#include "core/remesh/remesh.hpp"

#include "cli/commands.hpp"
#include "cli/detail.hpp"
#include "cli/outputs.hpp"
#include "cli/signals.hpp"
#include "core/error.hpp"
#include "core/formats/io.hpp"
#include "core/mesh/geometry.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>

/// `strake remesh`: nearly equilateral triangles of a given edge length on the same shape.
namespace strake::cli {
namespace {

struct RemeshArguments {
    std::string surface, out;
    std::string edge_length = "auto", curvature = "none", shortest_edge = "auto";
    RemeshOptions remesh;
    bool json = false, quiet = false;
};

/// A length, or with % a fraction of the diagonal. `word` means 0, which leaves the choice to the library.
double length_of(const std::string& words, const char* option, const char* word, double diagonal) {
    if (words == word) return 0;
    const bool is_share = !words.empty() && words.back() == '%';
    const char* end = words.data() + words.size() - (is_share ? 1 : 0);
    double value = 0;
    const auto [stop, error] = std::from_chars(words.data(), end, value);
    if (error != std::errc{} || stop != end || !(value > 0) || !std::isfinite(value))
        throw InvalidInput(
            text(option, " ", words, ": must be a length > 0, a percentage of the diagonal like 1%, or ", word));
    return is_share ? value / 100 * diagonal : value;
}

/// How regular the triangles are.
struct Quality {
    double smallest_angle_deg = 180, largest_angle_deg = 0;
    double mean = 0, fifth_percentile = 0, smallest = 1;  ///< 2 inradius / circumradius
    double mean_edge = 0;
};

Quality quality_of(const TriMesh& mesh) {
    Quality quality;
    std::vector<double> ratios;
    const Points angles = corner_angles(mesh);
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        double sines = 1;
        for (int k = 0; k < 3; ++k) {
            const double degrees = angles(t, k) * 180 / std::numbers::pi;
            quality.smallest_angle_deg = std::min(quality.smallest_angle_deg, degrees);
            quality.largest_angle_deg = std::max(quality.largest_angle_deg, degrees);
            sines *= std::sin(0.5 * angles(t, k));
            const Eigen::Vector3d edge =
                mesh.vertices.row(mesh.triangles(t, (k + 1) % 3)) - mesh.vertices.row(mesh.triangles(t, k));
            quality.mean_edge += edge.norm() / (3.0 * mesh.num_triangles());
        }
        ratios.push_back(std::clamp(8 * sines, 0.0, 1.0));  // r = 4 R sin(a/2) sin(b/2) sin(c/2)
        quality.mean += ratios.back() / mesh.num_triangles();
    }
    std::sort(ratios.begin(), ratios.end());
    quality.smallest = ratios.front();
    quality.fifth_percentile = ratios[ratios.size() / 20];
    return quality;
}

nlohmann::ordered_json as_json(const Quality& q) {
    return {{"mean", q.mean},
            {"fifth_percentile", q.fifth_percentile},
            {"smallest", q.smallest},
            {"smallest_angle_deg", q.smallest_angle_deg},
            {"largest_angle_deg", q.largest_angle_deg},
            {"mean_edge", q.mean_edge}};
}

/// @param seconds of the whole command, reading and writing included
std::string as_json(const TriMesh& before, const RemeshResult& result, const std::string& out, double seconds) {
    nlohmann::ordered_json records = nlohmann::ordered_json::array();
    for (const RemeshRecord& r : result.records)
        records.push_back({{"iteration", r.iteration},
                           {"splits", r.splits},
                           {"collapses", r.collapses},
                           {"flips", r.flips},
                           {"triangles", r.triangles},
                           {"largest_move", r.largest_move}});
    const nlohmann::ordered_json json{{"edge_length", result.edge_length},
                                      {"vertices", result.mesh.num_vertices()},
                                      {"triangles", result.mesh.num_triangles()},
                                      {"crease_edges", result.crease_edges},
                                      {"boundary_edges", result.boundary_edges},
                                      {"border_edges", result.border_edges},
                                      {"corners", result.corners},
                                      {"kept_edges", result.kept_edges},
                                      {"frozen_triangles", result.frozen_triangles},
                                      {"features_are_dense", result.features_are_dense},
                                      {"expected_triangles", result.expected_triangles},
                                      {"new_intersections", result.new_intersections},
                                      {"quality_before", as_json(quality_of(before))},
                                      {"quality", as_json(quality_of(result.mesh))},
                                      {"iterations", records},
                                      {"seconds", seconds},
                                      {"file", out}};
    return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

std::string as_words(const TriMesh& before, const RemeshResult& result, const std::string& out) {
    const Quality was = quality_of(before), is = quality_of(result.mesh);
    std::string words = fmt::format("{}: {} vertices, {} triangles of edge length {:g} (before: {}, {:g})\n", out,
                                    result.mesh.num_vertices(), result.mesh.num_triangles(), is.mean_edge,
                                    before.num_triangles(), was.mean_edge);
    words += fmt::format(
        "quality (2 inradius / circumradius): mean {:.3f}, 5th percentile {:.3f}, smallest {:.2g} "
        "(before: {:.3f}, {:.3f}, {:.2g})\n",
        is.mean, is.fifth_percentile, is.smallest, was.mean, was.fifth_percentile, was.smallest);
    words += fmt::format("angles: {:.1f} to {:.1f} degrees (before: {:.1f} to {:.1f})\n", is.smallest_angle_deg,
                         is.largest_angle_deg, was.smallest_angle_deg, was.largest_angle_deg);
    words += fmt::format("features: {} crease, {} boundary and {} border edges, {} corners\n", result.crease_edges,
                         result.boundary_edges, result.border_edges, result.corners);
    return words;
}

void warn(const RemeshResult& result) {
    if (const std::string words = short_edge_words(result); !words.empty())
        fmt::print(stderr, "strake: note: {}\n", words);
    if (result.kept_edges > 3 * result.frozen_triangles)
        fmt::print(
            stderr,
            "strake: note: {} edges where the surface is not manifold, or where parts touch, are left unchanged\n",
            result.kept_edges);
    if (result.frozen_triangles > 0)
        fmt::print(stderr,
                   "strake: note: {} triangles are left unchanged: their replacements would intersect each other\n",
                   result.frozen_triangles);
    if (result.new_intersections > 0)
        fmt::print(
            stderr,
            "strake: warning: {} pairs of triangles newly intersect, where parts touch or nearly touch; a shorter "
            "--edge-length may help\n",
            result.new_intersections);
}

void print_remeshed(const std::string& words) {
    std::fputs(words.c_str(), stdout);  // main reports output that cannot be written
}

/// One line rewritten in place, only on a terminal.
RemeshProgress progress_of(const RemeshArguments& options) {
    const bool is_shown = !options.quiet && !options.json && ::isatty(STDERR_FILENO) == 1;
    return [is_shown](const RemeshRecord& r) {
        if (is_shown)
            fmt::print(stderr, "\riteration {}: {} triangles, {} splits, {} collapses, {} flips, {:.1f} s   ",
                       r.iteration, r.triangles, r.splits, r.collapses, r.flips, r.seconds);
        return !stop_wanted();
    };
}

void remesh_file(RemeshArguments& options) {
    const auto begin = std::chrono::steady_clock::now();
    format_of(options.out);  // a wrong extension is reported before the work
    check_outputs({options.out}, {options.surface});
    validate(options.remesh);
    length_of(options.edge_length, "--edge-length", "auto", 1);  // before anything is read
    length_of(options.curvature, "--curvature", "none", 1);
    length_of(options.shortest_edge, "--shortest-edge", "auto", 1);
    const SurfaceFile file = read_logged(options.surface);
    const TriMesh& mesh = file.mesh;
    check_area(options.surface, mesh);
    const double diagonal = box_diagonal(mesh);
    options.remesh.edge_length = length_of(options.edge_length, "--edge-length", "auto", diagonal);
    options.remesh.chord_error = length_of(options.curvature, "--curvature", "none", diagonal);
    options.remesh.shortest_edge = length_of(options.shortest_edge, "--shortest-edge", "auto", diagonal);
    watch_signals();
    const RemeshResult result = remesh(mesh, options.remesh, progress_of(options));
    if (!options.quiet && !options.json && ::isatty(STDERR_FILENO) == 1) fmt::print(stderr, "\r\033[K");
    if (result.cancelled || stop_wanted()) {
        fmt::print(stderr, "strake: interrupted by SIG{} in iteration {}; nothing was written\n",
                   ::sigabbrev_np(stop_signal()), result.records.size());
        throw ExitStatus{interrupted};
    }
    write_output(options.out, result.mesh, file.format);
    warn(result);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    if (!options.quiet || options.json)
        print_remeshed(options.json ? as_json(mesh, result, options.out, seconds)
                                    : as_words(mesh, result, options.out));
}

}  // namespace

void add_remesh(CLI::App& app) {
    auto options = std::make_shared<RemeshArguments>();
    CLI::App* command = app.add_subcommand("remesh", "remesh to nearly equilateral triangles, keeping features");
    command->add_option("SURFACE", options->surface, "surface file, any format that info reads")->required();
    command->add_option("-o,--out,--output", options->out, "surface file; the extension selects the format")
        ->required();
    command->add_option(
        "--edge-length", options->edge_length,
        "target: a length, a percentage of the diagonal like 1%, or auto, the input's mean (default: auto)");
    command->add_option("--angle,--crease-angle", options->remesh.angle_deg,
                        "degrees between faces above which an edge is a crease, (0, 90] (default: 40)");
    command->add_option("--iterations", options->remesh.iterations, "number of iterations (default: 10)");
    command->add_option(
        "--curvature", options->curvature,
        "shorten edges where the surface is curved: maximum distance of an edge from the surface, a length or "
        "a percentage of the diagonal (default: none)");
    command->add_option("--shortest-edge", options->shortest_edge,
                        "lower limit of --curvature (default: auto, a tenth of --edge-length)");
    command->add_option("--gradation", options->remesh.gradation,
                        "how fast edge lengths may change with distance, (0, 1] (default: 0.3)");
    command->add_option("--max-triangles", options->remesh.max_triangles, "refuse to create more (default: 20000000)");
    command->add_option("--threads", options->remesh.threads,
                        "number of threads (default: 0: STRAKE_NUM_THREADS, otherwise all); the result is the same");
    command->add_flag("-q,--quiet", options->quiet, "print neither progress nor summary");
    command->add_flag("--json", options->json, "print one JSON object instead of words");
    command->callback([options] { remesh_file(*options); });
}

}  // namespace strake::cli
