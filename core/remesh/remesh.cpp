#include "core/remesh/remesh.hpp"

#include "core/error.hpp"
#include "core/remesh/passes.hpp"

#include <chrono>
#include <numbers>
#include <thread>

namespace strake {
namespace {

constexpr double radians = std::numbers::pi / 180;

void check(bool good, const char* field, double value, const char* limit) {
    if (!good) throw InvalidInput(text("remesh: ", field, " = ", value, " must be ", limit));
}

/// Vertices outside of every triangle carry a wanted length, too: nothing divides by zero.
void set_sizes(WorkingMesh& mesh, double edge_length) { std::fill(mesh.size.begin(), mesh.size.end(), edge_length); }

}  // namespace

void validate(const RemeshOptions& o) {
    check(o.edge_length >= 0 && std::isfinite(o.edge_length), "edge_length", o.edge_length, "> 0, or 0 for automatic");
    check(o.angle_deg > 0 && o.angle_deg <= 90, "angle_deg", o.angle_deg, "in (0, 90]");
    check(o.iterations >= 1 && o.iterations <= 1000, "iterations", o.iterations, "in [1, 1000]");
    check(o.chord_error >= 0 && std::isfinite(o.chord_error), "chord_error", o.chord_error, "> 0, or 0 for uniform");
    check(o.shortest_edge >= 0 && std::isfinite(o.shortest_edge), "shortest_edge", o.shortest_edge,
          "> 0, or 0 for automatic");
    check(o.gradation > 0 && o.gradation <= 1, "gradation", o.gradation, "in (0, 1]");
    check(o.turn_deg > 0 && o.turn_deg <= 90, "turn_deg", o.turn_deg, "in (0, 90]");
    check(o.max_triangles >= 4, "max_triangles", o.max_triangles, ">= 4");
    check(o.threads >= 0, "threads", o.threads, ">= 0");
}

RemeshResult remesh(const TriMesh& given, const RemeshOptions& options, const RemeshProgress& progress) {
    validate(options);
    const auto start = std::chrono::steady_clock::now();
    const BaseSurface base = base_surface(given, options.angle_deg * radians);
    RemeshResult result;
    result.edge_length = options.edge_length > 0 ? options.edge_length : base.mean_edge;
    const double wanted = base.area / (0.4330127 * result.edge_length * result.edge_length);
    if (!(wanted <= options.max_triangles))
        throw InvalidInput(text("remesh: an edge length of ", result.edge_length, " makes about ", wanted,
                                " triangles, more than ", options.max_triangles, "; choose a longer one"));
    WorkingMesh mesh = working_mesh(base);
    set_sizes(mesh, result.edge_length);
    const double natural = 15 * radians, turn = options.turn_deg * radians;
    const int threads = options.threads > 0 ? options.threads : static_cast<int>(std::thread::hardware_concurrency());
    const Guard guard{0.9e-4 * base.diagonal, std::cos(natural), std::cos(turn), std::sin(turn), std::max(1, threads)};
    for (const double factor : {0.01, 0.1, 0.4}) collapse_short(mesh, guard, factor, 4.0 / 3);
    for (int i = 1; i <= options.iterations; ++i) {
        RemeshRecord record{};
        record.iteration = i;
        record.splits = split_long(mesh, 4.0 / 3);
        record.collapses = collapse_short(mesh, guard, 0.8, 4.0 / 3);
        mesh.compact();
        record.flips = flip_edges(mesh, guard);
        record.largest_move = smooth(mesh, guard);
        record.triangles = mesh.num_triangles();
        record.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        result.records.push_back(record);
        if (progress && !progress(record)) {
            result.cancelled = true;
            break;
        }
    }
    for (const FeatureEdge& edge : mesh.features) {
        if (edge.kind == FeatureKind::crease) ++result.crease_edges;
        if (edge.kind == FeatureKind::boundary) ++result.boundary_edges;
        if (edge.kind == FeatureKind::border) ++result.border_edges;
        if (edge.kind == FeatureKind::kept) ++result.kept_edges;
    }
    for (const VertexRole role : mesh.role) result.corners += role == VertexRole::fixed;
    result.mesh = as_mesh(mesh, given.group_names);
    return result;
}

}  // namespace strake
