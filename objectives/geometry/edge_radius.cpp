#include "objectives/geometry/edge_radius.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "objectives/quantity/finite.hpp"

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <cmath>
#include <set>

namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Of one point, on the stack.
using Row = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 4, 1>;
using Basis = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 3>;

/// A point of the fit: a vertex (a == b), or where edge ab is cut.
struct Place {
    int a, b;
};

class Fit {
public:
    Fit(std::string name, const TriMesh& start, const std::vector<char>& region,
        const std::optional<SectionPlane>& plane);
    double radius(const TriMesh& mesh, Points* dr_dv) const;

private:
    Vector3d point(const TriMesh& mesh, const Place& place, double& t) const;
    std::string name_;
    bool cuts_ = false;
    Vector3d n_ = Vector3d::Zero(), o_;
    double offset_ = 0, size_ = 1;
    Basis basis_;  ///< 3 x 2 or 3 x 3
    std::vector<Place> places_;
};

Fit::Fit(std::string name, const TriMesh& start, const std::vector<char>& region,
         const std::optional<SectionPlane>& plane)
    : name_(std::move(name)), cuts_(plane.has_value()), basis_(Basis::Identity(3, 3)) {
    if (static_cast<int>(region.size()) != start.num_triangles())
        throw InvalidInput(text(name_, ": ", region.size(), " marks for ", start.num_triangles(), " triangles"));
    if (plane) {
        if (!plane->normal.allFinite() || plane->normal.isZero(0) || !std::isfinite(plane->offset))
            throw InvalidInput(text(name_, ": the plane must have a finite normal that is not zero"));
        n_ = plane->normal.stableNormalized();
        offset_ = plane->offset;
        basis_.resize(3, 2);
        basis_.col(0) = n_.unitOrthogonal();
        basis_.col(1) = n_.cross(Vector3d(basis_.col(0)));
    }
    std::set<std::pair<int, int>> found;
    for (int t = 0; t < start.num_triangles(); ++t) {
        if (!region[t]) continue;
        for (int k = 0; k < 3; ++k) {
            const int v = start.triangles(t, k), w = start.triangles(t, (k + 1) % 3);
            const auto above = [&](int i) { return n_.dot(start.vertices.row(i)) >= offset_; };
            if (!cuts_) found.insert({v, v});
            if (cuts_ && above(v) != above(w)) found.insert({std::min(v, w), std::max(v, w)});
        }
    }
    for (const auto& [a, b] : found) places_.push_back({a, b});
    if (places_.size() < 5)
        throw InvalidInput(text(name_, ": ", places_.size(), " points of the region for a ",
                                cuts_ ? "circle" : "sphere", "; at least 5 are needed"));
    o_.setZero();
    double t = 0;
    for (const Place& place : places_) o_ += point(start, place, t) / static_cast<double>(places_.size());
    size_ = 0;
    for (const Place& place : places_) size_ = std::max(size_, (point(start, place, t) - o_).norm());
    radius(start, nullptr);
}

Vector3d Fit::point(const TriMesh& mesh, const Place& place, double& t) const {
    const Vector3d a = mesh.vertices.row(place.a);
    t = 0;
    if (!cuts_) return a;
    const Vector3d e = Vector3d(mesh.vertices.row(place.b)) - a;
    const double rise = n_.dot(e);
    if (!(std::abs(rise) > 1e-9 * e.norm()))
        throw InvalidInput(text(name_, ": the edge from vertex ", place.a, " to ", place.b, " lies along the plane"));
    t = (offset_ - n_.dot(a)) / rise;
    return a + t * e;
}

/// In units of the points' spread, about their centre at the start.
double Fit::radius(const TriMesh& mesh, Points* dr_dv) const {
    const Eigen::Index d = basis_.cols(), count = static_cast<Eigen::Index>(places_.size());
    MatrixXd rows(count, d + 1);
    VectorXd squares(count), ts(count);
    for (Eigen::Index i = 0; i < count; ++i) {
        const Vector3d p = point(mesh, places_[static_cast<std::size_t>(i)], ts[i]);
        const Row q = basis_.transpose() * (p - o_) / size_;
        rows.row(i) << q.transpose(), 1;
        squares[i] = q.squaredNorm();
    }
    const MatrixXd normal = rows.transpose() * rows / static_cast<double>(count);
    const Eigen::SelfAdjointEigenSolver<MatrixXd> spectrum(normal);
    if (!(spectrum.eigenvalues()[0] > 1e-14 * spectrum.eigenvalues()[d]))
        throw InvalidInput(text(name_, ": the points lie on a ", cuts_ ? "line" : "plane", ": no radius"));
    const auto solver = normal.ldlt();
    const Row x = solver.solve(rows.transpose() * squares / static_cast<double>(count));
    const double r2 = x[d] + 0.25 * x.head(d).squaredNorm();
    const double r = std::sqrt(r2);
    if (!dr_dv) return size_ * r;
    Row by_x(d + 1);
    by_x << x.head(d) / (4 * r), 1 / (2 * r);
    const Row y = solver.solve(by_x);
    *dr_dv = Points::Zero(mesh.num_vertices(), 3);
    for (Eigen::Index i = 0; i < count; ++i) {
        const Row a = rows.row(i);
        const double off = squares[i] - a.dot(x);
        const Row by_q = (off * y.head(d) + y.dot(a) * (2 * a.head(d) - x.head(d))) / static_cast<double>(count);
        Vector3d by_p = basis_ * by_q;
        const Place& place = places_[static_cast<std::size_t>(i)];
        if (cuts_) {
            const Vector3d e = mesh.vertices.row(place.b) - mesh.vertices.row(place.a);
            by_p -= n_ * (e.dot(by_p) / n_.dot(e));
        }
        dr_dv->row(place.a) += (1 - ts[i]) * by_p;
        dr_dv->row(place.b) += ts[i] * by_p;
    }
    return size_ * r;
}

}  // namespace

Quantity edge_radius(const std::string& name, const TriMesh& start, const std::vector<char>& region,
                     const std::optional<SectionPlane>& plane) {
    if (const auto failure = vertices_finite(name, start)) throw InvalidInput(failure->message);
    const Fit fit(name, start, region, plane);
    return checked_quantity(name, {name}, start, [=](const QuantityRequest& request) {
        Points dr_dv;
        const double r = fit.radius(request.surface, request.wants(0) ? &dr_dv : nullptr);
        return one_value(r, std::move(dr_dv));
    });
}

}  // namespace strake
