#include "objectives/geometry/bending.hpp"

#include "core/error.hpp"
#include "core/mesh/adjacency.hpp"
#include "core/mesh/cotangents.hpp"
#include "core/mesh/geometry.hpp"
#include "objectives/quantity/closed.hpp"
#include "objectives/quantity/finite.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

namespace strake {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

/// Interior vertices with all triangles marked. In the plane of symmetry only the part in the plane counts: the mirror
/// image cancels the normal part.
struct Inner {
    std::vector<char> counts, in_plane;
    Vector3d normal = Vector3d::Zero();

    Vector3d seen(int v, const Vector3d& g) const { return in_plane[v] ? Vector3d(g - normal * normal.dot(g)) : g; }
};

/// Unmarks the vertices of triangles outside the region.
void exclude_outside(const TriMesh& mesh, const std::vector<char>& region, std::vector<char>& counts) {
    for (std::size_t t = 0; t < region.size(); ++t)
        if (!region[t])
            for (int k = 0; k < 3; ++k) counts[mesh.triangles(static_cast<Eigen::Index>(t), k)] = 0;
}

Inner inner(const std::string& name, const TriMesh& start, const std::vector<char>& region,
            const std::optional<SymmetryPlane>& symmetry) {
    if (!region.empty() && static_cast<int>(region.size()) != start.num_triangles())
        throw InvalidInput(text(name, ": ", region.size(), " marks for ", start.num_triangles(), " triangles"));
    for (int t = 0; t < start.num_triangles(); ++t)
        if (!(area_vector(start, t).norm() > 0)) throw InvalidInput(text(name, ": triangle ", t, " has area 0"));
    std::vector<char> counts(start.num_vertices(), 0), in_plane = counts;
    for (int t = 0; t < start.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k) counts[start.triangles(t, k)] = 1;
    const Adjacency adjacent = adjacency(start);
    const std::vector<char> closes = plane_edges(start, adjacent, symmetry);
    for (int e = 0; e < adjacent.num_edges(); ++e)
        if (adjacent.edge_triangles[e].size() == 1)
            for (const int v : adjacent.edges[e]) (closes[e] ? in_plane[v] : counts[v]) = closes[e];
    exclude_outside(start, region, counts);
    if (std::find(counts.begin(), counts.end(), 1) == counts.end())
        throw InvalidInput(text(name, ": no inner vertex has all of its triangles in the region"));
    return {std::move(counts), std::move(in_plane), symmetry ? symmetry->normal : Vector3d(Vector3d::Zero())};
}

struct Facet {
    Vector3d N;
    double area;
    std::array<Vector3d, 3> opposite;  ///< edge opposite to corner k, along the triangle
};

Facet facet(const TriMesh& mesh, int t) {
    const auto at = [&](int k) { return Vector3d(mesh.vertices.row(mesh.triangles(t, k % 3))); };
    Facet f;
    const Vector3d s = area_vector(mesh, t);
    f.area = s.norm();
    f.N = s / f.area;
    for (int k = 0; k < 3; ++k) f.opposite[k] = at(k + 2) - at(k + 1);
    return f;
}

/// dA/dv and a third of the areas at each vertex.
void first_variation(const TriMesh& mesh, Points& g, VectorXd& a) {
    g = Points::Zero(mesh.num_vertices(), 3);
    a = VectorXd::Zero(mesh.num_vertices());
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        const Facet f = facet(mesh, t);
        for (int k = 0; k < 3; ++k) {
            g.row(mesh.triangles(t, k)) += 0.5 * f.N.cross(f.opposite[k]);
            a[mesh.triangles(t, k)] += f.area / 3;
        }
    }
}

double willmore(const TriMesh& mesh, const Inner& inside, Points* dJ_dv) {
    Points g;
    VectorXd a;
    first_variation(mesh, g, a);
    double sum = 0;
    Points y = Points::Zero(mesh.num_vertices(), 3);   // dW/dg
    VectorXd z = VectorXd::Zero(mesh.num_vertices());  // dW/da
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        if (!inside.counts[v]) continue;
        const Vector3d seen = inside.seen(v, g.row(v));
        const double g2 = seen.squaredNorm();
        sum += g2 / (4 * a[v]);
        y.row(v) = seen / (2 * a[v]);
        z[v] = -g2 / (4 * a[v] * a[v]);
    }
    if (!dJ_dv) return sum;
    // dW = y . dg + z . da; y . dg is the second variation of the area along y.
    *dJ_dv = Points::Zero(mesh.num_vertices(), 3);
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        const Facet f = facet(mesh, t);
        const auto v = mesh.triangles.row(t);
        std::array<Vector3d, 3> dy;
        Vector3d ds = Vector3d::Zero();
        for (int k = 0; k < 3; ++k) {
            dy[k] = (y.row(v[(k + 2) % 3]) - y.row(v[(k + 1) % 3])).transpose();
            ds += 0.5 * f.opposite[k].cross(Vector3d(y.row(v[k])));
        }
        const Vector3d dN = (ds - f.N * f.N.dot(ds)) / f.area;
        const double by_area = (z[v[0]] + z[v[1]] + z[v[2]]) / 3;
        const Vector3d turning = 0.5 * (dN + by_area * f.N), N = 0.5 * f.N;
        for (int k = 0; k < 3; ++k) dJ_dv->row(v[k]) += turning.cross(f.opposite[k]) + N.cross(dy[k]);
    }
    return sum;
}

}  // namespace

Quantity bending_energy(const std::string& name, const TriMesh& start, const std::vector<char>& region,
                        const std::optional<SymmetryPlane>& symmetry) {
    if (const auto failure = vertices_finite(name, start)) throw InvalidInput(failure->message);
    const Inner inside = inner(name, start, region, symmetry);
    return checked_quantity(name, {name}, start, [=](const QuantityRequest& request) {
        Points dJ_dv;
        const double W = willmore(request.surface, inside, request.wants(0) ? &dJ_dv : nullptr);
        return one_value(W, std::move(dJ_dv));
    });
}

Quantity fairness(const std::string& name, const TriMesh& start, const std::vector<char>& region,
                  const std::optional<SymmetryPlane>& symmetry) {
    if (const auto failure = vertices_finite(name, start)) throw InvalidInput(failure->message);
    const Inner inside = inner(name, start, region, symmetry);
    const auto L = std::make_shared<const Eigen::SparseMatrix<double>>(cotangent_matrix(start));
    VectorXd weight = vertex_areas(start);
    for (int v = 0; v < start.num_vertices(); ++v) weight[v] = inside.counts[v] ? 1 / weight[v] : 0;
    return checked_quantity(name, {name}, start, [=, rest = start.vertices](const QuantityRequest& request) {
        Points bent = *L * (request.surface.vertices - rest);
        for (int v = 0; v < bent.rows(); ++v) bent.row(v) = inside.seen(v, bent.row(v));
        const Points weighted = weight.asDiagonal() * bent;
        const double sum = bent.cwiseProduct(weighted).sum();
        return one_value(sum, request.wants(0) ? Points(2 * (L->transpose() * weighted)) : Points());
    });
}

}  // namespace strake
