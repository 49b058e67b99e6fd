#pragma once
#include "core/primo/aggregation.hpp"
#include "core/primo/rest_state.hpp"

/// A shell of fewer prisms, for a first approach to a large deformation (nested iteration): clusters of free prisms
/// stand still within themselves and move as rigid prisms of their own, coupled by the faces between them. A face
/// stands for as much of the skin as lies between the centres of its two prisms, and is as much softer as that is more.
namespace strake {

struct CoarseShell {
    RestState rest;       ///< vertices, loads and pinned regions as in the finer one; no attached parts
    std::vector<int> of;  ///< per finer prism: its coarse one
    Graph neighbours;     ///< free prisms of the finer shell that share a face
};

/// Clusters of about four (`radius` 1) or ten (2) free prisms; one for each pinned region.
CoarseShell coarsen(const RestState& rest, int radius);

/// Poses of the finer prisms that move with their coarse ones; smoothed, so that neighbours of different clusters
/// hardly gape. Pinned ones get those of their region.
/// @param shell as `coarsen` made it; its `rest`, which may have been moved elsewhere, is `coarse`
/// @param poses of the coarse prisms
Poses prolonged(const RestState& rest, const CoarseShell& shell, const RestState& coarse, const Poses& poses);

}  // namespace strake
