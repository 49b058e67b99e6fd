#include "casefile/propose/propose_parts.hpp"
#include "core/mesh/closest_point.hpp"
#include "core/mesh/geometry.hpp"

#include <algorithm>
#include <cmath>

namespace strake::proposing {
namespace {

constexpr int few_triangles = 12;   ///< of a stray piece
constexpr double small = 1e-3;      ///< share of the area, of a stray piece
constexpr double all_small = 0.01;  ///< share of the area and of the triangles, of all of them
constexpr double beside = 1e-3;     ///< of the diagonal: nearer ones may be pieces of the skin
constexpr double margin = 3;        ///< the limit on the area is this many times that of the largest stray piece

struct Piece {
    double share = 0;  ///< of the area
    int triangles = 0;
    bool is_open = false, is_stray = false;
};

std::vector<Piece> pieces_of(const TriMesh& mesh, const Adjacency& adjacent, const std::vector<int>& component) {
    std::vector<Piece> pieces(static_cast<std::size_t>(*std::ranges::max_element(component)) + 1);
    const Eigen::VectorXd area = triangle_areas(mesh);
    const double total = area.sum();
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        Piece& piece = pieces[static_cast<std::size_t>(component[static_cast<std::size_t>(t)])];
        piece.share += area[t] / total;
        ++piece.triangles;
        for (int k = 0; k < 3; ++k) piece.is_open |= adjacent.edge_triangles[adjacent.triangle_edges(t, k)].size() == 1;
    }
    for (Piece& piece : pieces)
        piece.is_stray = piece.is_open && piece.share < small && piece.triangles <= few_triangles;
    return pieces;
}

TriMesh without_strays(const TriMesh& mesh, const std::vector<Piece>& pieces, const std::vector<int>& component) {
    std::vector<int> kept;
    for (int t = 0; t < mesh.num_triangles(); ++t)
        if (!pieces[static_cast<std::size_t>(component[static_cast<std::size_t>(t)])].is_stray) kept.push_back(t);
    TriMesh rest;
    rest.vertices = mesh.vertices;
    rest.triangles = mesh.triangles(kept, Eigen::all);
    return rest;
}

}  // namespace

std::optional<Debris> debris(const TriMesh& mesh) {
    if (mesh.num_triangles() == 0 || !(surface_area(mesh) > 0)) return {};
    const Adjacency adjacent = adjacency(mesh);
    const std::vector<int> component = edge_components(mesh, adjacent);
    std::vector<Piece> pieces = pieces_of(mesh, adjacent, component);
    const auto is_stray = [](const Piece& piece) { return piece.is_stray; };
    if (std::ranges::none_of(pieces, is_stray) || std::ranges::all_of(pieces, is_stray)) return {};
    const TriMesh rest = without_strays(mesh, pieces, component);
    const double near = beside * box_diagonal(rest);
    const ClosestPointTree body(rest);
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        Piece& piece = pieces[static_cast<std::size_t>(component[static_cast<std::size_t>(t)])];
        for (int k = 0; k < 3 && piece.is_stray; ++k)
            piece.is_stray = body.find(mesh.vertices.row(mesh.triangles(t, k))).distance > near;
    }
    Debris found;
    double largest = 0, smallest_kept = 1;
    for (const Piece& piece : pieces) {
        if (!piece.is_stray) {
            smallest_kept = std::min(smallest_kept, piece.share);
            continue;
        }
        ++found.pieces;
        found.triangles += piece.triangles;
        found.share += piece.share;
        largest = std::max(largest, piece.share);
    }
    // In percent of few digits; a hole that another repair closes doubles the area of a piece.
    const double digit = std::pow(10, std::floor(std::log10(std::max(100 * margin * largest, 1e-6))));
    found.min_area_percent = digit * std::ceil(100 * margin * largest / digit);
    if (found.pieces == 0 || found.share > all_small || found.triangles > all_small * mesh.num_triangles() ||
        found.min_area_percent > 50 * smallest_kept)
        return {};
    return found;
}

}  // namespace strake::proposing
