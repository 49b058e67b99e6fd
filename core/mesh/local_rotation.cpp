#include "core/mesh/local_rotation.hpp"

#include "core/mesh/geometry.hpp"

#include <Eigen/Geometry>

namespace strake {
namespace {

using Eigen::RowVector3d;

RowVector3d without_half_normal(const RowVector3d& s, const RowVector3d& n) { return s - 0.5 * s.dot(n) * n; }

}  // namespace

TriangleArms::TriangleArms(const TriMesh& mesh)
    : triangles(mesh.triangles),
      normals(triangle_normals(mesh)),
      arms(3 * mesh.num_triangles(), 3),
      area(Eigen::VectorXd::Zero(mesh.num_vertices())) {
    const Eigen::VectorXd areas = triangle_areas(mesh);
    for (int t = 0; t < mesh.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k) {
            const RowVector3d edge =
                mesh.vertices.row(triangles(t, (k + 2) % 3)) - mesh.vertices.row(triangles(t, (k + 1) % 3));
            arms.row(3 * t + k) = 0.5 * normals.row(t).cross(edge);
            area[triangles(t, k)] += areas[t];
        }
}

Points LocalRotation::apply(const Points& displacement) const {
    Points w = Points::Zero(arms_.area.size(), 3);
    for (Eigen::Index t = 0; t < arms_.triangles.rows(); ++t) {
        RowVector3d s = RowVector3d::Zero();
        for (int k = 0; k < 3; ++k)
            s += RowVector3d(arms_.arms.row(3 * t + k)).cross(RowVector3d(displacement.row(arms_.triangles(t, k))));
        const RowVector3d turned = without_half_normal(s, arms_.normals.row(t));
        for (int k = 0; k < 3; ++k) w.row(arms_.triangles(t, k)) += turned;
    }
    for (Eigen::Index v = 0; v < w.rows(); ++v) w.row(v) /= arms_.area[v] > 0 ? arms_.area[v] : 1.0;
    return w;
}

Points LocalRotation::transpose(const Points& g) const {
    Points back = Points::Zero(arms_.area.size(), 3);
    for (Eigen::Index t = 0; t < arms_.triangles.rows(); ++t) {
        RowVector3d s = RowVector3d::Zero();
        for (int k = 0; k < 3; ++k)
            if (const int v = arms_.triangles(t, k); arms_.area[v] > 0) s += g.row(v) / arms_.area[v];
        const RowVector3d turned = without_half_normal(s, arms_.normals.row(t));
        for (int k = 0; k < 3; ++k)
            back.row(arms_.triangles(t, k)) += turned.cross(RowVector3d(arms_.arms.row(3 * t + k)));
    }
    return back;
}

}  // namespace strake
