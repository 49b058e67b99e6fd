#pragma once
#include "core/mesh/mesh.hpp"

#include <Eigen/SparseCore>
#include <vector>

namespace strake {

/// The cotangent matrix L of a surface (n x n, symmetric, positive semidefinite, no unit): u.L.u is the integral of
/// |grad u|^2 for values u of its vertices that are linear on triangles (Pinkall and Polthier 1993, eq. 5), and row v
/// of L u over the area of the vertex is the negative of the Laplacian there. Triangles without area have no part in
/// it.
Eigen::SparseMatrix<double> cotangent_matrix(const TriMesh& mesh);

/// Rows of it, one for each of these vertices: costs and needs no more than their triangles.
Eigen::SparseMatrix<double> cotangent_rows(const TriMesh& mesh, const std::vector<int>& vertices);

}  // namespace strake
