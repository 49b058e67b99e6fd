#include "core/mesh/topology.hpp"

#include "core/mesh/weld.hpp"

#include <algorithm>
#include <array>
#include <map>

namespace strake {
namespace {

/// The edge of triangle t at vertex v that is not e.
int other_edge_at(const TriMesh& mesh, const Adjacency& adjacent, int t, int v, int e) {
    for (int k = 0; k < 3; ++k) {
        const int candidate = adjacent.triangle_edges(t, k);
        const bool at_v = mesh.triangles(t, k) == v || mesh.triangles(t, (k + 1) % 3) == v;
        if (at_v && candidate != e) return candidate;
    }
    return -1;
}

/// Boundary edges at each vertex that has any.
using BoundaryEdges = std::map<int, std::vector<int>>;

class LoopWalk {
public:
    LoopWalk(const TriMesh& mesh, const Adjacency& adjacent)
        : mesh_(mesh), adjacent_(adjacent), used_(adjacent.edges.size()) {
        for (int e = 0; e < adjacent.num_edges(); ++e)
            if (adjacent.edge_triangles[e].size() == 1)
                for (const int v : adjacent.edges[e]) at_vertex_[v].push_back(e);
    }

    /// One list per connected boundary: loops that touch in a vertex follow each other.
    std::vector<std::vector<int>> loops() {
        std::vector<std::vector<int>> found;
        std::map<int, std::size_t> owner;  // of each vertex met
        for (int e = 0; e < adjacent_.num_edges(); ++e) {
            if (adjacent_.edge_triangles[e].size() != 1 || used_[e]) continue;
            const std::vector<int> loop = walk(e);
            join(found, owner, loop);
        }
        std::erase_if(found, [](const auto& loop) { return loop.empty(); });
        return found;
    }

private:
    /// Appends the loop to the earliest of those that it touches, and the others to that one.
    static void join(std::vector<std::vector<int>>& found, std::map<int, std::size_t>& owner,
                     const std::vector<int>& loop) {
        std::size_t target = found.size();
        for (const int v : loop)
            if (const auto at = owner.find(v); at != owner.end()) target = std::min(target, at->second);
        if (target == found.size()) found.emplace_back();
        std::vector<std::size_t> touched;
        for (const int v : loop)
            if (const auto at = owner.find(v); at != owner.end() && at->second != target) touched.push_back(at->second);
        std::sort(touched.begin(), touched.end());
        touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
        for (const std::size_t other : touched) {
            for (const int v : found[other]) owner[v] = target;
            found[target].insert(found[target].end(), found[other].begin(), found[other].end());
            found[other].clear();
        }
        for (const int v : loop) owner[v] = target;
        found[target].insert(found[target].end(), loop.begin(), loop.end());
    }

    /// From the first vertex of edge e, as its triangle runs through it, until no unused edge continues.
    std::vector<int> walk(int e) {
        const int t = adjacent_.edge_triangles[e][0];
        int k = 0;
        while (adjacent_.triangle_edges(t, k) != e) ++k;
        std::vector<int> loop{mesh_.triangles(t, k)};
        int v = mesh_.triangles(t, (k + 1) % 3);
        while (true) {
            used_[e] = 1;
            if (v == loop.front()) return loop;
            loop.push_back(v);
            e = next(v);
            if (e < 0) return loop;
            v = adjacent_.edges[e][0] == v ? adjacent_.edges[e][1] : adjacent_.edges[e][0];
        }
    }

    int next(int v) const {
        for (const int candidate : at_vertex_.at(v))
            if (!used_[candidate]) return candidate;
        return -1;
    }

    const TriMesh& mesh_;
    const Adjacency& adjacent_;
    std::vector<char> used_;
    BoundaryEdges at_vertex_;
};

/// Whether the triangles at v are connected through edges at v that have exactly two triangles, and open at most once.
bool is_one_fan(const TriMesh& mesh, const Adjacency& adjacent, int v) {
    const auto triangles = adjacent.vertex_triangles[v];
    if (triangles.size() < 2) return true;
    // Walk both ways from the first triangle; all must be met.
    std::size_t met = 1;
    const int first = triangles[0];
    std::array<int, 2> sides{-1, -1};
    int num_sides = 0;
    for (int k = 0; k < 3; ++k)
        if (mesh.triangles(first, k) == v || mesh.triangles(first, (k + 1) % 3) == v)
            if (num_sides < 2) sides[num_sides++] = adjacent.triangle_edges(first, k);
    for (int e : sides) {
        int t = first;
        while (e >= 0 && adjacent.edge_triangles[e].size() == 2) {
            const auto pair = adjacent.edge_triangles[e];
            t = pair[0] == t ? pair[1] : pair[0];
            if (t == first) return met == triangles.size();  // closed fan
            if (++met > triangles.size()) return false;
            e = other_edge_at(mesh, adjacent, t, v, e);
        }
        if (e >= 0 && adjacent.edge_triangles[e].size() > 2) return false;
    }
    return met == triangles.size();
}

std::array<int, 3> sorted_corners(const TriMesh& mesh, int t) {
    std::array<int, 3> corners{mesh.triangles(t, 0), mesh.triangles(t, 1), mesh.triangles(t, 2)};
    std::sort(corners.begin(), corners.end());
    return corners;
}

std::vector<int> duplicate_triangles(const TriMesh& mesh) {
    std::vector<std::pair<std::array<int, 3>, int>> keys;
    for (int t = 0; t < mesh.num_triangles(); ++t) keys.push_back({sorted_corners(mesh, t), t});
    std::sort(keys.begin(), keys.end());
    std::vector<int> duplicates;
    for (std::size_t i = 1; i < keys.size(); ++i)
        if (keys[i].first == keys[i - 1].first) duplicates.push_back(keys[i].second);
    std::sort(duplicates.begin(), duplicates.end());
    return duplicates;
}

/// Vertices that no triangle uses, and vertices with the coordinates of an earlier one.
void find_spare_vertices(const TriMesh& mesh, const Adjacency& adjacent, TopologyFacts& facts) {
    const std::vector<int> number = equal_points(mesh.vertices);
    int count = 0;
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        if (adjacent.vertex_triangles[v].empty()) facts.isolated_vertices.push_back(v);
        if (number[v] == count)
            ++count;
        else
            facts.duplicate_vertices.push_back(v);
    }
}

std::vector<int> degenerate_triangles(const TriMesh& mesh) {
    const double diagonal = box_diagonal(mesh);
    const Eigen::VectorXd areas = triangle_areas(mesh);
    std::vector<int> degenerate;
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        const auto c = sorted_corners(mesh, t);
        if (c[0] == c[1] || c[1] == c[2] || !(areas[t] >= 1e-14 * diagonal * diagonal)) degenerate.push_back(t);
    }
    return degenerate;
}

}  // namespace

std::vector<Sheet> sheets_of(const TriMesh& mesh, const Adjacency& adjacent) {
    std::vector<Sheet> sheets;
    std::vector<signed char> turned(static_cast<std::size_t>(mesh.num_triangles()), -1);
    for (int seed = 0; seed < mesh.num_triangles(); ++seed) {
        if (turned[seed] >= 0) continue;
        Sheet sheet;
        turned[seed] = 0;
        sheet.triangles = {seed};
        for (std::size_t i = 0; i < sheet.triangles.size(); ++i) {
            const int t = sheet.triangles[i];
            for (int k = 0; k < 3; ++k) {
                const int e = adjacent.triangle_edges(t, k);
                const auto pair = adjacent.edge_triangles[e];
                if (pair.size() != 2 || pair[0] == pair[1]) continue;
                const int n = pair[0] == t ? pair[1] : pair[0];
                const auto side = static_cast<signed char>(turned[t] ^ adjacent.misoriented[e]);
                if (turned[n] < 0) {
                    turned[n] = side;
                    sheet.triangles.push_back(n);
                } else if (turned[n] != side) {
                    sheet.orientable = false;
                }
            }
        }
        std::sort(sheet.triangles.begin(), sheet.triangles.end());
        for (const int t : sheet.triangles) sheet.turned.push_back(turned[t]);
        sheets.push_back(std::move(sheet));
    }
    return sheets;
}

TopologyFacts topology(const TriMesh& mesh, const Adjacency& adjacent) {
    TopologyFacts facts;
    const std::vector<int> component = edge_components(mesh, adjacent);
    facts.components = component.empty() ? 0 : *std::max_element(component.begin(), component.end()) + 1;
    facts.boundary_loops = LoopWalk(mesh, adjacent).loops();
    facts.closed = mesh.num_triangles() > 0;
    for (int e = 0; e < adjacent.num_edges(); ++e) {
        if (adjacent.edge_triangles[e].size() > 2) facts.nonmanifold_edges.push_back(e);
        if (adjacent.misoriented[e]) facts.misoriented_edges.push_back(e);
        facts.closed = facts.closed && adjacent.is_regular(e);
    }
    for (int v = 0; v < mesh.num_vertices(); ++v)
        if (!is_one_fan(mesh, adjacent, v)) facts.nonmanifold_vertices.push_back(v);
    facts.duplicate_triangles = duplicate_triangles(mesh);
    facts.degenerate_triangles = degenerate_triangles(mesh);
    facts.orientable = std::ranges::all_of(sheets_of(mesh, adjacent), &Sheet::orientable);
    find_spare_vertices(mesh, adjacent, facts);
    return facts;
}

}  // namespace strake
