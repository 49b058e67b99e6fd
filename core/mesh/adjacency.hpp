#pragma once
#include "core/mesh/mesh.hpp"

#include <array>
#include <span>
#include <vector>

/// Neighbours of vertices, edges and triangles. Built once, in O(m log m); lists are ascending, for deterministic
/// results.
namespace strake {

/// Lists of int, one per row, stored end to end.
struct IntLists {
    std::vector<int> begin{0};  ///< rows + 1
    std::vector<int> items;
    int size() const { return static_cast<int>(begin.size()) - 1; }
    std::span<const int> operator[](int row) const {
        return {items.data() + begin[row], static_cast<std::size_t>(begin[row + 1] - begin[row])};
    }
};

struct Adjacency {
    std::vector<std::array<int, 2>> edges;  ///< vertex pairs, smaller first, sorted
    IntLists edge_triangles;                ///< triangles at an edge: 1 boundary, 2 interior, else non-manifold
    Triangles triangle_edges;               ///< m x 3: edge from corner k to corner k+1
    IntLists vertex_triangles;              ///< triangles at a vertex
    std::vector<char> misoriented;          ///< per edge: its two triangles traverse it in the same direction

    int num_edges() const { return static_cast<int>(edges.size()); }
    /// Exactly two triangles that agree in orientation.
    bool is_regular(int e) const { return edge_triangles[e].size() == 2 && !misoriented[e]; }
};
Adjacency adjacency(const TriMesh& mesh);

/// Number per triangle of its edge-connected component, counted from 0 in the order of the smallest triangle.
std::vector<int> edge_components(const TriMesh& mesh, const Adjacency& adjacent);

}  // namespace strake
