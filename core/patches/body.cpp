#include "core/patches/body.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>

namespace strake {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Integral of (x - centre)(x - centre)^T over the surface, exact: A/12 (sum d_i d_i^T + s s^T), s = sum d_i.
Matrix3d second_moments(const TriMesh& mesh, const Eigen::VectorXd& areas, const Vector3d& centre) {
    Matrix3d M = Matrix3d::Zero();
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        Vector3d s = Vector3d::Zero();
        Matrix3d local = Matrix3d::Zero();
        for (int k = 0; k < 3; ++k) {
            const Vector3d d = Vector3d(mesh.vertices.row(mesh.triangles(t, k))) - centre;
            local += d * d.transpose();
            s += d;
        }
        M += areas[t] / 12 * (local + s * s.transpose());
    }
    return M;
}

/// The direction normal to `axis` that is nearest to a coordinate axis.
Vector3d coordinate_like(const Vector3d& axis) {
    int j = 0;
    for (int i = 1; i < 3; ++i)
        if (std::abs(axis[i]) < std::abs(axis[j]) - 1e-6) j = i;
    const Vector3d e = Vector3d::Unit(j);
    return (e - e.dot(axis) * axis).normalized();
}

/// Orients an axis to the side where the surface extends farther (third moment), or along its largest coordinate for a
/// symmetric body. Only exact ties depend on it.
double side(const Body& body, const Vector3d& axis) {
    double skew = 0, size = 0;
    for (int t = 0; t < body.mesh().num_triangles(); ++t) {
        const double d = axis.dot(body.centroids.row(t).transpose() - body.centre);
        skew += body.features.areas[t] * d * d * d;
        size += body.features.areas[t] * std::abs(d * d * d);
    }
    if (std::abs(skew) > 1e-3 * size) return skew > 0 ? 1 : -1;
    int j = 0;
    for (int i = 1; i < 3; ++i)
        if (std::abs(axis[i]) > std::abs(axis[j]) + 1e-6) j = i;
    return axis[j] > 0 ? 1 : -1;
}

Matrix3d principal_axes(const Body& body) {
    const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(second_moments(body.mesh(), body.features.areas, body.centre));
    const Vector3d l = solver.eigenvalues().reverse();
    Matrix3d axes = solver.eigenvectors().rowwise().reverse();
    const bool tie01 = l[0] - l[1] < 0.02 * l[0], tie12 = l[1] - l[2] < 0.02 * l[1];
    if (tie01 && tie12) return Matrix3d::Identity();
    if (tie01) axes.col(0) = coordinate_like(axes.col(2)), axes.col(1) = axes.col(2).cross(axes.col(0));
    if (tie12) axes.col(1) = coordinate_like(axes.col(0)), axes.col(2) = axes.col(0).cross(axes.col(1));
    for (int j = 0; j < 3; ++j) axes.col(j) *= side(body, axes.col(j));
    return axes;
}

}  // namespace

Body measured(const SurfaceFeatures& features) {
    const TriMesh& mesh = features.mesh;
    Body body{features, triangle_normals(mesh), triangle_centroids(mesh), {}, features.areas.sum(), {}, {}};
    if (!(body.area > 0)) throw InvalidInput(text("segment_automatically: surface area = ", body.area, " must be > 0"));
    body.centre = (body.centroids.transpose() * features.areas) / body.area;
    for (const auto& [a, b] : features.adjacent.edges)
        body.edge_length.push_back((mesh.vertices.row(a) - mesh.vertices.row(b)).norm());
    body.axes = principal_axes(body);
    return body;
}

}  // namespace strake
