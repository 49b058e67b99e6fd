#include "core/mesh/geometry.hpp"

#include "core/error.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace strake {

Box bounding_box(const TriMesh& mesh) {
    if (mesh.num_triangles() == 0) return {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
    Box box{mesh.vertices.row(mesh.triangles(0, 0)), mesh.vertices.row(mesh.triangles(0, 0))};
    for (int t = 0; t < mesh.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k) {
            const Eigen::Vector3d p = mesh.vertices.row(mesh.triangles(t, k));
            box.min = box.min.cwiseMin(p);
            box.max = box.max.cwiseMax(p);
        }
    return box;
}

std::vector<char> used_vertices(const TriMesh& mesh) {
    std::vector<char> used(static_cast<std::size_t>(mesh.num_vertices()), 0);
    for (int t = 0; t < mesh.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k) used[static_cast<std::size_t>(mesh.triangles(t, k))] = 1;
    return used;
}

double box_diagonal(const TriMesh& mesh) {
    const Box box = bounding_box(mesh);
    return (box.max - box.min).norm();
}

Eigen::Vector3d area_vector(const TriMesh& mesh, int t) {
    const Eigen::Vector3d a = mesh.vertices.row(mesh.triangles(t, 0)), b = mesh.vertices.row(mesh.triangles(t, 1)),
                          c = mesh.vertices.row(mesh.triangles(t, 2));
    return 0.5 * (b - a).cross(c - a);
}

Points triangle_normals(const TriMesh& mesh) {
    Points normals(mesh.num_triangles(), 3);
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        const Eigen::Vector3d s = area_vector(mesh, t);
        const double length = s.stableNorm();
        normals.row(t) = length > 0 ? Eigen::Vector3d(s / length) : Eigen::Vector3d::Zero();
    }
    return normals;
}

Eigen::VectorXd triangle_areas(const TriMesh& mesh) {
    Eigen::VectorXd areas(mesh.num_triangles());
    for (int t = 0; t < mesh.num_triangles(); ++t) areas[t] = area_vector(mesh, t).stableNorm();
    return areas;
}

Points triangle_centroids(const TriMesh& mesh) {
    Points centroids(mesh.num_triangles(), 3);
    for (int t = 0; t < mesh.num_triangles(); ++t)
        centroids.row(t) = (mesh.vertices.row(mesh.triangles(t, 0)) + mesh.vertices.row(mesh.triangles(t, 1)) +
                            mesh.vertices.row(mesh.triangles(t, 2))) /
                           3.0;
    return centroids;
}

Points corner_angles(const TriMesh& mesh) {
    Points angles(mesh.num_triangles(), 3);
    for (int t = 0; t < mesh.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k) {
            const Eigen::Vector3d p = mesh.vertices.row(mesh.triangles(t, k));
            const Eigen::Vector3d u = Eigen::Vector3d(mesh.vertices.row(mesh.triangles(t, (k + 1) % 3))) - p;
            const Eigen::Vector3d v = Eigen::Vector3d(mesh.vertices.row(mesh.triangles(t, (k + 2) % 3))) - p;
            angles(t, k) = std::atan2(u.cross(v).stableNorm(), u.dot(v));
        }
    return angles;
}

double dihedral(const Eigen::Vector3d& n1, const Eigen::Vector3d& n2) {
    return std::atan2(n1.cross(n2).norm(), n1.dot(n2));
}

Eigen::VectorXd vertex_areas(const TriMesh& mesh) {
    Eigen::VectorXd areas = Eigen::VectorXd::Zero(mesh.num_vertices());
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        const double third = area_vector(mesh, t).stableNorm() / 3;
        for (int k = 0; k < 3; ++k) areas[mesh.triangles(t, k)] += third;
    }
    return areas;
}

double surface_area(const TriMesh& mesh) {
    double area = 0;
    for (int t = 0; t < mesh.num_triangles(); ++t) area += area_vector(mesh, t).stableNorm();
    return area;
}

double enclosed_volume(const TriMesh& mesh) {
    const Box box = bounding_box(mesh);
    const Eigen::Vector3d o = 0.5 * (box.min + box.max);
    double volume = 0;
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        const Eigen::Vector3d a = Eigen::Vector3d(mesh.vertices.row(mesh.triangles(t, 0))) - o,
                              b = Eigen::Vector3d(mesh.vertices.row(mesh.triangles(t, 1))) - o,
                              c = Eigen::Vector3d(mesh.vertices.row(mesh.triangles(t, 2))) - o;
        volume += a.dot(b.cross(c)) / 6;
    }
    return volume;
}

Eigen::Vector3d area_centroid(const TriMesh& mesh, const std::vector<int>& triangles) {
    Eigen::Vector3d moment = Eigen::Vector3d::Zero();
    double area = 0;
    for (const int t : triangles) {
        const double a = area_vector(mesh, t).stableNorm();
        moment += a / 3 *
                  (mesh.vertices.row(mesh.triangles(t, 0)) + mesh.vertices.row(mesh.triangles(t, 1)) +
                   mesh.vertices.row(mesh.triangles(t, 2)))
                      .transpose();
        area += a;
    }
    if (!(area > 0)) throw InvalidInput(text("area_centroid: ", triangles.size(), " triangles of total area 0"));
    return moment / area;
}

}  // namespace strake
