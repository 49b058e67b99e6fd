#include "core/error.hpp"
#include "core/repair/surface_parts.hpp"

#include <algorithm>
#include <map>

namespace strake::mending {
namespace {

double size_of(const Points& polygon) { return (polygon.colwise().maxCoeff() - polygon.colwise().minCoeff()).norm(); }

/// Group with most of the loop's edges; tie: the smallest.
int group_around(const TriMesh& mesh, const OpenLoop& loop) {
    std::map<int, int> count;
    for (const int t : loop.triangles) ++count[mesh.group[t]];
    return std::max_element(count.begin(), count.end(),
                            [](const auto& a, const auto& b) { return a.second < b.second; })
        ->first;
}

/// Loops that are to stay open, by one of their vertices.
bool stays_open(const RepairOptions& options, double diagonal, const std::vector<BoundaryLoop>& planes, int vertex) {
    for (const BoundaryLoop& plane : planes)
        if (((options.keep_symmetry_loops && plane.symmetry_axis >= 0) || is_meant(options, plane, diagonal)) &&
            std::find(plane.vertices.begin(), plane.vertices.end(), vertex) != plane.vertices.end())
            return true;
    return false;
}

/// What fills the holes, before it is appended.
struct Fills {
    std::vector<Eigen::Vector3d> points;
    std::vector<std::array<int, 3>> triangles;
    std::vector<int> group;
    std::vector<RepairItem> items;
};

void fill(const Surface& surface, const Adjacency& adjacent, const OpenLoop& loop, HoleFill how, Fills& fills) {
    const TriMesh& mesh = surface.mesh;
    const auto n = static_cast<Eigen::Index>(loop.vertices.size());
    Points polygon(n, 3), normals(n, 3);
    for (Eigen::Index i = 0; i < n; ++i) {
        polygon.row(i) = mesh.vertices.row(loop.vertices[i]);
        const Eigen::Vector3d area = area_vector(mesh, loop.triangles[i]);
        normals.row(i) =
            area.norm() > 0 ? Eigen::Vector3d(area.normalized()) : Eigen::Vector3d(Eigen::Vector3d::Zero());
    }
    const IsTaken is_taken = [&](int a, int b) {
        return std::binary_search(adjacent.edges.begin(), adjacent.edges.end(),
                                  std::array{std::min(a, b), std::max(a, b)});
    };
    const auto numbers = fill_polygon(polygon, normals, 1e-6 * surface.diagonal,
                                      [&](int i, int j) { return is_taken(loop.vertices[i], loop.vertices[j]); });
    std::vector<std::array<int, 3>> triangles;
    for (const auto& [a, b, c] : numbers) triangles.push_back({loop.vertices[a], loop.vertices[b], loop.vertices[c]});
    const int before = mesh.num_vertices() + static_cast<int>(fills.points.size());
    const std::size_t points_before = fills.points.size();
    if (triangles.empty()) {  // every diagonal is taken: a fan around a new vertex
        for (Eigen::Index i = 0; i < n; ++i)
            triangles.push_back({loop.vertices[(i + 1) % n], loop.vertices[i], before});
        fills.points.push_back(polygon.colwise().mean().transpose());
    } else if (how == HoleFill::smooth) {
        Patch patch = smooth_patch(mesh, adjacent, loop.vertices, triangles, before);
        fills.points.insert(fills.points.end(), patch.points.begin(), patch.points.end());
        triangles = std::move(patch.triangles);
    }
    const std::size_t added = fills.points.size() - points_before;
    if (!mesh.group.empty()) fills.group.insert(fills.group.end(), triangles.size(), group_around(mesh, loop));
    fills.items.push_back(
        {RepairKind::hole, surface.input_vertex(loop.vertices[0]), -1, polygon.colwise().mean().transpose(),
         size_of(polygon), static_cast<int>(triangles.size()),
         text("loop of ", n, " edges from vertex ", loop.vertices[0], ", ", size_of(polygon), " across, closed by ",
              triangles.size(), " triangles", added > 0 ? text(" and ", added, " vertices") : "")});
    fills.triangles.insert(fills.triangles.end(), triangles.begin(), triangles.end());
}

/// The loops to fill.
/// @param refused incremented for loops around a single triangle, whose back is no fill.
std::vector<OpenLoop> wanted_loops(const TriMesh& mesh, const Adjacency& adjacent, const RepairOptions& options,
                                   int& refused) {
    int blocked = 0;
    std::vector<OpenLoop> loops = open_loops(mesh, adjacent, blocked);
    std::vector<BoundaryLoop> planes;
    const double diagonal = box_diagonal(mesh);
    if (options.keep_symmetry_loops || options.symmetry)
        planes = measured_loops(mesh, adjacent, topology(mesh, adjacent).boundary_loops);
    std::erase_if(loops, [&](const OpenLoop& loop) {
        if (loop.vertices.size() < 3) return true;
        Points polygon(static_cast<Eigen::Index>(loop.vertices.size()), 3);
        for (std::size_t i = 0; i < loop.vertices.size(); ++i)
            polygon.row(static_cast<Eigen::Index>(i)) = mesh.vertices.row(loop.vertices[i]);
        return size_of(polygon) > *options.holes || stays_open(options, diagonal, planes, loop.vertices[0]);
    });
    refused += static_cast<int>(std::erase_if(loops, [](const OpenLoop& loop) {
        return loop.vertices.size() == 3 && loop.triangles[0] == loop.triangles[1] &&
               loop.triangles[1] == loop.triangles[2];
    }));
    return loops;
}

constexpr double back_to_back = -1 + 1e-8;  ///< cosine between normals: folded by 179.99 degrees

/// Loops, by number, whose fill passes through the surface or another fill, or lies back to back with its neighbours:
/// the loop around a flat sheet is no hole.
std::vector<char> passing_through(const TriMesh& mesh, const std::vector<int>& begin) {
    std::vector<char> is_bad(begin.size());
    const auto note = [&](int t) {
        if (t >= begin[0])
            is_bad[static_cast<std::size_t>(std::upper_bound(begin.begin(), begin.end(), t) - begin.begin() - 1)] = 1;
    };
    const Adjacency adjacent = adjacency(mesh);
    const Points normal = triangle_normals(mesh);
    for (int e = 0; e < adjacent.num_edges(); ++e) {
        const auto pair = adjacent.edge_triangles[e];
        if (adjacent.is_regular(e) && pair[0] < begin[0] && normal.row(pair[0]).dot(normal.row(pair[1])) < back_to_back)
            note(pair[1]);
    }
    // Only against the surface first: bad fills may pass through good ones.
    if (std::find(is_bad.begin(), is_bad.end(), 1) != is_bad.end()) return is_bad;
    for (const auto& pair : self_intersections(mesh))
        for (const int t : pair) note(t);
    return is_bad;
}

bool is_costly(const Adjacency& adjacent) {
    for (int v = 0; v < adjacent.vertex_triangles.size(); ++v)
        if (adjacent.vertex_triangles[v].size() > 10'000) return true;
    return false;
}

}  // namespace

int fill_holes(Surface& surface, const RepairOptions& options) {
    const Surface rest = surface;  // fills are computed independently
    const Adjacency adjacent = adjacency(rest.mesh);
    int refused = 0;
    std::vector<OpenLoop> loops = wanted_loops(rest.mesh, adjacent, options, refused);
    if (loops.empty()) return refused;
    while (true) {
        std::vector<int> begin;
        Fills fills;
        for (const OpenLoop& loop : loops) {
            begin.push_back(rest.mesh.num_triangles() + static_cast<int>(fills.triangles.size()));
            fill(rest, adjacent, loop, options.fill, fills);
        }
        surface.append_vertices(fills.points);
        surface.append(fills.triangles, std::vector<int>(fills.triangles.size(), -1), fills.group);
        surface.items.insert(surface.items.end(), fills.items.begin(), fills.items.end());
        if (loops.empty() || is_costly(adjacent)) return refused;
        const std::vector<char> is_bad = passing_through(surface.mesh, begin);
        const auto bad = static_cast<int>(std::count(is_bad.begin(), is_bad.end(), 1));
        if (bad == 0) return refused;
        refused += bad;
        surface = rest;
        std::erase_if(loops,
                      [&](const OpenLoop& loop) { return is_bad[static_cast<std::size_t>(&loop - loops.data())]; });
    }
}

}  // namespace strake::mending
