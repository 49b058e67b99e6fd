#pragma once
#include "core/mesh/local_rotation.hpp"

/// Gradient of a surface's displacement at each vertex.
namespace strake {

/// n x 9: the matrix du_i/dx_j of each vertex by rows.
using Gradients = Eigen::Matrix<double, Eigen::Dynamic, 9, Eigen::RowMajor>;

/// Gradients of a displacement (n x 3, length), linear in it, and the transpose of that map. On a triangle with unit
/// normal n and corners k with opposite edges e_k, a displacement is known only along the surface; normal to it, the
/// normal rotates with the surface (like a shell's):
///   G = sum_k [u_k g_k^T - g_k (n . u_k) n^T],   g_k = (n x e_k) / 2A,
/// exact for every u = Wx + t with W antisymmetric, and along the surface for every affine u. A vertex has the
/// area-weighted mean over its triangles, zero without area.
class LocalGradient {
public:
    explicit LocalGradient(const TriMesh& mesh) : arms_(mesh) {}
    Gradients apply(const Points& displacement) const;
    /// d(g : apply(u)) / du for g (n x 9).
    Points transpose(const Gradients& g) const;

private:
    TriangleArms arms_;
};

}  // namespace strake
