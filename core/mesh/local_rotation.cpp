#include "core/mesh/local_rotation.hpp"

#include "core/mesh/geometry.hpp"

#include <Eigen/Geometry>

namespace strake {
namespace {

using Eigen::RowVector3d;

RowVector3d without_half_normal(const RowVector3d& s, const RowVector3d& n) { return s - 0.5 * s.dot(n) * n; }

}  // namespace

LocalRotation::LocalRotation(const TriMesh& mesh)
    : triangles_(mesh.triangles),
      normals_(triangle_normals(mesh)),
      arms_(3 * mesh.num_triangles(), 3),
      area_(Eigen::VectorXd::Zero(mesh.num_vertices())) {
    const Eigen::VectorXd areas = triangle_areas(mesh);
    for (int t = 0; t < mesh.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k) {
            const RowVector3d edge =
                mesh.vertices.row(triangles_(t, (k + 2) % 3)) - mesh.vertices.row(triangles_(t, (k + 1) % 3));
            arms_.row(3 * t + k) = 0.5 * normals_.row(t).cross(edge);
            area_[triangles_(t, k)] += areas[t];
        }
}

Points LocalRotation::apply(const Points& displacement) const {
    Points w = Points::Zero(area_.size(), 3);
    for (Eigen::Index t = 0; t < triangles_.rows(); ++t) {
        RowVector3d s = RowVector3d::Zero();
        for (int k = 0; k < 3; ++k)
            s += RowVector3d(arms_.row(3 * t + k)).cross(RowVector3d(displacement.row(triangles_(t, k))));
        const RowVector3d turned = without_half_normal(s, normals_.row(t));
        for (int k = 0; k < 3; ++k) w.row(triangles_(t, k)) += turned;
    }
    for (Eigen::Index v = 0; v < w.rows(); ++v) w.row(v) /= area_[v] > 0 ? area_[v] : 1.0;
    return w;
}

Points LocalRotation::transpose(const Points& g) const {
    Points back = Points::Zero(area_.size(), 3);
    for (Eigen::Index t = 0; t < triangles_.rows(); ++t) {
        RowVector3d s = RowVector3d::Zero();
        for (int k = 0; k < 3; ++k)
            if (const int v = triangles_(t, k); area_[v] > 0) s += g.row(v) / area_[v];
        const RowVector3d turned = without_half_normal(s, normals_.row(t));
        for (int k = 0; k < 3; ++k) back.row(triangles_(t, k)) += turned.cross(RowVector3d(arms_.row(3 * t + k)));
    }
    return back;
}

}  // namespace strake
