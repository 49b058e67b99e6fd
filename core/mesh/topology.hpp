#pragma once
#include "core/mesh/adjacency.hpp"
#include "core/mesh/geometry.hpp"

#include <array>
#include <vector>

/// Exact topology of a surface, for `strake info` and to refuse surfaces that cannot be deformed.
namespace strake {

struct TopologyFacts {
    int components = 0;                            ///< edge-connected
    std::vector<std::vector<int>> boundary_loops;  ///< vertices of each connected boundary; loops that touch are one
    std::vector<int> nonmanifold_edges;            ///< edge numbers: more than two triangles
    std::vector<int> nonmanifold_vertices;         ///< whose triangles do not form one fan
    std::vector<int> misoriented_edges;
    std::vector<int> duplicate_triangles;   ///< same three vertices as an earlier one
    std::vector<int> degenerate_triangles;  ///< area below 1e-14 diagonal^2 or a repeated vertex
    std::vector<int> isolated_vertices;     ///< in no triangle
    std::vector<int> duplicate_vertices;    ///< at the coordinates of an earlier one
    bool orientable = true;                 ///< triangles can be flipped until neighbours agree at every edge of two
    bool closed = false;                    ///< every edge has two triangles that agree, at least one triangle
};
TopologyFacts topology(const TriMesh& mesh, const Adjacency& adjacent);

/// Triangles connected across edges of two.
struct Sheet {
    std::vector<int> triangles;  ///< ascending
    std::vector<char> turned;    ///< parallel to `triangles`: must be flipped to agree with the first one
    bool orientable = true;
};
/// All sheets, in the order of their smallest triangles.
std::vector<Sheet> sheets_of(const TriMesh& mesh, const Adjacency& adjacent);

/// Pairs of triangles that intersect away from shared vertices and edges, each list ascending.
/// Vertices with equal coordinates count as shared. Exact predicates. TopologyFacts covers duplicate and degenerate
/// triangles.
struct Intersections {
    std::vector<std::array<int, 2>> apart;     ///< sharing no vertex
    std::vector<std::array<int, 2>> adjacent;  ///< sharing a vertex or an edge: folded or pierced beside it
};
/// Cost: n log n plus the pairs whose boxes meet, among them all pairs around a vertex.
Intersections intersections(const TriMesh& mesh);

/// intersections().apart.
std::vector<std::array<int, 2>> self_intersections(const TriMesh& mesh);

}  // namespace strake
