#pragma once
#include "core/mesh/adjacency.hpp"

#include <vector>

/// Smooth, ridge or corner: the quadric metric tensor (Berkenstock & Aftosmis 2008, III.A, Eq. 14).
namespace strake {

enum class VertexClass { smooth, ridge, corner };

/// Every comparison of an angle with a threshold is `angle >= threshold - angle_slack`.
inline constexpr double angle_slack = 1e-9;

/// The tensor A = sum w_i n_i n_i^T at one vertex; w_i the corner angles. Independent of thresholds: evaluated once per
/// surface.
struct VertexFeature {
    double eigenvalue_ratio = 0;     ///< l2 / l1 in [0, 1]
    double mean_normal_squared = 1;  ///< |mu|^2, mu = sum w_i n_i / sum w_i
    double theta = 0;                ///< effective crease angle, radians; the dihedral on a straight crease
    double psi = 0;                  ///< 2 atan sqrt(l3 / l1), radians
    double angle_defect = 0;         ///< |2 pi - sum w_i| (pi at an open boundary), radians
};

/// One feature per vertex. Triangles of zero area carry no weight; a vertex without any weight is smooth.
std::vector<VertexFeature> quadric_metric_tensor(const TriMesh& mesh, const Adjacency& adjacent);
/// The same with better normals than those of the triangles. @param normals unit or zero, one per triangle
/// @param angles corner_angles(mesh)
/// @param smooth_below > 0: vertices certainly smooth at thresholds of at least this, radians, get an upper bound as
/// eigenvalue_ratio and no angles; faster.
std::vector<VertexFeature> quadric_metric_tensor(const TriMesh& mesh, const Adjacency& adjacent, const Points& normals,
                                                 const Points& angles, double smooth_below = 0);

/// Ridge or corner at threshold tau: 2 atan sqrt(l2 / l1) >= tau (the paper's test), or |mu|^2 < 1/2 (acute creases,
/// where the two large eigenvalues have swapped). @param tau radians, in (0, pi/2], not checked.
bool is_nonsmooth(const VertexFeature& feature, double tau);

/// @param tau threshold in radians, 0 < tau <= pi/2 @throws InvalidInput otherwise.
VertexClass classify(const VertexFeature& feature, double tau);

}  // namespace strake
