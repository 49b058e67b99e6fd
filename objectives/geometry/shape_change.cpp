#include "objectives/geometry/shape_change.hpp"

#include "core/error.hpp"
#include "core/mesh/adjacency.hpp"
#include "core/mesh/closest_point.hpp"
#include "core/mesh/geometry.hpp"
#include "objectives/quantity/finite.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>

namespace strake {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

/// Shares of the marked area, per vertex; they sum to one. @throws InvalidInput without marked area.
VectorXd shares(const std::string& name, const TriMesh& start, const std::vector<char>& region) {
    if (const auto failure = vertices_finite(name, start)) throw InvalidInput(failure->message);
    if (!region.empty() && static_cast<int>(region.size()) != start.num_triangles())
        throw InvalidInput(text(name, ": ", region.size(), " marks for ", start.num_triangles(), " triangles"));
    VectorXd share = VectorXd::Zero(start.num_vertices());
    const VectorXd areas = triangle_areas(start);
    for (int t = 0; t < start.num_triangles(); ++t)
        if (region.empty() || region[t])
            for (int k = 0; k < 3; ++k) share[start.triangles(t, k)] += areas[t];
    const double sum = share.sum();
    if (!(sum > 0)) throw InvalidInput(text(name, ": the region has no area"));
    return share / sum;
}

/// A hinge of two triangles.
struct Hinge {
    std::array<int, 2> t;
    std::array<int, 2> edge;  ///< as the first triangle runs through it
    double rest, weight;
};

/// Signed dihedral; by_s becomes its derivatives by the two area vectors (maybe null).
double hinge_angle(const TriMesh& mesh, const Hinge& hinge, std::array<Vector3d, 2>* by_s) {
    const Vector3d e = (mesh.vertices.row(hinge.edge[1]) - mesh.vertices.row(hinge.edge[0])).transpose();
    const Vector3d along = e.normalized();
    std::array<Vector3d, 2> s, N;
    for (int i = 0; i < 2; ++i) {
        s[i] = area_vector(mesh, hinge.t[i]);
        N[i] = s[i].normalized();
    }
    if (by_s) *by_s = {-along.cross(N[0]) / s[0].norm(), along.cross(N[1]) / s[1].norm()};
    return std::atan2(N[0].cross(N[1]).dot(along), N[0].dot(N[1]));
}

double within_half_turn(double angle) { return std::remainder(angle, 2 * std::numbers::pi); }

std::vector<Hinge> sharp_hinges(const TriMesh& start, double angle, const std::vector<char>& region) {
    const Adjacency adjacent = adjacency(start);
    std::vector<Hinge> hinges;
    double length = 0;
    for (int e = 0; e < adjacent.num_edges(); ++e) {
        if (!adjacent.is_regular(e)) continue;
        const int t = adjacent.edge_triangles[e][0], u = adjacent.edge_triangles[e][1];
        if (!region.empty() && !(region[t] && region[u])) continue;
        int k = 0;
        while (adjacent.triangle_edges(t, k) != e) ++k;
        Hinge hinge{{t, u}, {start.triangles(t, k), start.triangles(t, (k + 1) % 3)}, 0, 0};
        hinge.rest = hinge_angle(start, hinge, nullptr);
        if (!(std::abs(hinge.rest) >= angle - 1e-9)) continue;
        hinge.weight = (start.vertices.row(hinge.edge[1]) - start.vertices.row(hinge.edge[0])).norm();
        length += hinge.weight;
        hinges.push_back(hinge);
    }
    for (Hinge& hinge : hinges) hinge.weight /= length;
    return hinges;
}

/// Point of the surface for the mirror image of vertex k.
struct Partner {
    std::array<int, 3> corner;
    Vector3d b;  ///< barycentric
};

std::vector<Partner> partners(const TriMesh& start, const SymmetryPlane& plane) {
    const ClosestPointTree tree(start);
    std::vector<Partner> all;
    for (int v = 0; v < start.num_vertices(); ++v) {
        const Vector3d x = start.vertices.row(v);
        const ClosestPoint at = tree.find(x - 2 * (plane.normal.dot(x) - plane.offset) * plane.normal);
        const auto c = start.triangles.row(at.triangle);
        const Vector3d p = start.vertices.row(c[0]), e = Vector3d(start.vertices.row(c[1])) - p,
                       f = Vector3d(start.vertices.row(c[2])) - p, r = at.point - p;
        const double ee = e.dot(e), ef = e.dot(f), ff = f.dot(f), det = ee * ff - ef * ef;
        const double b1 = (ff * e.dot(r) - ef * f.dot(r)) / det, b2 = (ee * f.dot(r) - ef * e.dot(r)) / det;
        all.push_back({{c[0], c[1], c[2]}, det > 0 ? Vector3d(1 - b1 - b2, b1, b2) : Vector3d(1, 0, 0)});
    }
    return all;
}

}  // namespace

Quantity displacement(const std::string& name, const TriMesh& start, const std::vector<char>& region) {
    const VectorXd share = shares(name, start, region);
    return checked_quantity(name, {name}, start, [=, rest = start.vertices](const QuantityRequest& request) {
        const Points d = request.surface.vertices - rest, weighted = share.asDiagonal() * d;
        const double sum = d.cwiseProduct(weighted).sum();
        return one_value(sum, request.wants(0) ? Points(2 * weighted) : Points());
    });
}

Quantity creases(const std::string& name, const TriMesh& start, double angle, const std::vector<char>& region) {
    shares(name, start, region);  // checks
    if (!(angle > 0) || !(angle < std::numbers::pi))
        throw InvalidInput(text(name, ": angle = ", angle, " must be in (0, pi)"));
    const auto hinges = std::make_shared<const std::vector<Hinge>>(sharp_hinges(start, angle, region));
    if (hinges->empty())
        throw InvalidInput(text(name, ": no edge is as sharp as ", angle * 180 / std::numbers::pi, " degrees"));
    return checked_quantity(name, {name}, start, [=](const QuantityRequest& request) {
        const TriMesh& mesh = request.surface;
        Points dJ_dv = request.wants(0) ? Points(Points::Zero(mesh.num_vertices(), 3)) : Points();
        double sum = 0;
        for (const Hinge& hinge : *hinges) {
            std::array<Vector3d, 2> by_s;
            const double change = within_half_turn(hinge_angle(mesh, hinge, &by_s) - hinge.rest);
            sum += hinge.weight * change * change;
            if (dJ_dv.rows() == 0) continue;
            for (int i = 0; i < 2; ++i)
                for (int k = 0; k < 3; ++k) {
                    const auto v = mesh.triangles.row(hinge.t[i]);
                    const Vector3d opposite = mesh.vertices.row(v[(k + 2) % 3]) - mesh.vertices.row(v[(k + 1) % 3]);
                    dJ_dv.row(v[k]) += hinge.weight * change * by_s[i].cross(opposite);
                }
        }
        return one_value(sum, std::move(dJ_dv));
    });
}

Quantity planarity(const std::string& name, const TriMesh& start, const std::vector<char>& region) {
    const VectorXd share = shares(name, start, region);
    if ((share.array() > 0).count() < 4) throw InvalidInput(text(name, ": the region has fewer than four vertices"));
    return checked_quantity(name, {name}, start, [=](const QuantityRequest& request) {
        const Points& v = request.surface.vertices;
        const Eigen::RowVector3d mean = share.transpose() * v;
        const Points from_mean = v.rowwise() - mean, weighted = share.asDiagonal() * from_mean;
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(from_mean.transpose() * weighted);
        const Vector3d n = solver.eigenvectors().col(0);
        // In the plane's own frame the smallest eigenvalue keeps its digits.
        const VectorXd off = from_mean * n;
        const double sum = off.dot(share.cwiseProduct(off));
        return one_value(sum, request.wants(0) ? Points(2 * share.cwiseProduct(off) * n.transpose()) : Points());
    });
}

Quantity symmetry_error(const std::string& name, const TriMesh& start, const SymmetryPlane& plane) {
    const VectorXd share = shares(name, start, {});
    const auto of = std::make_shared<const std::vector<Partner>>(partners(start, plane));
    return checked_quantity(name, {name}, start, [=](const QuantityRequest& request) {
        const Points& v = request.surface.vertices;
        Points dJ_dv = request.wants(0) ? Points(Points::Zero(v.rows(), 3)) : Points();
        double sum = 0;
        for (Eigen::Index k = 0; k < v.rows(); ++k) {
            const Partner& partner = (*of)[static_cast<std::size_t>(k)];
            const Vector3d x = v.row(k);
            Vector3d off = x - 2 * (plane.normal.dot(x) - plane.offset) * plane.normal;
            for (int c = 0; c < 3; ++c) off -= partner.b[c] * Vector3d(v.row(partner.corner[c]));
            sum += share[k] * off.squaredNorm();
            if (dJ_dv.rows() == 0) continue;
            const Vector3d by = 2 * share[k] * off;
            dJ_dv.row(k) += by - 2 * plane.normal.dot(by) * plane.normal;
            for (int c = 0; c < 3; ++c) dJ_dv.row(partner.corner[c]) -= partner.b[c] * by;
        }
        return one_value(sum, std::move(dJ_dv));
    });
}

}  // namespace strake
