#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

/// The surface as a value: vertices and triangles, in the order of the file they came from.
namespace strake {

using Points = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;  ///< n x 3
using Triangles = Eigen::Matrix<int, Eigen::Dynamic, 3, Eigen::RowMajor>;  ///< m x 3, 0-based vertex indices

/// A triangulated surface. Plain data, unchecked; readers return only finite vertices and indices in range.
struct TriMesh {
    Points vertices;
    Triangles triangles;
    std::vector<int> group;                ///< per triangle, index into group_names; empty: the file names no parts
    std::vector<std::string> group_names;  ///< STL solids, OBJ groups, Cart3D component ids as text

    int num_vertices() const { return static_cast<int>(vertices.rows()); }
    int num_triangles() const { return static_cast<int>(triangles.rows()); }
};

/// The same triangles on other vertices (n x 3, same count).
TriMesh with_vertices(const TriMesh& mesh, const Points& vertices);

}  // namespace strake
