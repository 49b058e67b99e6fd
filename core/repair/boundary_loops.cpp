#include "core/repair/surface_parts.hpp"

#include <map>

namespace strake::mending {
namespace {

/// The open edge that continues the boundary after corner k + 1 of triangle t, whose side k is open: found by turning
/// around that vertex. -1: blocked by a fault.
int next_side(const TriMesh& mesh, const Adjacency& adjacent, int side) {
    int t = side / 3, k = (side % 3 + 1) % 3;  // the side of t that starts at the vertex
    const int v = mesh.triangles(t, k);
    for (std::size_t step = 0; step <= adjacent.vertex_triangles[v].size(); ++step) {
        const int e = adjacent.triangle_edges(t, k);
        const auto at = adjacent.edge_triangles[e];
        if (at.size() == 1) return 3 * t + k;
        if (!adjacent.is_regular(e) || at[0] == at[1]) return -1;
        t = at[0] == t ? at[1] : at[0];
        k = 0;
        while (k < 2 && mesh.triangles(t, k) != v) ++k;
    }
    return -1;
}

/// Splits a closed walk at repeated vertices.
void cut(const OpenLoop& walk, std::vector<OpenLoop>& loops) {
    OpenLoop open;
    std::map<int, std::ptrdiff_t> place;  // in `open`
    for (std::size_t i = 0; i < walk.vertices.size(); ++i) {
        if (const auto seen = place.find(walk.vertices[i]); seen != place.end()) {
            const auto from = seen->second;
            OpenLoop closed{{open.vertices.begin() + from, open.vertices.end()},
                            {open.triangles.begin() + from, open.triangles.end()}};
            for (const int v : closed.vertices) place.erase(v);
            loops.push_back(std::move(closed));
            open.vertices.resize(static_cast<std::size_t>(from));
            open.triangles.resize(static_cast<std::size_t>(from));
        }
        place[walk.vertices[i]] = std::ssize(open.vertices);
        open.vertices.push_back(walk.vertices[i]);
        open.triangles.push_back(walk.triangles[i]);
    }
    loops.push_back(std::move(open));
}

}  // namespace

std::vector<OpenLoop> open_loops(const TriMesh& mesh, const Adjacency& adjacent, int& blocked) {
    std::vector<OpenLoop> loops;
    std::vector<char> met(static_cast<std::size_t>(3 * mesh.num_triangles()));
    blocked = 0;
    for (int first = 0; first < 3 * mesh.num_triangles(); ++first) {
        if (met[first] || adjacent.edge_triangles[adjacent.triangle_edges(first / 3, first % 3)].size() != 1) continue;
        OpenLoop walk;
        int side = first;
        do {
            met[side] = 1;
            walk.vertices.push_back(mesh.triangles(side / 3, side % 3));
            walk.triangles.push_back(side / 3);
            side = next_side(mesh, adjacent, side);
        } while (side >= 0 && side != first && !met[side]);
        if (side == first)
            cut(walk, loops);
        else
            ++blocked;
    }
    return loops;
}

}  // namespace strake::mending
