#include "core/error.hpp"
#include "core/mesh/disjoint_sets.hpp"
#include "core/repair/surface_parts.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace strake::mending {
namespace {

/// A triangle seen along an edge.
struct Page {
    int triangle;
    double angle;  ///< around the edge, in (-pi, pi]
    int sense;     ///< 1: runs as the edge, its outside lies ahead in `angle`; -1: the other way
};

std::vector<Page> pages_at(const TriMesh& mesh, const Adjacency& adjacent, int e) {
    const auto [a, b] = adjacent.edges[e];
    const Eigen::Vector3d origin = mesh.vertices.row(a);
    const Eigen::Vector3d axis = (mesh.vertices.row(b).transpose() - origin).normalized();
    std::vector<Page> pages;
    Eigen::Vector3d u = Eigen::Vector3d::Zero(), w = u;
    for (const int t : adjacent.edge_triangles[e]) {
        int k = 0;
        while (adjacent.triangle_edges(t, k) != e) ++k;
        const int apex = mesh.triangles(t, (k + 2) % 3);
        const Eigen::Vector3d arm = mesh.vertices.row(apex).transpose() - origin;
        const Eigen::Vector3d out = arm - arm.dot(axis) * axis;
        if (pages.empty()) {
            u = out.normalized();
            w = axis.cross(u);
        }
        pages.push_back({t, std::atan2(out.dot(w), out.dot(u)), mesh.triangles(t, k) == a ? 1 : -1});
    }
    std::stable_sort(pages.begin(), pages.end(), [](const Page& x, const Page& y) { return x.angle < y.angle; });
    return pages;
}

double turning(const Page& x, const Page& y) {
    const double between = std::abs(x.angle - y.angle);
    return std::abs(std::numbers::pi - std::min(between, 2 * std::numbers::pi - between));
}

/// Which two triangles stay together at an edge of more than two.
std::vector<std::array<int, 2>> pairs_at(const std::vector<Page>& pages) {
    const std::size_t n = pages.size();
    std::vector<std::array<int, 2>> pairs;
    bool alternate = n % 2 == 0;
    for (std::size_t i = 0; i < n; ++i) alternate = alternate && pages[i].sense != pages[(i + 1) % n].sense;
    if (alternate) {
        // A normal of sense 1 points ahead: the solid lies behind, towards the page before.
        for (std::size_t i = 0; i < n; ++i)
            if (pages[i].sense > 0) pairs.push_back({pages[i].triangle, pages[(i + n - 1) % n].triangle});
        return pairs;
    }
    struct Candidate {
        double turning;
        std::size_t i, j;
    };
    std::vector<Candidate> candidates;
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = i + 1; j < n; ++j)
            if (pages[i].sense != pages[j].sense) candidates.push_back({turning(pages[i], pages[j]), i, j});
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](const Candidate& x, const Candidate& y) { return x.turning < y.turning; });
    std::vector<char> taken(n);
    for (const Candidate& c : candidates)
        if (!taken[c.i] && !taken[c.j]) {
            taken[c.i] = taken[c.j] = 1;
            pairs.push_back({pages[c.i].triangle, pages[c.j].triangle});
        }
    return pairs;
}

int corner_at(const TriMesh& mesh, int t, int v) {
    int k = 0;
    while (k < 2 && mesh.triangles(t, k) != v) ++k;
    return 3 * t + k;
}

}  // namespace

void split_nonmanifold(Surface& surface) {
    TriMesh& mesh = surface.mesh;
    const Adjacency adjacent = adjacency(mesh);
    DisjointSets corners(3 * mesh.num_triangles());  // 3 t + k: those that stay together
    const auto keep = [&](int e, int s, int t) {
        for (const int v : adjacent.edges[e]) corners.join(corner_at(mesh, s, v), corner_at(mesh, t, v));
    };
    for (int e = 0; e < adjacent.num_edges(); ++e) {
        const auto at = adjacent.edge_triangles[e];
        if (adjacent.edges[e][0] == adjacent.edges[e][1]) continue;
        if (at.size() == 2) keep(e, at[0], at[1]);
        if (at.size() > 2)
            for (const auto& [s, t] : pairs_at(pages_at(mesh, adjacent, e))) keep(e, s, t);
    }
    std::vector<Eigen::Vector3d> copies;
    std::vector<std::pair<int, int>> renamed;  // corner, vertex
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        std::vector<int> roots;
        for (const int t : adjacent.vertex_triangles[v]) roots.push_back(corners.root(corner_at(mesh, t, v)));
        std::vector<int> classes = roots;
        std::sort(classes.begin(), classes.end());
        classes.erase(std::unique(classes.begin(), classes.end()), classes.end());
        if (classes.size() < 2) continue;
        const int first_copy = mesh.num_vertices() + static_cast<int>(copies.size());
        for (std::size_t i = 0; i < roots.size(); ++i) {
            const auto which = std::lower_bound(classes.begin(), classes.end(), roots[i]) - classes.begin();
            if (which > 0)
                renamed.push_back(
                    {corner_at(mesh, adjacent.vertex_triangles[v][i], v), first_copy + static_cast<int>(which) - 1});
        }
        copies.insert(copies.end(), classes.size() - 1, mesh.vertices.row(v));
        surface.items.push_back({RepairKind::split, surface.input_vertex(v), -1, mesh.vertices.row(v), 0, 0,
                                 text("vertex ", v, " into ", classes.size())});
    }
    const Triangles before = mesh.triangles;
    for (const auto& [corner, v] : renamed)
        for (int k = 0, t = corner / 3; k < 3; ++k)  // a corner that stands there twice goes as one
            if (before(t, k) == before.data()[corner]) mesh.triangles(t, k) = v;
    surface.append_vertices(copies);
}

}  // namespace strake::mending
