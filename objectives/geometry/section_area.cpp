#include "objectives/geometry/section_area.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "objectives/quantity/closed.hpp"
#include "objectives/quantity/finite.hpp"
#include "objectives/quantity/residuals.hpp"

#include <Eigen/Geometry>
#include <array>
#include <cmath>

namespace strake {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double zero_area_rel = 1e-12;  // of the outline's length squared: round-off

class Cut {
public:
    Cut(std::string name, const TriMesh& start, const Section& section, const std::optional<SymmetryPlane>& symmetry);

    /// @throws InvalidInput where the plane misses the surface or cuts an open edge.
    double area(const TriMesh& mesh, Points* dA_dv) const;
    double start_length() const { return start_length_; }

private:
    struct End {
        int a, b;  ///< edge, smaller vertex first, so that neighbours get the same point
        double t;
        Vector3d p;
    };
    bool above(const TriMesh& mesh, int v) const { return n_.dot(mesh.vertices.row(v)) - offset_ >= 0; }
    End end(const TriMesh& mesh, int v, int w) const;
    std::optional<std::array<End, 2>> segment(const TriMesh& mesh, int t) const;
    void add_end(const TriMesh& mesh, const End& end, const Vector3d& dA_dp, Points& dA_dv) const;

    std::string name_;
    Vector3d n_, o_;
    double offset_ = 0, sign_ = 1, start_length_ = 0;
    std::vector<std::array<int, 2>> open_;  ///< edges that a section must not cut
};

/// A point of the plane near the surface's centre. With symmetry it also lies in the plane of symmetry where the two
/// meet: the line that closes the half's outline then passes through it and adds nothing.
Vector3d measuring_point(const TriMesh& start, const Vector3d& n, double offset,
                         const std::optional<SymmetryPlane>& symmetry) {
    const Box box = bounding_box(start);
    Vector3d o = 0.5 * (box.min + box.max);
    o += (offset - n.dot(o)) * n;
    if (!symmetry) return o;
    const Vector3d within = symmetry->normal - symmetry->normal.dot(n) * n;
    if (within.norm() < 1e-9) return o;  // parallel planes: no open edge is cut
    return o + (symmetry->offset - symmetry->normal.dot(o)) / within.squaredNorm() * within;
}

Cut::Cut(std::string name, const TriMesh& start, const Section& section, const std::optional<SymmetryPlane>& symmetry)
    : name_(std::move(name)), n_(section.normal.stableNormalized()), offset_(section.offset) {
    const Adjacency adjacent = adjacency(start);
    for (const int e : open_edges(start, adjacent, symmetry)) open_.push_back(adjacent.edges[e]);
    o_ = measuring_point(start, n_, offset_, symmetry);
    for (int t = 0; t < start.num_triangles(); ++t)
        if (const auto s = segment(start, t)) start_length_ += ((*s)[1].p - (*s)[0].p).norm();
    const double found = area(start, nullptr);
    if (!(std::abs(found) > zero_area_rel * start_length_ * start_length_))
        throw InvalidInput(text(name_, ": the section encloses no area (", found, ")"));
    if (found < 0) sign_ = -1;
}

Cut::End Cut::end(const TriMesh& mesh, int v, int w) const {
    const int a = std::min(v, w), b = std::max(v, w);
    const Vector3d p = mesh.vertices.row(a), e = Vector3d(mesh.vertices.row(b)) - p;
    const double t = std::clamp((offset_ - n_.dot(p)) / n_.dot(e), 0.0, 1.0);
    return {a, b, t, p + t * e};
}

/// From the upward to the downward crossing along the triangle's border: the outline of an outward surface then has one
/// sense about n.
std::optional<std::array<Cut::End, 2>> Cut::segment(const TriMesh& mesh, int t) const {
    std::optional<End> up, down;
    for (int k = 0; k < 3; ++k) {
        const int v = mesh.triangles(t, k), w = mesh.triangles(t, (k + 1) % 3);
        if (above(mesh, v) == above(mesh, w)) continue;
        (above(mesh, w) ? up : down) = end(mesh, v, w);
    }
    if (!up || !down) return {};
    return std::array<End, 2>{*up, *down};
}

void Cut::add_end(const TriMesh& mesh, const End& end, const Vector3d& dA_dp, Points& dA_dv) const {
    const Vector3d e = mesh.vertices.row(end.b) - mesh.vertices.row(end.a);
    const Vector3d along = sign_ * (dA_dp - n_ * (e.dot(dA_dp) / n_.dot(e)));  // P^T dA/dp
    dA_dv.row(end.a) += (1 - end.t) * along;
    dA_dv.row(end.b) += end.t * along;
}

double Cut::area(const TriMesh& mesh, Points* dA_dv) const {
    for (const auto& [a, b] : open_)
        if (above(mesh, a) != above(mesh, b))
            throw InvalidInput(text(name_, ": the section is open at the edge from vertex ", a, " (",
                                    mesh.vertices.row(a), ") to vertex ", b, " (", mesh.vertices.row(b),
                                    "); close the surface there, or set symmetry: for a half model"));
    if (dA_dv) *dA_dv = Points::Zero(mesh.num_vertices(), 3);
    double twice = 0;
    bool any = false;
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        const auto s = segment(mesh, t);
        if (!s) continue;
        any = true;
        const Vector3d p = (*s)[0].p - o_, q = (*s)[1].p - o_;
        twice += n_.dot(p.cross(q));
        if (!dA_dv) continue;
        add_end(mesh, (*s)[0], 0.5 * q.cross(n_), *dA_dv);
        add_end(mesh, (*s)[1], 0.5 * n_.cross(p), *dA_dv);
    }
    if (!any)
        throw InvalidInput(
            text(name_, ": the plane (", n_.transpose(), ") . x = ", offset_, " does not cut the surface"));
    return sign_ * 0.5 * twice;
}

void check(const std::string& name, const Section& section) {
    if (!section.normal.allFinite() || section.normal.isZero(0) || !std::isfinite(section.offset))
        throw InvalidInput(text(name, ": the plane with normal (", section.normal.transpose(), ") at ", section.offset,
                                " must have a finite normal that is not zero and a finite offset"));
    if (section.target && (!(*section.target > 0) || !std::isfinite(*section.target)))
        throw InvalidInput(text(name, ": the target area ", *section.target, " must be > 0 and finite"));
}

}  // namespace

Quantity section_area(const std::string& name, const TriMesh& start, const Section& section,
                      const std::optional<SymmetryPlane>& symmetry) {
    check(name, section);
    if (const auto failure = vertices_finite(name, start)) throw InvalidInput(failure->message);
    const Cut cut(name, start, section, symmetry);
    const int nv = start.num_vertices(), nt = start.num_triangles();
    Quantity quantity = checked_quantity(name, {name}, start, [=](const QuantityRequest& request) {
        Points dA_dv;
        const double A = cut.area(request.surface, request.want_sensitivities ? &dA_dv : nullptr);
        return one_value(A, std::move(dA_dv));
    });
    if (section.target)
        quantity.residuals = checked(name, nv, nt, [=](const TriMesh& surface, const TriMesh&) {
            Points dA_dv;
            const double A = cut.area(surface, &dA_dv);
            ResidualRows rows(1, 1, nv);
            rows.set(0, (A - *section.target) / cut.start_length());
            for (int v = 0; v < nv; ++v)
                if (!dA_dv.row(v).isZero(0)) rows.add(0, v, dA_dv.row(v).transpose() / cut.start_length());
            return rows.finish(name + ": section");
        });
    return quantity;
}

}  // namespace strake
