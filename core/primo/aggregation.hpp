#pragma once
#include "core/primo/block_rows.hpp"

/// Clusters of neighbouring block rows, the coarse unknowns of aggregation multigrid (Vanek, Mandel, Brezina 1996).
namespace strake {

struct Clusters {
    std::vector<int> of;  ///< per row: its cluster
    int count = 0;
};

/// Clusters along strong connections only: |A_ij| >= threshold times the smaller of the strongest connections of i
/// and j, in the Frobenius norm of blocks scaled to unit diagonal. Without it, triangles of aspect ratio 11 stall
/// the iteration. A root takes what is within `radius` (1 or 2) connections of it.
/// @param A off-diagonal blocks, symmetric pattern.
template <class Real>
Clusters aggregate(const BlockRows<Real>& A, double threshold, int radius);

}  // namespace strake
