#include "objectives/fit/target_shape.hpp"

#include "core/error.hpp"
#include "core/mesh/closest_point.hpp"
#include "core/mesh/geometry.hpp"
#include "objectives/quantity/finite.hpp"
#include "objectives/quantity/residuals.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <memory>

namespace strake {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Shares of the start's area; the residuals carry their roots.
Eigen::VectorXd weights(const std::string& name, const TriMesh& start) {
    const Eigen::VectorXd a = vertex_areas(start);
    const double total = surface_area(start);
    if (!(total > 0) || !std::isfinite(total))
        throw InvalidInput(text(name, ": the start surface has area ", total, ", must be > 0 and finite"));
    return a / total;
}

/// Derivative of v - q(v) by v, q the closest point on the face, edge or vertex in `at`.
Matrix3d leaves(const TriMesh& target, const ClosestPoint& at) {
    const auto corner = [&](int k) { return Vector3d(target.vertices.row(target.triangles(at.triangle, k))); };
    if (at.corner_a >= 0 && at.corner_b < 0) return Matrix3d::Identity();
    if (at.corner_a >= 0) {
        const Vector3d e = corner(at.corner_b) - corner(at.corner_a);
        const double length = e.stableNorm();
        if (!(length > 0)) return Matrix3d::Identity();  // an edge without length is a point
        return Matrix3d::Identity() - (e / length) * (e / length).transpose();
    }
    const Vector3d n = (corner(1) - corner(0)).cross(corner(2) - corner(0)).stableNormalized();
    return n * n.transpose();
}

void add_point(ResidualRows& rows, int k, double weight, const Vector3d& d, const Matrix3d& dd_dv) {
    const double root = std::sqrt(weight);
    rows.set_weight(k, weight);
    for (int c = 0; c < 3; ++c) {
        rows.set(3 * k + c, root * d[c]);
        rows.add(3 * k + c, k, root * dd_dv.row(c).transpose());
    }
}

}  // namespace

Quantity target_shape_same(const std::string& name, const TriMesh& start, const TriMesh& target) {
    if (start.num_vertices() != target.num_vertices() || start.num_triangles() != target.num_triangles())
        throw InvalidInput(text(name, ": the target has ", target.num_vertices(), " vertices and ",
                                target.num_triangles(), " triangles, the surface ", start.num_vertices(), " and ",
                                start.num_triangles(), "; match: closest takes any triangulation"));
    for (int t = 0; t < start.num_triangles(); ++t)
        if (start.triangles.row(t) != target.triangles.row(t))
            throw InvalidInput(text(name, ": triangle ", t, " of the target is ", target.triangles.row(t),
                                    ", of the surface ", start.triangles.row(t),
                                    "; match: closest takes any triangulation"));
    if (const auto failure = vertices_finite(name, target)) throw InvalidInput("target: " + failure->message);
    const Eigen::VectorXd weight = weights(name, start);
    return sum_of_squares(name, start.num_vertices(), start.num_triangles(),
                          [name, weight, wanted = target.vertices](const TriMesh& surface, const TriMesh&) {
                              ResidualRows rows(surface.num_vertices(), 3, surface.num_vertices());
                              for (int k = 0; k < surface.num_vertices(); ++k)
                                  add_point(rows, k, weight[k], surface.vertices.row(k) - wanted.row(k),
                                            Matrix3d::Identity());
                              return rows.finish(name + ": vertex");
                          });
}

Quantity target_shape_closest(const std::string& name, const TriMesh& start, const TriMesh& target) {
    if (target.num_triangles() == 0) throw InvalidInput(text(name, ": the target has no triangles"));
    if (const auto failure = vertices_finite(name, target)) throw InvalidInput("target: " + failure->message);
    const Eigen::VectorXd weight = weights(name, start);
    const auto shape = std::make_shared<const TriMesh>(target);
    const auto tree = std::make_shared<const ClosestPointTree>(target);
    return sum_of_squares(name, start.num_vertices(), start.num_triangles(),
                          [name, weight, shape, tree](const TriMesh& surface, const TriMesh& matched) {
                              ResidualRows rows(surface.num_vertices(), 3, surface.num_vertices());
                              const bool same = &surface == &matched;
                              for (int k = 0; k < surface.num_vertices(); ++k) {
                                  const Vector3d v = surface.vertices.row(k);
                                  const ClosestPoint closest = tree->find(matched.vertices.row(k));
                                  const Matrix3d left = leaves(*shape, closest);
                                  // A kept match is the plane of the face, the line of the edge or the vertex that was
                                  // closest.
                                  const Vector3d d =
                                      same ? Vector3d(v - closest.point) : Vector3d(left * (v - closest.point));
                                  add_point(rows, k, weight[k], d, left);
                              }
                              return rows.finish(name + ": vertex");
                          });
}

}  // namespace strake
