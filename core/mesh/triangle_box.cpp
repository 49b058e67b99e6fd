#include "core/mesh/triangle_box.hpp"

namespace strake {

Box triangle_box(const TriMesh& mesh, const std::vector<int>& triangles) {
    Box box{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
    if (!triangles.empty()) box.min = box.max = mesh.vertices.row(mesh.triangles(triangles.front(), 0));
    for (const int t : triangles)
        for (const int v : mesh.triangles.row(t)) {
            box.min = box.min.cwiseMin(mesh.vertices.row(v).transpose());
            box.max = box.max.cwiseMax(mesh.vertices.row(v).transpose());
        }
    return box;
}

}  // namespace strake
