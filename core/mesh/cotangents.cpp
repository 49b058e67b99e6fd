#include "core/mesh/cotangents.hpp"

#include "core/mesh/geometry.hpp"

#include <array>
#include <numeric>

namespace strake {

Eigen::SparseMatrix<double> cotangent_matrix(const TriMesh& mesh) {
    std::vector<int> all(static_cast<std::size_t>(mesh.num_vertices()));
    std::iota(all.begin(), all.end(), 0);
    return cotangent_rows(mesh, all);
}

Eigen::SparseMatrix<double> cotangent_rows(const TriMesh& mesh, const std::vector<int>& vertices) {
    std::vector<int> row_of(static_cast<std::size_t>(mesh.num_vertices()), -1);
    for (std::size_t row = 0; row < vertices.size(); ++row) row_of[vertices[row]] = static_cast<int>(row);
    std::vector<Eigen::Triplet<double>> entries;
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        const auto corner = mesh.triangles.row(t);
        if (row_of[corner[0]] < 0 && row_of[corner[1]] < 0 && row_of[corner[2]] < 0) continue;
        const double area = area_vector(mesh, t).norm();
        if (!(area > 0)) continue;
        std::array<Eigen::Vector3d, 3> opposite;
        for (int k = 0; k < 3; ++k)
            opposite[k] = (mesh.vertices.row(corner[(k + 2) % 3]) - mesh.vertices.row(corner[(k + 1) % 3])).transpose();
        for (int k = 0; k < 3; ++k)
            for (int l = 0; l < 3; ++l)
                if (const int row = row_of[corner[k]]; row >= 0)
                    entries.emplace_back(row, corner[l], opposite[k].dot(opposite[l]) / (4 * area));
    }
    Eigen::SparseMatrix<double> L(static_cast<Eigen::Index>(vertices.size()), mesh.num_vertices());
    L.setFromTriplets(entries.begin(), entries.end());
    return L;
}

}  // namespace strake
