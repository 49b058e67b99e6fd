#include "core/error.hpp"
#include "core/mesh/disjoint_sets.hpp"
#include "core/mesh/geometry.hpp"
#include "objectives/geometry/measures.hpp"
#include "objectives/quantity/closed.hpp"
#include "objectives/quantity/finite.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

namespace strake {
namespace {

using Eigen::Vector3d;

constexpr double no_volume_rel = 1e-12;  ///< of area times diagonal

/// An open edge, `times` more often traversed from a to b than back.
struct OpenEdge {
    int a = 0, b = 0, times = 0, cone = 0;
};

/// The apex of a cone: a fixed mean of vertices, in the plane of symmetry where the edges end there.
struct Cone {
    std::map<int, double> share;
    bool ends_on_plane = false;
};

struct ClosedByCones {
    Vector3d o = Vector3d::Zero();
    std::optional<SymmetryPlane> symmetry;
    std::vector<OpenEdge> edges;
    std::vector<Cone> cones;
    double sign = 1;

    double value(const TriMesh& mesh, Points* dV_dv) const;
    Vector3d apex(const Cone& cone, const Points& x) const;
};

Vector3d ClosedByCones::apex(const Cone& cone, const Points& x) const {
    Vector3d sum = Vector3d::Zero();
    for (const auto& [v, share] : cone.share) sum += share * x.row(v).transpose();
    if (cone.ends_on_plane) sum -= (symmetry->normal.dot(sum) - symmetry->offset) * symmetry->normal;
    return sum;
}

/// One sixth of det(a - o, b - o, c - o) over the triangles and the cones; each term's derivative is exact.
double ClosedByCones::value(const TriMesh& mesh, Points* dV_dv) const {
    double sum = 0;
    if (dV_dv) *dV_dv = Points::Zero(mesh.num_vertices(), 3);
    const Points& x = mesh.vertices;
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        std::array<Vector3d, 3> p;
        for (int k = 0; k < 3; ++k) p[k] = x.row(mesh.triangles(t, k)).transpose() - o;
        sum += p[0].dot(p[1].cross(p[2])) / 6;
        for (int k = 0; dV_dv && k < 3; ++k)
            dV_dv->row(mesh.triangles(t, k)) += sign / 6 * p[(k + 1) % 3].cross(p[(k + 2) % 3]).transpose();
    }
    std::vector<Vector3d> at, pull(cones.size(), Vector3d::Zero());
    for (const Cone& cone : cones) at.push_back(apex(cone, x) - o);
    for (const OpenEdge& e : edges) {
        const Vector3d a = x.row(e.a).transpose() - o, b = x.row(e.b).transpose() - o;
        const Vector3d& c = at[static_cast<std::size_t>(e.cone)];
        const double times = e.times / 6.0;
        sum += times * c.dot(b.cross(a));
        if (!dV_dv) continue;
        dV_dv->row(e.a) += sign * times * c.cross(b).transpose();
        dV_dv->row(e.b) += sign * times * a.cross(c).transpose();
        pull[static_cast<std::size_t>(e.cone)] += sign * times * b.cross(a);
    }
    for (std::size_t k = 0; dV_dv && k < cones.size(); ++k) {
        if (cones[k].ends_on_plane) pull[k] -= symmetry->normal.dot(pull[k]) * symmetry->normal;
        for (const auto& [v, share] : cones[k].share) dV_dv->row(v) += share * pull[k].transpose();
    }
    return sign * sum;
}

/// Open edges of one cone are connected over vertices.
void set_cones(const TriMesh& mesh, ClosedByCones& of) {
    DisjointSets sets(mesh.num_vertices());
    for (const OpenEdge& e : of.edges) sets.join(e.a, e.b);
    std::map<int, int> number;
    std::vector<double> length;
    std::map<int, int> end;  // the boundary of each cone's chain of edges
    for (OpenEdge& e : of.edges) {
        e.cone = number.emplace(sets.root(e.a), static_cast<int>(number.size())).first->second;
        of.cones.resize(number.size());
        length.resize(number.size(), 0);
        const double l = std::abs(e.times) * (mesh.vertices.row(e.b) - mesh.vertices.row(e.a)).norm();
        const auto cone = static_cast<std::size_t>(e.cone);
        for (const int v : {e.a, e.b}) of.cones[cone].share[v] += l / 2;
        length[cone] += l;
        end[e.a] -= e.times;
        end[e.b] += e.times;
    }
    for (std::size_t k = 0; k < of.cones.size(); ++k)
        for (auto& [v, share] : of.cones[k].share) {
            share = length[k] > 0 ? share / length[k] : 1.0 / static_cast<double>(of.cones[k].share.size());
            of.cones[k].ends_on_plane |= of.symmetry && end[v] != 0;
        }
}

}  // namespace

Quantity closed_volume(const TriMesh& start, const std::optional<SymmetryPlane>& symmetry) {
    if (start.num_triangles() == 0 || !start.vertices.allFinite())
        throw InvalidInput(text("volume: needs a surface of at least one triangle and finite vertices, got ",
                                start.num_triangles(), " triangles"));
    ClosedByCones of;
    const Box box = bounding_box(start);
    of.o = 0.5 * (box.min + box.max);
    of.symmetry = symmetry;
    if (symmetry) of.o -= (symmetry->normal.dot(of.o) - symmetry->offset) * symmetry->normal;
    const Adjacency adjacent = adjacency(start);
    for (const int e : open_edges(start, adjacent, symmetry))
        of.edges.push_back({adjacent.edges[e][0], adjacent.edges[e][1], edge_imbalance(start, adjacent, e), 0});
    set_cones(start, of);
    const double V = of.value(start, nullptr), limit = no_volume_rel * surface_area(start) * box_diagonal(start);
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

}  // namespace strake
