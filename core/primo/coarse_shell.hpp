#pragma once
#include "core/primo/linear/aggregation.hpp"
#include "core/primo/rest_state.hpp"

/// A shell of fewer prisms for a first approximation of a large deformation (nested iteration): each cluster of free
/// prisms becomes one rigid prism, coupled by the faces between clusters. A face represents the shell between the
/// centres of its two prisms and is softer in proportion to their distance.
namespace strake {

struct CoarseShell {
    RestState rest;       ///< vertices, loads and pinned regions as in the finer one; no attached parts
    std::vector<int> of;  ///< per finer prism: its coarse one
    Graph neighbours;     ///< free prisms of the finer shell that share a face
};

/// Clusters of about four (`radius` 1) or ten (2) free prisms; one for each pinned region.
CoarseShell coarsen(const RestState& rest, int radius);

/// Poses of the finer prisms from their coarse ones; smoothed to reduce jumps between clusters. Pinned prisms get the
/// pose of their region.
/// @param shell from `coarsen`; `coarse` is its `rest`, which may have been moved out
/// @param poses of the coarse prisms
Poses prolonged(const RestState& rest, const CoarseShell& shell, const RestState& coarse, const Poses& poses);

}  // namespace strake
