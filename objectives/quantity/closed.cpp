#include "objectives/quantity/closed.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"

#include <cmath>

namespace strake {
namespace {

std::string at(const TriMesh& mesh, int v) {
    return text("vertex ", v, " (", mesh.vertices(v, 0), ", ", mesh.vertices(v, 1), ", ", mesh.vertices(v, 2), ")");
}

constexpr double on_plane_rel = 1e-6;  // of the diagonal

bool in_plane(const TriMesh& mesh, const Adjacency& adjacent, int e, const SymmetryPlane& symmetry, double limit) {
    if (adjacent.edge_triangles[e].size() != 1) return false;
    for (const int v : adjacent.edges[e])
        if (!(std::abs(symmetry.normal.dot(mesh.vertices.row(v)) - symmetry.offset) <= limit)) return false;
    return true;
}

}  // namespace

std::string edge_between(const TriMesh& mesh, const std::array<int, 2>& edge) {
    return text("edge from ", at(mesh, edge[0]), " to ", at(mesh, edge[1]));
}

std::vector<char> plane_edges(const TriMesh& mesh, const Adjacency& adjacent,
                              const std::optional<SymmetryPlane>& symmetry) {
    std::vector<char> marked(static_cast<std::size_t>(adjacent.num_edges()), 0);
    if (!symmetry) return marked;
    const double limit = on_plane_rel * box_diagonal(mesh);
    for (int e = 0; e < adjacent.num_edges(); ++e) marked[e] = in_plane(mesh, adjacent, e, *symmetry, limit);
    return marked;
}

int edge_imbalance(const TriMesh& mesh, const Adjacency& adjacent, int e) {
    int sum = 0;
    for (const int t : adjacent.edge_triangles[e])
        for (int k = 0; k < 3; ++k)
            if (adjacent.triangle_edges(t, k) == e) sum += mesh.triangles(t, k) == adjacent.edges[e][0] ? 1 : -1;
    return sum;
}

std::vector<int> open_edges(const TriMesh& mesh, const Adjacency& adjacent,
                            const std::optional<SymmetryPlane>& symmetry) {
    const std::vector<char> closes = plane_edges(mesh, adjacent, symmetry);
    std::vector<int> open;
    for (int e = 0; e < adjacent.num_edges(); ++e)
        if (edge_imbalance(mesh, adjacent, e) != 0 && !closes[e]) open.push_back(e);
    return open;
}

std::string open_remedy(const TriMesh& mesh, const Adjacency& adjacent, const std::vector<int>& open) {
    const double diagonal = box_diagonal(mesh);
    const Box box = bounding_box(mesh);
    int best_axis = 0;
    double best_c = 0;
    std::vector<int> best_off = open;
    for (int side = 0; side < 6; ++side) {
        const int axis = side / 2;
        const double c = side % 2 == 0 ? box.min[axis] : box.max[axis];
        std::vector<int> off;
        for (const int e : open)
            for (const int v : adjacent.edges[e])
                if (std::abs(mesh.vertices(v, axis) - c) > on_plane_rel * diagonal) {
                    off.push_back(e);
                    break;
                }
        if (off.size() >= best_off.size()) continue;
        best_off = off;
        best_axis = axis;
        best_c = std::abs(c) <= on_plane_rel * diagonal ? 0 : c;
    }
    if (best_off.size() == open.size()) return "close the holes first";
    const char name = "xyz"[best_axis];
    const std::string line = text("symmetry: {plane: ", name, ", at: ", best_c, "}");
    if (best_off.empty()) return text("all lie in the plane ", name, " = ", best_c, ": for a half model set ", line);
    return text(open.size() - best_off.size(), " of them lie in the plane ", name, " = ", best_c, " (a half model? ",
                line, "), the other ", best_off.size(), " are holes to be closed first, the first at the ",
                edge_between(mesh, adjacent.edges[best_off.front()]));
}

void require_closed(const std::string& name, const TriMesh& mesh, const std::optional<SymmetryPlane>& symmetry) {
    const Adjacency adjacent = adjacency(mesh);
    const std::vector<int> open = open_edges(mesh, adjacent, symmetry);
    if (open.empty()) return;
    const auto [a, b] = adjacent.edges[open.front()];
    throw InvalidInput(text(name, ": the surface is open or misoriented at the edge from vertex ", a, " (",
                            mesh.vertices.row(a), ") to vertex ", b, " (", mesh.vertices.row(b), "), first of ",
                            open.size(), "; ", symmetry ? "close it there" : open_remedy(mesh, adjacent, open)));
}

void require_oriented(const std::string& name, const TriMesh& mesh) {
    const Adjacency adjacent = adjacency(mesh);
    for (int e = 0; e < static_cast<int>(adjacent.edges.size()); ++e) {
        if (adjacent.edge_triangles[e].size() != 2 || edge_imbalance(mesh, adjacent, e) == 0) continue;
        const auto [a, b] = adjacent.edges[e];
        throw InvalidInput(text(name, ": the triangles at the edge from vertex ", a, " (", mesh.vertices.row(a),
                                ") to vertex ", b, " (", mesh.vertices.row(b),
                                ") disagree in orientation; set repair: {orient: true}"));
    }
}

void require_along(const std::string& name, const char* shown, const Eigen::Vector3d& direction,
                   const std::optional<SymmetryPlane>& symmetry) {
    if (symmetry && std::abs(symmetry->normal.dot(direction.stableNormalized())) > 1e-9)
        throw InvalidInput(text(name, ": the ", shown, " crosses the plane of symmetry"));
}

TriMesh whole_of(const TriMesh& half, const SymmetryPlane& symmetry) {
    const int nv = half.num_vertices(), nt = half.num_triangles();
    TriMesh whole;
    whole.vertices.resize(2 * nv, 3);
    whole.triangles.resize(2 * nt, 3);
    whole.vertices.topRows(nv) = half.vertices;
    whole.triangles.topRows(nt) = half.triangles;
    for (int v = 0; v < nv; ++v) {
        const Eigen::Vector3d x = half.vertices.row(v);
        whole.vertices.row(nv + v) = x - 2 * (symmetry.normal.dot(x) - symmetry.offset) * symmetry.normal;
    }
    for (int t = 0; t < nt; ++t)
        whole.triangles.row(nt + t) << nv + half.triangles(t, 0), nv + half.triangles(t, 2), nv + half.triangles(t, 1);
    return whole;
}

Points folded(const Points& dJ_dv, const SymmetryPlane& symmetry) {
    const Eigen::Index nv = dJ_dv.rows() / 2;
    Points sum = dJ_dv.topRows(nv);
    for (Eigen::Index v = 0; v < nv; ++v) {
        const Eigen::Vector3d g = dJ_dv.row(nv + v);
        sum.row(v) += g - 2 * symmetry.normal.dot(g) * symmetry.normal;
    }
    return sum;
}

}  // namespace strake
