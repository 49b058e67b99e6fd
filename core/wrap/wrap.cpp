#include "core/wrap/wrap.hpp"

#include "core/error.hpp"
#include "core/mesh/adjacency.hpp"
#include "core/mesh/geometry.hpp"
#include "core/mesh/topology.hpp"
#include "core/remesh/remesh.hpp"
#include "core/wrap/alpha_wrap.hpp"
#include "core/wrap/halves.hpp"

#include <array>
#include <chrono>
#include <cmath>

namespace strake {
namespace {

constexpr double alpha_rel = 1.0 / 50, offset_share = 1 / 2.5, edge_share = 0.6;
constexpr int max_genus = 12;
constexpr double max_area_ratio = 1.45;
constexpr double on_cut = 1e-6;    ///< diagonals: a half ends there
constexpr double rounding = 1e-9;  ///< diagonals: of what has been put onto the plane
constexpr double snapped = 0.05;   ///< edges of the wrap: vertices so near to the plane are moved onto it

double seconds_since(std::chrono::steady_clock::time_point begin) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

/// V - E + F = 2 - 2 genus of a closed surface in one piece.
int genus_of(const TriMesh& mesh, const Adjacency& adjacent) {
    return (2 - (mesh.num_vertices() - adjacent.num_edges() + mesh.num_triangles())) / 2;
}

/// The plane with its normal towards the half.
SymmetryPlane towards(const TriMesh& half, const SymmetryPlane& plane) {
    const Eigen::VectorXd above = (half.vertices * plane.normal).array() - plane.offset;
    if (above.maxCoeff() >= -above.minCoeff()) return plane;
    return {-plane.normal, -plane.offset};
}

/// Even triangles for the wrap, or for one half of it, which is mirrored unless the body is a half as well.
std::string make_even(TriMesh raw, const WrapOptions& options, Wrap& wrap) {
    RemeshOptions remesh_options;
    remesh_options.edge_length = wrap.edge_length;
    remesh_options.iterations = 5;
    if (options.plane) raw = clipped(raw, *options.plane, snapped * wrap.edge_length);
    RemeshResult even = remesh(raw, remesh_options);
    if (even.new_intersections > 0)
        return text("intersects itself ", even.new_intersections, " times on new triangles");
    wrap.mesh = std::move(even.mesh);
    if (!options.plane) return {};
    if (const double off = put_borders_on(*options.plane, wrap.mesh); off > on_cut * box_diagonal(wrap.mesh))
        return text("is open ", off, " away from the plane of symmetry");
    if (const TopologyFacts facts = topology(wrap.mesh, adjacency(wrap.mesh)); facts.components != 1)
        return text("is cut into ", facts.components, " pieces by the plane of symmetry");
    if (!options.is_half)
        wrap.mesh = with_mirror_image(wrap.mesh, *options.plane, rounding * box_diagonal(wrap.mesh)).mesh;
    return {};
}

/// One attempt; what is wrong with it, or an empty text.
std::string try_once(const TriMesh& capped, double area, const WrapOptions& options, Wrap& wrap) {
    const auto begin = std::chrono::steady_clock::now();
    const TriMesh raw = alpha_wrap(capped, wrap.alpha, wrap.offset, options.max_seconds);
    wrap.wrap_seconds += seconds_since(begin);
    if (raw.num_triangles() == 0) return text("takes longer than ", options.max_seconds, " s of CPU");
    const Adjacency adjacent = adjacency(raw);
    const TopologyFacts facts = topology(raw, adjacent);
    if (facts.components != 1) return text("is in ", facts.components, " pieces");
    if (!facts.closed) return "is not closed";
    wrap.genus = genus_of(raw, adjacent);
    wrap.area_ratio = surface_area(raw) / area;
    if (wrap.genus > max_genus) return text("has ", wrap.genus, " handles, the limit is ", max_genus);
    if (wrap.area_ratio > max_area_ratio)
        return text("has ", wrap.area_ratio, " times the area of the body, the limit is ", max_area_ratio);
    const auto then = std::chrono::steady_clock::now();
    std::string wrong = make_even(raw, options, wrap);
    wrap.remesh_seconds += seconds_since(then);
    return wrong;
}

}  // namespace

void validate(const WrapOptions& options) {
    const auto not_negative = [](const char* name, double value) {
        if (!(value >= 0) || !std::isfinite(value))
            throw InvalidInput(text("wrap: ", name, " = ", value, " must be >= 0"));
    };
    not_negative("alpha", options.alpha);
    not_negative("offset", options.offset);
    not_negative("edge_length", options.edge_length);
    if (!(options.max_seconds > 0))
        throw InvalidInput(text("wrap: max_seconds = ", options.max_seconds, " must be > 0"));
    if (options.max_attempts < 1)
        throw InvalidInput(text("wrap: max_attempts = ", options.max_attempts, " must be >= 1"));
    if (options.is_half && !options.plane) throw InvalidInput("wrap: a half needs its plane");
}

TriMesh with_caps(const TriMesh& body, int& caps) {
    const Adjacency adjacent = adjacency(body);
    const std::vector<std::vector<int>> loops = topology(body, adjacent).boundary_loops;
    caps = static_cast<int>(loops.size());
    if (loops.empty()) return body;
    std::vector<int> loop_of(static_cast<std::size_t>(body.num_vertices()), -1);
    TriMesh out;
    out.vertices = body.vertices;
    out.triangles = body.triangles;
    const int n = body.num_vertices(), m = body.num_triangles();
    out.vertices.conservativeResize(n + caps, 3);
    for (int k = 0; k < caps; ++k) {
        Eigen::RowVector3d middle = Eigen::RowVector3d::Zero();
        for (const int v : loops[static_cast<std::size_t>(k)]) {
            loop_of[static_cast<std::size_t>(v)] = k;
            middle += body.vertices.row(v);
        }
        out.vertices.row(n + k) = middle / static_cast<double>(loops[static_cast<std::size_t>(k)].size());
    }
    std::vector<std::array<int, 3>> fans;
    for (int e = 0; e < adjacent.num_edges(); ++e) {
        if (adjacent.edge_triangles[e].size() != 1) continue;
        const auto [a, b] = adjacent.edges[e];
        fans.push_back({a, b, n + loop_of[static_cast<std::size_t>(a)]});
    }
    out.triangles.conservativeResize(m + static_cast<int>(fans.size()), 3);
    for (std::size_t k = 0; k < fans.size(); ++k)
        out.triangles.row(m + static_cast<int>(k)) << fans[k][0], fans[k][1], fans[k][2];
    return out;
}

Wrap wrap_around(const TriMesh& body, const WrapOptions& options) {
    validate(options);
    if (body.num_triangles() == 0 || !(surface_area(body) > 0)) throw InvalidInput("wrap: the body has no area");
    Wrap wrap;
    WrapOptions asked = options;
    TriMesh whole = body;
    if (options.is_half) {
        asked.plane = towards(body, *options.plane);
        whole = with_mirror_image(body, *asked.plane, on_cut * box_diagonal(body)).mesh;
    }
    const TriMesh capped = with_caps(whole, wrap.capped_holes);
    const double area = surface_area(capped);
    wrap.alpha = options.alpha > 0 ? options.alpha : alpha_rel * box_diagonal(body);
    wrap.offset = options.offset > 0 ? options.offset : offset_share * wrap.alpha;
    wrap.edge_length = options.edge_length > 0 ? options.edge_length : edge_share * wrap.alpha;
    for (wrap.attempts = 1;; ++wrap.attempts) {
        const std::string wrong = try_once(capped, area, asked, wrap);
        if (wrong.empty()) return wrap;
        wrap.notes.push_back(text("the wrap at alpha = ", wrap.alpha, ", offset = ", wrap.offset, " ", wrong));
        if (wrap.attempts == options.max_attempts) break;
        wrap.alpha *= 2;
        wrap.offset *= 2;
        wrap.edge_length *= 2;
    }
    std::string all;
    for (const std::string& note : wrap.notes) all += (all.empty() ? "" : "; ") + note;
    throw InvalidInput(text("wrap: no attempt gave a wrap: ", all,
                            ". State alpha and offset by hand, or do without a wrap (shell: none)"));
}

}  // namespace strake
