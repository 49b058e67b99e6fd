#include "casefile/propose/propose_parts.hpp"
#include "core/mesh/closest_point.hpp"
#include "core/mesh/geometry.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>
#include <set>

namespace strake::proposing {
namespace {

constexpr int few_triangles = 12;   ///< of a stray piece
constexpr double small = 1e-3;      ///< share of the area, of a stray piece
constexpr double all_small = 0.01;  ///< share of the area and of the triangles, of all of them
constexpr double beside = 1e-3;     ///< of the diagonal: nearer ones may be pieces of the skin
constexpr double resolution = 0.1;  ///< of `beside`
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
    // Triangles of zero area are for another repair, and no limit on the area drops them.
    for (Piece& piece : pieces)
        piece.is_stray = piece.is_open && piece.share > 0 && piece.share < small && piece.triangles <= few_triangles;
    return pieces;
}

/// What a file names by itself is a part, however small: a pitot tube, an antenna.
void keep_named(const TriMesh& mesh, const std::vector<int>& component, std::vector<Piece>& pieces) {
    std::map<int, std::set<int>> pieces_of_group;
    for (std::size_t t = 0; t < mesh.group.size(); ++t) pieces_of_group[mesh.group[t]].insert(component[t]);
    for (const auto& [group, own] : pieces_of_group) {
        const std::string& name = mesh.group_names[static_cast<std::size_t>(group)];
        if (own.size() == 1 && !name.empty() && std::isalpha(static_cast<unsigned char>(name[0])) != 0)
            pieces[static_cast<std::size_t>(*own.begin())].is_stray = false;
    }
}

/// Whether any point of the triangle is within `near` of the body: corners on both sides of a skin may be far from it.
bool is_beside(const ClosestPointTree& body, const std::array<Eigen::Vector3d, 3>& at, double near) {
    const Eigen::Vector3d middle = (at[0] + at[1] + at[2]) / 3;
    const double distance = body.find(middle).distance;
    double reach = 0, longest = -1;
    std::size_t cut = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        reach = std::max(reach, (at[k] - middle).norm());
        if (const double length = (at[(k + 1) % 3] - at[k]).norm(); length > longest) longest = length, cut = k;
    }
    if (distance <= near) return true;
    if (distance > near + reach) return false;
    if (reach < resolution * near) return true;
    const Eigen::Vector3d &from = at[cut], &to = at[(cut + 1) % 3], &apex = at[(cut + 2) % 3];
    const Eigen::Vector3d between = 0.5 * (from + to);
    return is_beside(body, {from, between, apex}, near) || is_beside(body, {between, to, apex}, near);
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
    keep_named(mesh, component, pieces);
    const auto is_stray = [](const Piece& piece) { return piece.is_stray; };
    if (std::ranges::none_of(pieces, is_stray) || std::ranges::all_of(pieces, is_stray)) return {};
    const TriMesh rest = without_strays(mesh, pieces, component);
    const double near = beside * box_diagonal(rest);
    const ClosestPointTree body(rest);
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        Piece& piece = pieces[static_cast<std::size_t>(component[static_cast<std::size_t>(t)])];
        if (!piece.is_stray) continue;
        const auto corner = [&](int k) { return Eigen::Vector3d(mesh.vertices.row(mesh.triangles(t, k))); };
        piece.is_stray = !is_beside(body, {corner(0), corner(1), corner(2)}, near);
    }
    Debris found;
    double largest = 0, smallest_kept = 1;
    for (const Piece& piece : pieces) {
        if (!piece.is_stray) {
            if (piece.share > 0) smallest_kept = std::min(smallest_kept, piece.share);
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
