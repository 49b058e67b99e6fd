#pragma once
#include "core/mesh/adjacency.hpp"

#include <vector>

namespace strake::mending {

/// The ends of open edges.
struct OpenVertices {
    std::vector<char> is_open;  ///< per vertex
    std::vector<int> numbers;   ///< ascending
    Points points;              ///< beside `numbers`
};
OpenVertices open_vertices(const TriMesh& mesh, const Adjacency& adjacent);

/// Limit of vertices near open edges tested for cracks: seconds of work.
constexpr std::size_t max_looked_at_for_cracks = 100'000'000;

}  // namespace strake::mending
