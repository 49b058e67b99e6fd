#include "objectives/target_shape.hpp"

#include "core/error.hpp"
#include "core/mesh/closest_point.hpp"
#include "core/mesh/geometry.hpp"
#include "objectives/finite.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <memory>

namespace strake {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Eigen::VectorXd root_weights(const std::string& name, const TriMesh& start) {
    const Eigen::VectorXd a = vertex_areas(start);
    const double total = surface_area(start);
    if (!(total > 0) || !std::isfinite(total))
        throw InvalidInput(text(name, ": the start surface has area ", total, ", must be > 0 and finite"));
    return (a / total).cwiseSqrt();
}

using Residuals = std::function<PointResiduals(const TriMesh&)>;

/// J = sum |r_k|^2 and dJ/dv_k = 2 r_k^T dr_k/dv_k, from the same residuals that a fit sees.
Quantity sum_of_squares(const std::string& name, const TriMesh& start, const Residuals& residuals) {
    Quantity quantity;
    quantity.names = {name};
    const int nv = start.num_vertices(), nt = start.num_triangles();
    quantity.residuals = [name, nv, nt, residuals](const TriMesh& surface) {
        require_same_counts(name, surface, nv, nt);
        if (const auto failure = vertices_finite(name, surface)) throw InvalidInput(failure->message);
        return residuals(surface);
    };
    quantity.evaluate = [name, nv, nt, residuals](const QuantityRequest& request) {
        require_same_counts(name, request.surface, nv, nt);
        if (auto failure = vertices_finite(name, request.surface)) return QuantityResult{{}, {}, failure};
        const PointResiduals at = residuals(request.surface);
        double J = 0;
        for (int k = 0; k < nv; ++k) J += at.r.row(k).squaredNorm();
        Points dJ_dv;
        if (request.want_sensitivities) {
            dJ_dv.resize(nv, 3);
            for (int k = 0; k < nv; ++k) dJ_dv.row(k) = 2 * at.r.row(k) * at.dr_dv[k];
        }
        return one_value(name, J, std::move(dJ_dv));
    };
    return quantity;
}

/// Derivative of v - q(v), q the closest point on the face, edge or vertex that `at` names.
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
    const Eigen::VectorXd root = root_weights(name, start);
    return sum_of_squares(name, start, [root, wanted = target.vertices](const TriMesh& surface) {
        PointResiduals at;
        at.r = root.asDiagonal() * (surface.vertices - wanted);
        for (int k = 0; k < root.size(); ++k) at.dr_dv.push_back(root[k] * Matrix3d::Identity());
        return at;
    });
}

Quantity target_shape_closest(const std::string& name, const TriMesh& start, const TriMesh& target) {
    if (target.num_triangles() == 0) throw InvalidInput(text(name, ": the target has no triangles"));
    if (const auto failure = vertices_finite(name, target)) throw InvalidInput("target: " + failure->message);
    const Eigen::VectorXd root = root_weights(name, start);
    const auto shape = std::make_shared<const TriMesh>(target);
    const auto tree = std::make_shared<const ClosestPointTree>(target);
    return sum_of_squares(name, start, [root, shape, tree](const TriMesh& surface) {
        PointResiduals at;
        at.r.resize(root.size(), 3);
        at.dr_dv.reserve(root.size());
        for (int k = 0; k < root.size(); ++k) {
            const Vector3d v = surface.vertices.row(k);
            const ClosestPoint closest = tree->find(v);
            at.r.row(k) = root[k] * (v - closest.point);
            at.dr_dv.push_back(root[k] * leaves(*shape, closest));
        }
        return at;
    });
}

}  // namespace strake
