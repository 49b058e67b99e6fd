#pragma once
#include "core/primo/linear/block_rows.hpp"

/// Clusters of neighbouring block rows, the coarse unknowns of aggregation multigrid (Vanek, Mandel, Brezina 1996).
namespace strake {

struct Clusters {
    std::vector<int> of;  ///< per row: its cluster
    int count = 0;
};

/// Symmetric graph of the rows, with the strength of each connection.
struct Graph {
    std::vector<int> begin{0}, neighbour;
    std::vector<float> strength;
    int size() const { return static_cast<int>(begin.size()) - 1; }
};

/// Strong connections: at least `threshold` times the smaller of both rows' maxima. Without this, triangles of aspect
/// ratio 11 stall multigrid.
Graph strong_connections(const Graph& all, double threshold);

/// Clusters along connections: each root takes its neighbours within `radius` (1 or 2).
Clusters aggregate(const Graph& graph, int radius);

/// Clusters along the strong connections of A, in the Frobenius norm of blocks scaled to unit diagonal.
/// @param A off-diagonal blocks, symmetric pattern.
template <class Real>
Clusters aggregate(const BlockRows<Real>& A, double threshold, int radius);

}  // namespace strake
