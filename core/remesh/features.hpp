#pragma once
#include "core/patches/features.hpp"
#include "core/remesh/base_surface.hpp"

/// Creases, boundaries, borders and rounded edges of the input. Internal to core/remesh.
namespace strake {

/// Fills features, feature_of, barrier, role and curves of `base`, which has points, triangles and normals.
/// A crease is an edge of dihedral >= `angle`. Where a chain of creases would end, it continues along edges of at least
/// half that angle with nonsmooth ends (quadric metric tensor). Coinciding features of separate parts are kept
/// unchanged.
/// @param angles corner_angles(mesh). @param frozen per triangle: it stays unchanged; empty: none
void find_features(const TriMesh& mesh, const Adjacency& adjacent, const Points& angles, double angle,
                   const std::vector<char>& frozen, BaseSurface& base);

/// Edges along the middle of strips that are too narrow for the target edge length and bend by 60 degrees or more:
/// blunt or rounded trailing edges. The adjacent triangles take the normals of the flanks.
/// @param is_feature per half-edge. @return a half-edge of each.
std::vector<int> rounded_edges(const std::vector<char>& is_feature, double angle, BaseSurface& base);

}  // namespace strake
