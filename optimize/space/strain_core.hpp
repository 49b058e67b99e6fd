#pragma once
#include "core/mesh/adjacency.hpp"
#include "core/patches/hierarchy.hpp"

/// Which triangles of a patch a strain variable pins, while the shell between the cores stays free to bend.
namespace strake {

/// Triangles of each patch that are farther than `share` of the patch's inradius from its border, ascending; none
/// for patches without a free triangle. Distances run along the surface, from triangle centre to triangle centre. The
/// border is where another patch or a pinned triangle begins, and every open edge if `open_edges_count` (half models,
/// whose pinned cores must keep off the symmetry plane). The inradius is the largest distance within the patch.
/// @param pin ShellOptions::pin; triangles that are pinned already are in no core.
std::vector<std::vector<int>> strain_cores(const TriMesh& mesh, const Adjacency& adjacent, const PatchLevel& level,
                                           const std::vector<int>& pin, bool open_edges_count, double share = 0.4);

}  // namespace strake
