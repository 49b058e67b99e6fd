#include "core/error.hpp"
#include "core/mesh/disjoint_sets.hpp"
#include "core/repair/surface_parts.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

namespace strake::mending {
namespace {

/// A triangle seen along an edge.
struct Page {
    int triangle;
    double angle;  ///< around the edge, in (-pi, pi]
    int sense;     ///< 1: in the sense of the edge, with its outside ahead in `angle`; -1: opposite
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

struct Candidate {
    double turning;
    std::size_t i, j;
};

/// Pairs of opposite sense, the flattest first. Of very many pages each is compared only with those across from it.
std::vector<Candidate> candidates_at(const std::vector<Page>& pages) {
    constexpr std::size_t few = 64, near = 32;
    const std::size_t n = pages.size();
    std::vector<Candidate> candidates;
    const auto add = [&](std::size_t i, std::size_t j) {
        if (pages[i].sense != pages[j].sense) candidates.push_back({turning(pages[i], pages[j]), i, j});
    };
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t j = i + 1; n <= few && j < n; ++j) add(i, j);
        if (n <= few) continue;
        const double across = pages[i].angle + (pages[i].angle > 0 ? -std::numbers::pi : std::numbers::pi);
        const auto place = std::lower_bound(pages.begin(), pages.end(), across,
                                            [](const Page& page, double angle) { return page.angle < angle; });
        const std::size_t first = static_cast<std::size_t>(place - pages.begin()) + n - near;
        for (std::size_t k = 0; k < 2 * near; ++k) add(i, (first + k) % n);
    }
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](const Candidate& x, const Candidate& y) { return x.turning < y.turning; });
    return candidates;
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
    std::vector<char> taken(n);
    for (const Candidate& c : candidates_at(pages))
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

/// The corners of triangles that stay together, by number 3 t + k.
DisjointSets corners_kept_together(const TriMesh& mesh, const Adjacency& adjacent) {
    DisjointSets corners(3 * mesh.num_triangles());
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
    return corners;
}

/// Copies of vertices, each for the corners of one fan.
struct Copies {
    std::vector<Eigen::Vector3d> points;
    std::vector<std::pair<int, int>> renamed;  ///< corner, new vertex
};

/// Gives every fan at v but the first a copy of it. @return number of fans
std::size_t part_fans(const TriMesh& mesh, std::span<const int> triangles, int v, DisjointSets& corners,
                      Copies& copies) {
    std::vector<int> roots;
    for (const int t : triangles) roots.push_back(corners.root(corner_at(mesh, t, v)));
    std::vector<int> classes = roots;
    std::sort(classes.begin(), classes.end());
    classes.erase(std::unique(classes.begin(), classes.end()), classes.end());
    if (classes.size() < 2) return classes.size();
    const int first_copy = mesh.num_vertices() + static_cast<int>(copies.points.size());
    for (std::size_t i = 0; i < roots.size(); ++i) {
        const auto which = std::lower_bound(classes.begin(), classes.end(), roots[i]) - classes.begin();
        if (which > 0)
            copies.renamed.push_back({corner_at(mesh, triangles[i], v), first_copy + static_cast<int>(which) - 1});
    }
    copies.points.insert(copies.points.end(), classes.size() - 1, mesh.vertices.row(v));
    return classes.size();
}

}  // namespace

void split_nonmanifold(Surface& surface) {
    TriMesh& mesh = surface.mesh;
    const Adjacency adjacent = adjacency(mesh);
    DisjointSets corners = corners_kept_together(mesh, adjacent);
    Copies copies;
    for (int v = 0; v < mesh.num_vertices(); ++v)
        if (const std::size_t fans = part_fans(mesh, adjacent.vertex_triangles[v], v, corners, copies); fans > 1)
            surface.items.push_back({RepairKind::split, surface.input_vertex(v), -1, mesh.vertices.row(v), 0, 0,
                                     text("vertex ", v, " into ", fans)});
    const Triangles before = mesh.triangles;
    for (const auto& [corner, v] : copies.renamed)
        for (int k = 0, t = corner / 3; k < 3; ++k)  // a repeated corner counts once
            if (before(t, k) == before.data()[corner]) mesh.triangles(t, k) = v;
    surface.append_vertices(copies.points);
}

}  // namespace strake::mending
