#include "core/mesh/point_triangle.hpp"

#include <Eigen/Geometry>

#include <array>

namespace strake {
namespace {

using Eigen::Vector3d;

Vector3d vertex(const TriMesh& mesh, int v) { return mesh.vertices.row(v); }

/// The point of the edge from corner k to the next that is closest to x.
ClosestPoint on_edge(const TriMesh& mesh, int t, int k, const Vector3d& x) {
    std::array<int, 2> corner{k, (k + 1) % 3};
    if (mesh.triangles(t, corner[0]) > mesh.triangles(t, corner[1])) std::swap(corner[0], corner[1]);
    const Vector3d u = vertex(mesh, mesh.triangles(t, corner[0])), v = vertex(mesh, mesh.triangles(t, corner[1]));
    const Vector3d e = v - u;
    const double along = e.dot(x - u), length2 = e.squaredNorm();
    ClosestPoint best;
    best.triangle = t;
    if (!(along > 0)) {
        best.point = u;
        best.corner_a = corner[0];
    } else if (along >= length2) {
        best.point = v;
        best.corner_a = corner[1];
    } else {
        best.point = u + along / length2 * e;
        best.corner_a = std::min(corner[0], corner[1]);
        best.corner_b = std::max(corner[0], corner[1]);
    }
    best.distance = (x - best.point).norm();
    return best;
}

}  // namespace

ClosestPoint closest_point_on_triangle(const TriMesh& mesh, int t, const Vector3d& x) {
    ClosestPoint best = on_edge(mesh, t, 0, x);
    for (int k = 1; k < 3; ++k) {
        const ClosestPoint other = on_edge(mesh, t, k, x);
        if (other.distance < best.distance) best = other;
    }
    const Vector3d a = vertex(mesh, mesh.triangles(t, 0)), b = vertex(mesh, mesh.triangles(t, 1)),
                   c = vertex(mesh, mesh.triangles(t, 2));
    const Vector3d n = (b - a).cross(c - a);
    const double n2 = n.squaredNorm();
    const double wa = n.dot((c - b).cross(x - b)), wb = n.dot((a - c).cross(x - c)), wc = n.dot((b - a).cross(x - a));
    if (!(n2 > 0 && wa > 0 && wb > 0 && wc > 0)) return best;
    // By weights, not by projection along n, which keeps the point in the triangle even if n is inaccurate.
    ClosestPoint inside;
    inside.point = a + wb / n2 * (b - a) + wc / n2 * (c - a);
    inside.triangle = t;
    inside.distance = (x - inside.point).norm();
    return inside.distance < best.distance ? inside : best;
}

}  // namespace strake
