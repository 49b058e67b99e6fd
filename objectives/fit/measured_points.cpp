#include "objectives/fit/measured_points.hpp"

#include "core/error.hpp"
#include "core/mesh/adjacency.hpp"
#include "core/mesh/closest_point.hpp"
#include "core/mesh/geometry.hpp"
#include "core/text/number_table.hpp"
#include "objectives/quantity/residuals.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <memory>

namespace strake {
namespace {

using Eigen::Vector3d;

/// Distance to the plane of a face, the line of an edge or a vertex, and its derivatives by the triangle's corners.
struct SignedDistance {
    double d = 0;
    std::array<Vector3d, 3> dd_dv{Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero()};
};

class Distances {
public:
    Distances(const TriMesh& surface, const IntLists& vertex_triangles)
        : surface_(surface), vertex_triangles_(vertex_triangles) {}

    SignedDistance of(const Vector3d& p, const ClosestPoint& match) const {
        if (match.corner_a >= 0) return to_edge_or_vertex(p, match);
        const int t = match.triangle;
        const Vector3d a = corner(t, 0), b = corner(t, 1), c = corner(t, 2), n = (b - a).cross(c - a);
        const double twice_area = n.stableNorm();
        const Vector3d unit = n / twice_area;
        SignedDistance result;
        result.d = unit.dot(p - a);
        // Barycentric coordinates of the foot; the foot of a kept match may lie outside the triangle.
        const double second = unit.dot((p - a).cross(c - a)) / twice_area,
                     third = unit.dot((b - a).cross(p - a)) / twice_area;
        result.dd_dv = {-(1 - second - third) * unit, -second * unit, -third * unit};
        return result;
    }

private:
    Vector3d corner(int t, int k) const { return surface_.vertices.row(surface_.triangles(t, k)); }

    SignedDistance to_edge_or_vertex(const Vector3d& p, const ClosestPoint& match) const {
        const int t = match.triangle;
        const Vector3d a = corner(t, match.corner_a);
        Vector3d foot = a;
        double share = 0;
        if (match.corner_b >= 0) {
            const Vector3d e = corner(t, match.corner_b) - a;
            const double square = e.squaredNorm();
            if (square > 0) share = e.dot(p - a) / square;
            foot += share * e;
        }
        const Vector3d outward = normal_at(t, match);
        const double distance = (p - foot).stableNorm();
        const double sign = outward.dot(p - foot) < 0 ? -1 : 1;
        // On the surface the direction is the normal: the limit from its side.
        const Vector3d u = distance > 0 ? Vector3d(sign / distance * (p - foot)) : outward;
        SignedDistance result;
        result.d = sign * distance;
        result.dd_dv[match.corner_a] = -(1 - share) * u;
        if (match.corner_b >= 0) result.dd_dv[match.corner_b] = -share * u;
        return result;
    }

    /// Sum of unit normals at an edge, weighted by angle at a vertex: its sign tells the sides of a closed surface
    /// apart (Baerentzen and Aanaes 2005).
    Vector3d normal_at(int t, const ClosestPoint& match) const {
        const int v = surface_.triangles(t, match.corner_a);
        const int w = match.corner_b >= 0 ? surface_.triangles(t, match.corner_b) : -1;
        Vector3d sum = Vector3d::Zero();
        for (const int other : vertex_triangles_[v]) {
            int at = 0;
            bool has_w = w < 0;
            for (int k = 0; k < 3; ++k) {
                if (surface_.triangles(other, k) == v) at = k;
                has_w |= surface_.triangles(other, k) == w;
            }
            if (!has_w) continue;
            const Vector3d e = corner(other, (at + 1) % 3) - corner(other, at),
                           f = corner(other, (at + 2) % 3) - corner(other, at), n = e.cross(f);
            const double angle = w < 0 ? std::atan2(n.norm(), e.dot(f)) : 1;
            sum += angle * n.stableNormalized();
        }
        return sum.stableNormalized();
    }

    const TriMesh& surface_;
    const IntLists& vertex_triangles_;
};

double total_weight(const std::string& name, const std::vector<MeasuredPoint>& points) {
    if (points.empty()) throw InvalidInput(text(name, ": no points"));
    double total = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const MeasuredPoint& p = points[i];
        if (!p.at.allFinite())
            throw InvalidInput(text(name, ": point ", i, " is not finite: (", p.at.transpose(), ")"));
        if (!(p.weight >= 0) || !std::isfinite(p.weight))
            throw InvalidInput(text(name, ": weight of point ", i, " = ", p.weight, " must be >= 0 and finite"));
        total += p.weight;
    }
    if (!(total > 0) || !std::isfinite(total))
        throw InvalidInput(text(name, ": the weights sum to ", total, ", must be > 0 and finite"));
    return total;
}

}  // namespace

Quantity measured_points(const std::string& name, const TriMesh& start, const std::vector<MeasuredPoint>& points) {
    const double total = total_weight(name, points);
    const auto around = std::make_shared<const IntLists>(adjacency(start).vertex_triangles);
    return sum_of_squares(name, start.num_vertices(), start.num_triangles(),
                          [=](const TriMesh& surface, const TriMesh& matched) {
                              const ClosestPointTree tree(matched);
                              const Distances distances(surface, *around);
                              const int count = static_cast<int>(points.size());
                              ResidualRows rows(count, 1, surface.num_vertices());
                              for (int i = 0; i < count; ++i) {
                                  const ClosestPoint match = tree.find(points[i].at);
                                  const SignedDistance at = distances.of(points[i].at, match);
                                  const double weight = points[i].weight / total, root = std::sqrt(weight);
                                  rows.set_weight(i, weight);
                                  rows.set(i, root * at.d);
                                  for (int k = 0; k < 3; ++k)
                                      rows.add(i, surface.triangles(match.triangle, k), root * at.dd_dv[k]);
                              }
                              return rows.finish(name + ": point");
                          });
}

std::vector<MeasuredPoint> read_measured_points(const std::filesystem::path& file) {
    std::vector<MeasuredPoint> points;
    for (const TableRow& row : read_table(file, {"x", "y", "z", "weight"}, 3)) {
        MeasuredPoint point{{row.values[0], row.values[1], row.values[2]}};
        if (row.values.size() > 3) point.weight = row.values[3];
        if (point.weight < 0)
            throw InputError(text(file.string(), ":", row.line, ": weight = ", point.weight, " must be >= 0"));
        points.push_back(point);
    }
    return points;
}

}  // namespace strake
