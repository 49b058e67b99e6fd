#include "optimize/evaluate/contacts.hpp"

#include "core/mesh/geometry.hpp"
#include "core/mesh/point_triangle.hpp"

#include <algorithm>

namespace strake {
namespace {

constexpr double touching_rel = 1e-5;  ///< of the diagonal

/// Distance of the segments from p along d and from q along e, by alternate projection onto the two, exact after the
/// clamps (Ericson, Real-Time Collision Detection, 5.1.9).
double segment_distance(const Eigen::Vector3d& p, const Eigen::Vector3d& d, const Eigen::Vector3d& q,
                        const Eigen::Vector3d& e) {
    const Eigen::Vector3d r = p - q;
    const double dd = d.squaredNorm(), ee = e.squaredNorm(), de = d.dot(e), er = e.dot(r), dr = d.dot(r);
    const auto clamped = [](double s) { return std::clamp(s, 0.0, 1.0); };
    const double det = dd * ee - de * de;
    double s = det > 0 ? clamped((de * er - dr * ee) / det) : 0;
    double t = ee > 0 ? (de * s + er) / ee : 0;
    if (t < 0 || t > 1 || !(ee > 0)) {
        t = clamped(t);
        s = dd > 0 ? clamped((t * de - dr) / dd) : 0;
    }
    return (r + s * d - t * e).norm();
}

}  // namespace

Contacts::Contacts(std::shared_ptr<const TriMesh> rest, const Adjacency& adjacent,
                   std::vector<std::array<int, 2>> intersecting)
    : rest_(std::move(rest)),
      touching_(touching_rel * box_diagonal(*rest_)),
      component_(edge_components(*rest_, adjacent)) {
    for (const auto& [s, t] : intersecting) {
        partners_[s].push_back(t);
        partners_[t].push_back(s);
        if (component_[s] != component_[t]) piercing_.insert(std::minmax(component_[s], component_[t]));
    }
    for (const auto& [t, others] : partners_)
        for (int k = 0; k < 3; ++k) at_vertex_[triangles()(t, k)].push_back(t);
}

bool Contacts::shares_vertex(int s, int t) const {
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            if (triangles()(s, i) == triangles()(t, j)) return true;
    return false;
}

bool Contacts::is_near(int s, int t) const {
    if (component_[s] != component_[t] && piercing_.contains(std::minmax(component_[s], component_[t]))) return true;
    for (int k = 0; k < 3; ++k) {
        const auto at = at_vertex_.find(triangles()(s, k));
        if (at == at_vertex_.end()) continue;
        for (const int beside : at->second)
            for (const int partner : partners_.at(beside))
                if (shares_vertex(partner, t)) return true;
    }
    return touches(s, t);
}

bool Contacts::touches(int s, int t) const {
    bool any_shared = false;
    const auto has_corner_at = [&](int triangle, int v) {
        for (int k = 0; k < 3; ++k)
            if (rest_->vertices.row(triangles()(triangle, k)) == rest_->vertices.row(v)) return true;
        return false;
    };
    for (const auto& [one, other] : {std::pair(s, t), std::pair(t, s)})
        for (int k = 0; k < 3; ++k) {
            const int v = triangles()(one, k);
            if (has_corner_at(other, v))
                any_shared = true;
            else if (corner_distance(v, other) <= touching_)
                return true;
        }
    return !any_shared && distance(s, t) <= touching_;
}

double Contacts::corner_distance(int v, int t) const {
    TriMesh one;
    one.triangles.resize(1, 3);
    one.triangles << 0, 1, 2;
    one.vertices.resize(3, 3);
    for (int k = 0; k < 3; ++k) one.vertices.row(k) = rest_->vertices.row(triangles()(t, k));
    return closest_point_on_triangle(one, 0, rest_->vertices.row(v)).distance;
}

double Contacts::distance(int s, int t) const {
    TriMesh pair;
    pair.triangles.resize(2, 3);
    pair.triangles << 0, 1, 2, 3, 4, 5;
    pair.vertices.resize(6, 3);
    for (int k = 0; k < 3; ++k) {
        pair.vertices.row(k) = rest_->vertices.row(triangles()(s, k));
        pair.vertices.row(3 + k) = rest_->vertices.row(triangles()(t, k));
    }
    const auto corner = [&](int k) -> Eigen::Vector3d { return pair.vertices.row(k); };
    double least = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 3; ++k) {
        least = std::min(least, closest_point_on_triangle(pair, 1, corner(k)).distance);
        least = std::min(least, closest_point_on_triangle(pair, 0, corner(3 + k)).distance);
        for (int l = 0; l < 3; ++l)
            least = std::min(least, segment_distance(corner(k), corner((k + 1) % 3) - corner(k), corner(3 + l),
                                                     corner(3 + (l + 1) % 3) - corner(3 + l)));
    }
    return least;
}

}  // namespace strake
