#include "core/error.hpp"
#include "core/mesh/adjacency.hpp"
#include "core/mesh/topology.hpp"
#include "core/repair/joint_gap.hpp"
#include "core/repair/surface_parts.hpp"

#include <algorithm>
#include <cmath>

/// Shorter edges where parts pass through each other. Triangles stay flat when the surface is bent: along the cut of
/// two parts each leaves the bent shape by up to edge^2 / 8 times its curvature, and the joint opens.
namespace strake::mending {
namespace {

constexpr int max_added = 4'000'000;  ///< triangles
constexpr int max_rounds = 60;        ///< each halves edges: beyond that lengths are rounding

/// Edges longer than the limit of triangles that another part cuts. @param cut marks of these triangles
std::vector<char> long_edges(const TriMesh& mesh, const Adjacency& adjacent, double limit, std::vector<char>& cut) {
    const std::vector<int> part = part_of_triangles(mesh);
    cut.assign(part.size(), 0);
    for (const auto& [s, t] : intersections(mesh).apart)
        if (part[s] != part[t]) cut[s] = cut[t] = 1;
    std::vector<char> is_long(static_cast<std::size_t>(adjacent.num_edges()), 0);
    for (int t = 0; t < mesh.num_triangles(); ++t)
        for (int k = 0; cut[t] && k < 3; ++k) {
            const int e = adjacent.triangle_edges(t, k);
            const auto [a, b] = adjacent.edges[static_cast<std::size_t>(e)];
            is_long[e] |= (mesh.vertices.row(a) - mesh.vertices.row(b)).norm() > limit;
        }
    return is_long;
}

/// At least so many triangles are made: those along a cut through each triangle.
double expected(const TriMesh& mesh, double limit, const std::vector<char>& cut) {
    double count = 0;
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        double longest = 0;
        for (int k = 0; cut[t] && k < 3; ++k)
            longest = std::max(
                longest,
                (mesh.vertices.row(mesh.triangles(t, k)) - mesh.vertices.row(mesh.triangles(t, (k + 1) % 3))).norm());
        count += longest / limit;
    }
    return count;
}

/// A triangle with some of its edges halved, in the sense of its corners. @param middle of the edge from corner k to
/// the next; -1: it stays whole
std::vector<std::array<int, 3>> pieces(const std::array<int, 3>& corner, const std::array<int, 3>& middle,
                                       const Points& at) {
    const auto count = std::count_if(middle.begin(), middle.end(), [](int m) { return m >= 0; });
    const auto [a, b, c] = corner;
    if (count == 0) return {corner};
    if (count == 3)
        return {{a, middle[0], middle[2]},
                {middle[0], b, middle[1]},
                {middle[2], middle[1], c},
                {middle[0], middle[1], middle[2]}};
    int k = 0;  // one: the edge that is halved; two: the first of them, the other one follows
    while (middle[k] < 0 || (count == 2 && middle[(k + 1) % 3] < 0)) ++k;
    const int p = corner[k], q = corner[(k + 1) % 3], r = corner[(k + 2) % 3], m = middle[k];
    if (count == 1) return {{p, m, r}, {m, q, r}};
    const int n = middle[(k + 1) % 3];
    if ((at.row(p) - at.row(n)).norm() < (at.row(m) - at.row(r)).norm()) return {{m, q, n}, {p, m, n}, {p, n, r}};
    return {{m, q, n}, {m, n, r}, {p, m, r}};
}

/// Vertices in the middle of the edges marked; per edge its number, -1: none.
std::vector<int> add_middles(Surface& surface, const Adjacency& adjacent, const std::vector<char>& is_long) {
    std::vector<int> middle(is_long.size(), -1);
    std::vector<Eigen::Vector3d> points;
    for (std::size_t e = 0; e < is_long.size(); ++e) {
        if (!is_long[e]) continue;
        const auto [a, b] = adjacent.edges[e];
        middle[e] = surface.mesh.num_vertices() + static_cast<int>(points.size());
        points.push_back(0.5 * (surface.mesh.vertices.row(a) + surface.mesh.vertices.row(b)));
    }
    surface.append_vertices(points);
    return middle;
}

/// Splits all triangles at edges with a middle. @param origin per triangle, where it was before the first call
void split_at(Surface& surface, const Adjacency& adjacent, const std::vector<int>& middle, std::vector<int>& origin,
              std::vector<int>& added) {
    TriMesh& mesh = surface.mesh;
    std::vector<std::array<int, 3>> more;
    std::vector<int> source, group;
    for (int t = 0, count = mesh.num_triangles(); t < count; ++t) {
        std::array<int, 3> corner{}, of{};
        for (int k = 0; k < 3; ++k) corner[k] = mesh.triangles(t, k), of[k] = middle[adjacent.triangle_edges(t, k)];
        const auto parts = pieces(corner, of, mesh.vertices);
        for (int k = 0; k < 3; ++k) mesh.triangles(t, k) = parts[0][k];
        for (std::size_t i = 1; i < parts.size(); ++i) {
            more.push_back(parts[i]);
            source.push_back(surface.source[t]);
            if (!mesh.group.empty()) group.push_back(mesh.group[t]);
            origin.push_back(origin[t]);
            ++added[origin[t]];
        }
    }
    surface.append(more, source, group);
}

}  // namespace

void split_joints(Surface& surface, double limit) {
    const int input = surface.mesh.num_triangles();
    std::vector<int> origin(static_cast<std::size_t>(input));
    for (int t = 0; t < input; ++t) origin[t] = t;
    std::vector<int> added(origin.size(), 0);
    std::vector<char> cut, was_cut;
    for (int round = 0; round < max_rounds; ++round) {
        const Adjacency adjacent = adjacency(surface.mesh);
        const std::vector<char> is_long = long_edges(surface.mesh, adjacent, limit, cut);
        if (std::find(is_long.begin(), is_long.end(), 1) == is_long.end()) break;
        if (round == 0) was_cut = cut;
        const double awaited = round == 0 ? expected(surface.mesh, limit, cut) : 0;
        if (surface.mesh.num_triangles() - input + awaited > max_added)
            throw InvalidInput(text("repair: joints = ", limit, " would add more than ", max_added,
                                    " triangles where parts pass through each other; state a longer length"));
        split_at(surface, adjacent, add_middles(surface, adjacent, is_long), origin, added);
    }
    for (int t = 0; t < input; ++t) {
        if (added[t] == 0) continue;
        const char* why = was_cut[t] ? ", cut by another part, is " : ", beside such a cut, is ";
        surface.items.push_back({RepairKind::joint, -1, surface.source[t], surface.center(t), limit, added[t],
                                 text("triangle ", surface.source[t], why, added[t] + 1, " now")});
    }
}

}  // namespace strake::mending
