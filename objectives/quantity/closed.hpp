#pragma once
#include "core/mesh/adjacency.hpp"
#include "core/mesh/symmetry_plane.hpp"

#include <array>
#include <optional>
#include <string>
#include <vector>

/// Whether a surface or half model is closed, and the whole body of a half model.
namespace strake {

/// Number of triangles that traverse edge e from its smaller to its larger vertex, minus those in the opposite sense.
/// The divergence theorem needs zero at every edge, also where more than two triangles meet.
int edge_imbalance(const TriMesh& mesh, const Adjacency& adjacent, int e);

/// Per edge: a boundary edge closed by the plane of symmetry (both ends within 1e-6 diagonals of it).
std::vector<char> plane_edges(const TriMesh& mesh, const Adjacency& adjacent,
                              const std::optional<SymmetryPlane>& symmetry);

/// Open edges, ascending: unbalanced ones that the plane of symmetry does not close.
std::vector<int> open_edges(const TriMesh& mesh, const Adjacency& adjacent,
                            const std::optional<SymmetryPlane>& symmetry);

/// "edge from vertex 3 (0, 0, 1) to vertex 4 (0, 1, 1)".
std::string edge_between(const TriMesh& mesh, const std::array<int, 2>& edge);

/// What to do about `open` edges. The most likely cause is a half model: where one side of the bounding box holds most
/// of them, the line `symmetry: {plane: y, at: 0}` that its case lacks, and the first edge elsewhere.
std::string open_remedy(const TriMesh& mesh, const Adjacency& adjacent, const std::vector<int>& open);

/// @throws InvalidInput naming `name` and the first open edge with the remedy.
void require_closed(const std::string& name, const TriMesh& mesh, const std::optional<SymmetryPlane>& symmetry);

/// @throws InvalidInput naming `name` and the first edge whose two triangles disagree in orientation.
void require_oriented(const std::string& name, const TriMesh& mesh);

/// @param shown what has that direction, for messages: "flow". @throws InvalidInput where the direction crosses the
/// plane of symmetry.
void require_along(const std::string& name, const char* shown, const Eigen::Vector3d& direction,
                   const std::optional<SymmetryPlane>& symmetry);

/// A half model followed by its mirror image, in consistent orientation: twice the vertices and triangles.
TriMesh whole_of(const TriMesh& half, const SymmetryPlane& symmetry);
/// Derivatives by the vertices of the half (n x 3) from those of the whole (2n x 3).
Points folded(const Points& dJ_dv, const SymmetryPlane& symmetry);

}  // namespace strake
