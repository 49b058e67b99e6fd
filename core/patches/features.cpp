#include "core/patches/features.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace strake {
namespace {

using std::numbers::pi;

/// 2 atan sqrt(part / whole) in [0, pi/2]; round-off may leave a part slightly below zero.
double crease_angle(double part, double whole) {
    return whole > 0 ? 2 * std::atan(std::sqrt(std::max(part, 0.0) / whole)) : 0.0;
}

std::vector<char> on_open_boundary(const TriMesh& mesh, const Adjacency& adjacent) {
    std::vector<char> open(mesh.num_vertices(), 0);
    for (int e = 0; e < adjacent.num_edges(); ++e)
        if (adjacent.edge_triangles[e].size() == 1)
            for (const int v : adjacent.edges[e]) open[v] = 1;
    return open;
}

/// Upper bound of the second eigenvalue's share of the largest: that is at least A's value along n.
double largest_ratio(const Eigen::Matrix3d& A, const Eigen::Vector3d& n) {
    const double along = n.dot(A * n) / n.squaredNorm();
    return std::max(A.trace() - along, 0.0) / along;
}

VertexFeature feature_of(const Eigen::Matrix3d& A, const Eigen::Vector3d& normal_sum, double weight, bool open,
                         double smooth_ratio) {
    VertexFeature feature;
    feature.angle_defect = std::abs((open ? pi : 2 * pi) - weight);
    if (!(weight > 0)) return feature;
    feature.mean_normal_squared = (normal_sum / weight).squaredNorm();
    if (smooth_ratio > 0 && feature.mean_normal_squared >= 0.5) {
        feature.eigenvalue_ratio = largest_ratio(A, normal_sum);
        if (feature.eigenvalue_ratio < smooth_ratio) return feature;
    }
    const Eigen::Vector3d l = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(A, Eigen::EigenvaluesOnly).eigenvalues();
    feature.eigenvalue_ratio = l[2] > 0 ? std::clamp(l[1] / l[2], 0.0, 1.0) : 0.0;
    const double t = crease_angle(l[1], l[2]);
    feature.theta = feature.mean_normal_squared >= 0.5 ? t : pi - t;
    feature.psi = crease_angle(l[0], l[2]);
    return feature;
}

}  // namespace

std::vector<VertexFeature> quadric_metric_tensor(const TriMesh& mesh, const Adjacency& adjacent) {
    return quadric_metric_tensor(mesh, adjacent, triangle_normals(mesh), corner_angles(mesh));
}

std::vector<VertexFeature> quadric_metric_tensor(const TriMesh& mesh, const Adjacency& adjacent, const Points& normals,
                                                 const Points& angles, double smooth_below) {
    const double smooth_ratio = smooth_below > 0 ? 0.9 * std::pow(std::tan(0.5 * smooth_below), 2) : 0;
    const std::vector<char> open = on_open_boundary(mesh, adjacent);
    std::vector<VertexFeature> features(mesh.num_vertices());
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
        Eigen::Vector3d normal_sum = Eigen::Vector3d::Zero();
        double weight = 0;
        for (const int t : adjacent.vertex_triangles[v]) {
            const Eigen::Vector3d n = normals.row(t);
            if (n.isZero(0)) continue;
            for (int k = 0; k < 3; ++k) {
                if (mesh.triangles(t, k) != v) continue;
                A += angles(t, k) * n * n.transpose();
                normal_sum += angles(t, k) * n;
                weight += angles(t, k);
            }
        }
        features[v] = feature_of(A, normal_sum, weight, open[v], smooth_ratio);
    }
    return features;
}

bool is_nonsmooth(const VertexFeature& feature, double tau) {
    return feature.mean_normal_squared < 0.5 || 2 * std::atan(std::sqrt(feature.eigenvalue_ratio)) >= tau - angle_slack;
}

VertexClass classify(const VertexFeature& feature, double tau) {
    if (!(tau > 0 && tau <= pi / 2 + angle_slack))
        throw InvalidInput(text("classify: tau = ", tau, " rad must be in (0, pi/2]"));
    if (!is_nonsmooth(feature, tau)) return VertexClass::smooth;
    const bool corner =
        feature.psi >= std::max(tau, pi / 4) - angle_slack || feature.angle_defect >= pi / 3 - angle_slack;
    return corner ? VertexClass::corner : VertexClass::ridge;
}

}  // namespace strake
