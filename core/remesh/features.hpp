#pragma once
#include "core/patches/features.hpp"
#include "core/remesh/base_surface.hpp"

/// Creases, boundaries, borders and rounded edges of the input. Internal to core/remesh.
namespace strake {

/// Fills features, feature_of, barrier, role and curves of `base`, which has points, triangles and normals.
/// A crease is an edge of dihedral >= `angle`. Where a chain of them would end, it goes on along edges of half of it
/// whose ends the quadric metric tensor calls nonsmooth. Features of separate parts that coincide are kept as they are.
/// @param angles corner_angles(mesh). @param frozen per triangle: it stays as it is; or empty.
void find_features(const TriMesh& mesh, const Adjacency& adjacent, const Points& angles, double angle,
                   const std::vector<char>& frozen, BaseSurface& base);

/// Edges along the middle of strips that are too narrow for edges of the wanted length and bend by 60 degrees or more:
/// blunt or rounded trailing edges. The triangles beside take over the normals of the flanks.
/// @param is_feature per half-edge. @return a half-edge of each.
std::vector<int> rounded_edges(const std::vector<char>& is_feature, double angle, BaseSurface& base);

}  // namespace strake
