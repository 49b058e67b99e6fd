#pragma once
#include "core/mesh/adjacency.hpp"
#include "core/mesh/symmetry_plane.hpp"

#include <optional>
#include <string>

/// Whether a surface, maybe half a model, encloses something; and the whole of a half model.
namespace strake {

/// Triangles that run through edge e from its smaller to its larger vertex, minus those that run the other way.
/// Zero at every edge is what the divergence theorem needs, also where more than two triangles meet.
int edge_imbalance(const TriMesh& mesh, const Adjacency& adjacent, int e);

/// Per edge: a boundary edge with both ends within 1e-6 of the diagonal of the plane of symmetry, which closes there.
std::vector<char> plane_edges(const TriMesh& mesh, const Adjacency& adjacent,
                              const std::optional<SymmetryPlane>& symmetry);

/// Edges that keep the surface open, ascending: unbalanced ones but for those of the plane of symmetry.
std::vector<int> open_edges(const TriMesh& mesh, const Adjacency& adjacent,
                            const std::optional<SymmetryPlane>& symmetry);

/// @throws InvalidInput naming `name` and the first open edge with the remedy.
void require_closed(const std::string& name, const TriMesh& mesh, const std::optional<SymmetryPlane>& symmetry);

/// @throws InvalidInput naming `name` and the first edge whose two triangles disagree in orientation.
void require_oriented(const std::string& name, const TriMesh& mesh);

/// @param shown what the direction is of: "flow". @throws InvalidInput where a half model's plane is not along it.
void require_along(const std::string& name, const char* shown, const Eigen::Vector3d& direction,
                   const std::optional<SymmetryPlane>& symmetry);

/// Half a model and its mirror image behind it, vertices and triangles twice as many, oriented alike.
TriMesh whole_of(const TriMesh& half, const SymmetryPlane& symmetry);
/// What derivatives by the vertices of the whole (2n x 3) are by those of the half (n x 3).
Points folded(const Points& dJ_dv, const SymmetryPlane& symmetry);

}  // namespace strake
