#pragma once
#include "core/mesh/mesh.hpp"

/// Rotation of the surface at each vertex under a small displacement.
namespace strake {

/// Data for derivatives of a field on a triangulation.
struct TriangleArms {
    Triangles triangles;
    Points normals;        ///< m x 3, unit; zero where the area is
    Points arms;           ///< 3m x 3: (n x e_k) / 2 of corner k of triangle t in row 3t + k, e_k its opposite edge
    Eigen::VectorXd area;  ///< n: summed over the triangles of a vertex
    explicit TriangleArms(const TriMesh& mesh);
};

/// Rotation vectors (n x 3, radians) of a displacement (n x 3, length), linear in it, and the transpose of that map.
/// On a triangle with unit normal n and corners k with opposite edges e_k, the displacement's gradient is
/// sum_k u_k (n x e_k)^T / 2A, and the rotation vector that fits it
///   w = (I - n n^T / 2) sum_k (n x e_k) x u_k / 2A,
/// exact for u = w x r + t; a vertex has the area-weighted mean over its triangles, zero without area.
class LocalRotation {
public:
    explicit LocalRotation(const TriMesh& mesh) : arms_(mesh) {}
    Points apply(const Points& displacement) const;
    /// d(g . apply(u)) / du for g (n x 3).
    Points transpose(const Points& g) const;

private:
    TriangleArms arms_;
};

}  // namespace strake
