#include "objectives/geometry/measures.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "objectives/quantity/closed.hpp"
#include "objectives/quantity/finite.hpp"

#include <algorithm>
#include <cmath>

namespace strake {
namespace {

using Eigen::Vector3d;

constexpr double mirror_plane_rel = 1e-6;  // of the diagonal
constexpr double zero_volume_rel = 1e-12;  // of area times diagonal: round-off of a flat surface

[[noreturn]] void refuse_open(const TriMesh& mesh, const Adjacency& adjacent, const std::vector<int>& open,
                              const std::optional<SymmetryPlane>& symmetry, double diagonal) {
    const int e = open.front();
    const auto [a, b] = adjacent.edges[e];
    const std::string where = edge_between(mesh, adjacent.edges[e]);
    if (adjacent.edge_triangles[e].size() > 1)
        throw InvalidInput(text("volume: the ", adjacent.edge_triangles[e].size(), " triangles at the ", where,
                                " disagree in orientation (first of ", open.size(),
                                " such or open edges); orient the surface first"));
    const std::string first = text("volume: the surface is open at the ", where, ", first of ", open.size(),
                                   open.size() == 1 ? " open edge" : " open edges");
    const std::string then = open_remedy(mesh, adjacent, open);
    if (!symmetry) throw InvalidInput(text(first, "; ", then));
    const auto off = [&](int v) { return std::abs(symmetry->normal.dot(mesh.vertices.row(v)) - symmetry->offset); };
    throw InvalidInput(text(first, " that are not on the symmetry plane: ", std::max(off(a), off(b)),
                            " away from it, the limit is 1e-6 of the diagonal = ", mirror_plane_rel * diagonal, "; ",
                            then));
}

/// Vertices at boundary edges on the plane, one flag each. @throws InvalidInput at any other unbalanced edge.
std::vector<char> boundary_vertices(const TriMesh& mesh, const std::optional<SymmetryPlane>& symmetry,
                                    double diagonal) {
    const Adjacency adjacent = adjacency(mesh);
    std::vector<char> boundary(mesh.num_vertices(), 0);
    const std::vector<int> open = open_edges(mesh, adjacent, symmetry);
    if (!open.empty()) refuse_open(mesh, adjacent, open, symmetry, diagonal);
    for (int e = 0; e < adjacent.num_edges(); ++e)
        if (edge_imbalance(mesh, adjacent, e) != 0)
            for (const int v : adjacent.edges[e]) boundary[v] = 1;
    return boundary;
}

/// The apex o of the cones: the origin, to agree with the plain formula bit by bit, or the box's centre (in the plane,
/// for a half model) where the origin is too far away to keep the digits.
Vector3d measuring_point(const TriMesh& mesh, const std::optional<SymmetryPlane>& symmetry) {
    const Box box = bounding_box(mesh);
    const Vector3d centre = 0.5 * (box.min + box.max);
    const bool origin_on_plane = !symmetry || symmetry->offset == 0;
    if (origin_on_plane && centre.norm() <= 10 * (box.max - box.min).norm()) return Vector3d::Zero();
    if (!symmetry) return centre;
    return centre - (symmetry->normal.dot(centre) - symmetry->offset) * symmetry->normal;
}

struct VolumeOf {
    std::vector<char> boundary;
    Vector3d o = Vector3d::Zero();
    double sign = 1;

    /// Twice the area vector. Differences first: an offset of the surface costs no digits.
    static Vector3d normal(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
        const Vector3d u = b - a, w = c - a;
        return {u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]};
    }

    /// For a half model, whose fans are open along the plane.
    bool has_boundary() const { return std::find(boundary.begin(), boundary.end(), 1) != boundary.end(); }

    /// dV/da = 1/6 sum over the fan of a of (b - o) x (c - o) = 1/6 sum [n_t + (a - o) x (c - b)]; the second part
    /// telescopes to zero around a closed fan and is omitted there.
    double value(const TriMesh& mesh, Points* dV_dv = nullptr) const {
        double sum = 0;
        if (dV_dv) *dV_dv = Points::Zero(mesh.num_vertices(), 3);
        for (int t = 0; t < mesh.num_triangles(); ++t) {
            const auto v = mesh.triangles.row(t);
            const Vector3d p = mesh.vertices.row(v[0]), a = p - o;
            const Vector3d n = normal(p, mesh.vertices.row(v[1]), mesh.vertices.row(v[2]));
            // Written out: the order of the sum must not depend on Eigen's reductions.
            sum += (a[0] * n[0] + a[1] * n[1] + a[2] * n[2]) / 6;
            if (!dV_dv) continue;
            const Vector3d share = sign * (n / 6);
            for (int k = 0; k < 3; ++k) dV_dv->row(v[k]) += share;
        }
        if (dV_dv && has_boundary()) add_boundary(mesh, *dV_dv);
        return sign * sum;
    }

    void add_boundary(const TriMesh& mesh, Points& dV_dv) const {
        Points link = Points::Zero(mesh.num_vertices(), 3);
        for (int t = 0; t < mesh.num_triangles(); ++t)
            for (int k = 0; k < 3; ++k)
                link.row(mesh.triangles(t, k)) += mesh.vertices.row(mesh.triangles(t, (k + 2) % 3)) -
                                                  mesh.vertices.row(mesh.triangles(t, (k + 1) % 3));
        for (int v = 0; v < mesh.num_vertices(); ++v)
            if (boundary[v])
                dV_dv.row(v) += sign * ((Vector3d(mesh.vertices.row(v)) - o).cross(Vector3d(link.row(v))) / 6);
    }
};

}  // namespace

Quantity volume(const TriMesh& start, const std::optional<SymmetryPlane>& symmetry) {
    const double diagonal = box_diagonal(start);
    if (start.num_triangles() == 0 || !start.vertices.allFinite())
        throw InvalidInput(text("volume: needs a surface of at least one triangle and finite vertices, got ",
                                start.num_triangles(), " triangles"));
    VolumeOf of{boundary_vertices(start, symmetry, diagonal), measuring_point(start, symmetry), 1};
    const double V = of.value(start), limit = zero_volume_rel * surface_area(start) * diagonal;
    if (!(std::abs(V) > limit))
        throw InvalidInput(text("volume: the surface encloses no volume: ", V, " at the start, the limit is 1e-12 of ",
                                "area times diagonal = ", limit));
    of.sign = V > 0 ? 1 : -1;
    Quantity quantity;
    quantity.names = {"volume"};
    quantity.evaluate = [of, nv = start.num_vertices(), nt = start.num_triangles()](const QuantityRequest& request) {
        require_same_counts("volume", request.surface, nv, nt);
        if (auto failure = vertices_finite("volume", request.surface)) return QuantityResult{{}, {}, failure};
        Points dV_dv;
        const double V = of.value(request.surface, request.want_sensitivities ? &dV_dv : nullptr);
        return finite({"volume"}, one_value(V, std::move(dV_dv)));
    };
    return quantity;
}

Quantity area(bool zero_areas) {
    Quantity quantity;
    quantity.names = {"area"};
    quantity.evaluate = [zero_areas](const QuantityRequest& request) {
        const TriMesh& mesh = request.surface;
        if (auto failure = vertices_finite("area", mesh)) return QuantityResult{{}, {}, failure};
        if (!request.want_sensitivities) return finite({"area"}, one_value(surface_area(mesh), {}));
        double sum = 0;
        Points dA_dv = Points::Zero(mesh.num_vertices(), 3);
        for (int t = 0; t < mesh.num_triangles(); ++t) {
            const Vector3d s = area_vector(mesh, t);
            const double A = s.stableNorm();
            if (A == 0 && zero_areas) continue;
            if (!(A > 0))
                return QuantityResult{
                    {}, {}, Failure{"undefined", text("area: triangle ", t, " has area 0, no sensitivity there")}};
            sum += A;
            const Vector3d half_normal = 0.5 / A * s;
            for (int k = 0; k < 3; ++k) {
                const Vector3d opposite = mesh.vertices.row(mesh.triangles(t, (k + 2) % 3)) -
                                          mesh.vertices.row(mesh.triangles(t, (k + 1) % 3));
                dA_dv.row(mesh.triangles(t, k)) += half_normal.cross(opposite);
            }
        }
        return finite({"area"}, one_value(sum, std::move(dA_dv)));
    };
    return quantity;
}

}  // namespace strake
