#include "objectives/geometry/clearance.hpp"

#include "core/error.hpp"
#include "core/mesh/closest_point.hpp"
#include "core/mesh/geometry.hpp"
#include "objectives/geometry/extent.hpp"
#include "objectives/quantity/closed.hpp"
#include "objectives/quantity/finite.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <map>

namespace strake {
namespace {

using Eigen::Vector3d;

/// Signed distance to a closed surface, positive outside. The normal of the closest face, edge or vertex gives the side
/// (angle-weighted at edges and vertices).
class DistanceToOther {
public:
    explicit DistanceToOther(const TriMesh& mesh) : mesh_(mesh), tree_(mesh) {
        face_ = triangle_normals(mesh);
        vertex_ = Points::Zero(mesh.num_vertices(), 3);
        const Points angles = corner_angles(mesh);
        for (int t = 0; t < mesh.num_triangles(); ++t)
            for (int k = 0; k < 3; ++k) {
                const int v = mesh.triangles(t, k), w = mesh.triangles(t, (k + 1) % 3);
                vertex_.row(v) += angles(t, k) * face_.row(t);
                const auto edge = edge_.try_emplace({std::min(v, w), std::max(v, w)}, Vector3d::Zero()).first;
                edge->second += face_.row(t);
            }
    }
    /// @param towards set to the direction of growing distance.
    double at(const Vector3d& x, Vector3d& towards) const {
        const ClosestPoint p = tree_.find(x);
        const auto corners = mesh_.triangles.row(p.triangle);
        Vector3d n = face_.row(p.triangle);
        if (p.corner_a >= 0 && p.corner_b >= 0) {
            const int v = corners[p.corner_a], w = corners[p.corner_b];
            n = edge_.at({std::min(v, w), std::max(v, w)});
        } else if (p.corner_a >= 0)
            n = vertex_.row(corners[p.corner_a]);
        const Vector3d off = x - p.point;
        const double sign = off.dot(n) < 0 ? -1 : 1;
        towards = p.distance > 0 ? Vector3d(sign / p.distance * off) : n.normalized();
        return sign * p.distance;
    }

private:
    TriMesh mesh_;
    ClosestPointTree tree_;
    Points face_, vertex_;
    std::map<std::pair<int, int>, Vector3d> edge_;
};

std::vector<int> vertices_of(const std::string& name, const TriMesh& start, const std::vector<char>& region) {
    if (!region.empty() && static_cast<int>(region.size()) != start.num_triangles())
        throw InvalidInput(text(name, ": ", region.size(), " marks for ", start.num_triangles(), " triangles"));
    std::vector<char> is_in(start.num_vertices(), 0);
    for (int t = 0; t < start.num_triangles(); ++t)
        if (region.empty() || region[t])
            for (int k = 0; k < 3; ++k) is_in[start.triangles(t, k)] = 1;
    std::vector<int> vertices;
    for (int v = 0; v < start.num_vertices(); ++v)
        if (is_in[v]) vertices.push_back(v);
    if (vertices.empty()) throw InvalidInput(text(name, ": the region has no vertices"));
    return vertices;
}

}  // namespace

Quantity clearance(const std::string& name, const TriMesh& start, const TriMesh& other, const Clearance& what) {
    if (!(what.smoothing >= 0) || !std::isfinite(what.smoothing))
        throw InvalidInput(text(name, ": smoothing = ", what.smoothing, " must be >= 0 and finite"));
    require_closed(name + ": " + what.shown, other, {});
    const double volume = enclosed_volume(other), d = box_diagonal(other);
    if (!(std::abs(volume) > 1e-12 * d * d * d))
        throw InvalidInput(text(name, ": ", what.shown, " encloses no volume"));
    const double side = (what.side == Side::keep_out ? 1 : -1) * (volume > 0 ? 1 : -1);
    const std::vector<int> vertices = vertices_of(name, start, what.region);
    const auto distance = std::make_shared<const DistanceToOther>(other);
    return checked_quantity(name, {name}, start, [=](const QuantityRequest& request) {
        const Points& v = request.surface.vertices;
        const auto count = static_cast<Eigen::Index>(vertices.size());
        Eigen::VectorXd nearness(count), weight;
        Points towards(count, 3);
        for (Eigen::Index i = 0; i < count; ++i) {
            Vector3d n;
            nearness[i] = -side * distance->at(v.row(vertices[static_cast<std::size_t>(i)]), n);
            towards.row(i) = side * n;
        }
        Eigen::Index deepest = 0;
        const double depth = nearness.maxCoeff(&deepest);
        const double least = -smooth_max(nearness, what.smoothing, request.wants(0) ? &weight : nullptr);
        Points dJ_dv;
        if (request.wants(0)) {
            dJ_dv = Points::Zero(v.rows(), 3);
            for (Eigen::Index i = 0; i < count; ++i)
                dJ_dv.row(vertices[static_cast<std::size_t>(i)]) += weight[i] * towards.row(i);
        }
        QuantityResult result = one_value(least, std::move(dJ_dv));
        const int at = vertices[static_cast<std::size_t>(deepest)];
        if (depth > 0)
            result.remarks.push_back(text(name, ": vertex ", at, " (", v(at, 0), ", ", v(at, 1), ", ", v(at, 2),
                                          ") is ", depth, what.side == Side::keep_out ? " inside " : " outside ",
                                          what.shown));
        return result;
    });
}

}  // namespace strake
