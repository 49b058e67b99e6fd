#include "objectives/aero/area_distribution.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "objectives/quantity/closed.hpp"
#include "objectives/quantity/finite.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace strake {
namespace {

using Eigen::Vector3d;

/// Share of a triangle where the linear function with values w at its corners is < c; derivatives by w.
struct Share {
    double f = 0;
    std::array<double, 3> by_w{};
};

/// @pre min w < c < max w.
Share share_below(const std::array<double, 3>& w, double c) {
    std::array<int, 3> order{0, 1, 2};
    std::sort(order.begin(), order.end(), [&](int a, int b) { return w[a] < w[b] || (w[a] == w[b] && a < b); });
    const auto [l, m, h] = order;
    Share s;
    const bool low = c < w[m];
    // A corner is cut off, its share is d^2 / (e1 e2). Seen from the other end of the order 1 - f and -w take the place
    // of f and w: the derivatives keep their form.
    const int tip = low ? l : h;
    const double sign = low ? 1 : -1;
    const double d = sign * (c - w[tip]), e1 = sign * (w[m] - w[tip]), e2 = std::abs(w[h] - w[l]);
    const double part = d * d / (e1 * e2);
    const int far = low ? h : l;
    s.by_w[m] = -part / e1;
    s.by_w[far] = -part / e2;
    s.by_w[tip] = part * (1 / e1 + 1 / e2) - 2 * d / (e1 * e2);
    s.f = low ? part : 1 - part;
    return s;
}

std::vector<double> places_of(const AreaCuts& cuts, double begin, double end) {
    std::vector<double> places;
    for (const double k : cuts.stations) places.push_back(begin + k * (end - begin));
    return places;
}

/// A triangle and the sections: `inside` cut it, those from `next` on lie behind it.
struct Against {
    Vector3d e, f;  ///< edges from the first corner to the others
    double a;       ///< - axis . s
    std::array<double, 3> w;
    std::size_t inside, next;
};

template <class Visit>
void for_each_triangle(const TriMesh& mesh, const AreaCuts& cuts, const Eigen::VectorXd& along,
                       const std::vector<double>& places, const Visit& visit) {
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        if (!cuts.excluded.empty() && cuts.excluded[t]) continue;
        const auto v = mesh.triangles.row(t);
        const Vector3d p = mesh.vertices.row(v[0]);
        const Vector3d e = Vector3d(mesh.vertices.row(v[1])) - p, f = Vector3d(mesh.vertices.row(v[2])) - p;
        Against at{e, f, -0.5 * cuts.axis.dot(e.cross(f)), {along[v[0]], along[v[1]], along[v[2]]}, 0, 0};
        const auto [low, high] = std::minmax({at.w[0], at.w[1], at.w[2]});
        const auto from = std::upper_bound(places.begin(), places.end(), low);
        at.inside = static_cast<std::size_t>(from - places.begin());
        at.next = static_cast<std::size_t>(std::lower_bound(from, places.end(), high) - places.begin());
        visit(t, at);
    }
}

}  // namespace

AreaDistribution area_distribution(const TriMesh& mesh, const AreaCuts& cuts) {
    AreaDistribution at;
    const Eigen::VectorXd along = mesh.vertices * cuts.m;
    at.begin = along.minCoeff(&at.first);
    at.end = along.maxCoeff(&at.last);
    const std::vector<double> places = places_of(cuts, at.begin, at.end);
    const auto count = static_cast<Eigen::Index>(places.size());
    at.area = at.by_position = Eigen::VectorXd::Zero(count);
    Eigen::VectorXd behind = Eigen::VectorXd::Zero(count + 1);  // whole triangles, by the first section behind them
    for_each_triangle(mesh, cuts, along, places, [&](int, const Against& triangle) {
        for (std::size_t i = triangle.inside; i < triangle.next; ++i) {
            const Share share = share_below(triangle.w, places[i]);
            const auto s = static_cast<Eigen::Index>(i);
            at.area[s] += triangle.a * share.f;
            at.by_position[s] -= triangle.a * (share.by_w[0] + share.by_w[1] + share.by_w[2]);
        }
        behind[static_cast<Eigen::Index>(triangle.next)] += triangle.a;
    });
    double sum = 0;
    for (Eigen::Index i = 0; i < count; ++i) at.area[i] += sum += behind[i];
    return at;
}

void add_area_gradient(const TriMesh& mesh, const AreaCuts& cuts, const AreaDistribution& at,
                       const Eigen::VectorXd& by_area, double by_begin, double by_end, Points& dJ_dv) {
    const Eigen::VectorXd along = mesh.vertices * cuts.m;
    const std::vector<double> places = places_of(cuts, at.begin, at.end);
    for (std::size_t i = 0; i < places.size(); ++i) {
        const double by_place = by_area[static_cast<Eigen::Index>(i)] * at.by_position[static_cast<Eigen::Index>(i)];
        by_begin += (1 - cuts.stations[i]) * by_place;
        by_end += cuts.stations[i] * by_place;
    }
    dJ_dv.row(at.first) += by_begin * cuts.m;
    dJ_dv.row(at.last) += by_end * cuts.m;
    Eigen::VectorXd later = Eigen::VectorXd::Zero(by_area.size() + 1);
    for (Eigen::Index i = by_area.size(); i-- > 0;) later[i] = later[i + 1] + by_area[i];
    for_each_triangle(mesh, cuts, along, places, [&](int t, const Against& triangle) {
        double by_a = later[static_cast<Eigen::Index>(triangle.next)];
        std::array<double, 3> by_w{};
        for (std::size_t i = triangle.inside; i < triangle.next; ++i) {
            const double g = by_area[static_cast<Eigen::Index>(i)];
            const Share share = share_below(triangle.w, places[i]);
            by_a += g * share.f;
            for (int k = 0; k < 3; ++k) by_w[k] += g * triangle.a * share.by_w[k];
        }
        if (triangle.inside == triangle.next && by_a == 0) return;
        const Vector3d turned = -0.5 * by_a * cuts.axis, by_e = triangle.f.cross(turned),
                       by_f = turned.cross(triangle.e);
        const auto v = mesh.triangles.row(t);
        dJ_dv.row(v[0]) += by_w[0] * cuts.m - by_e - by_f;
        dJ_dv.row(v[1]) += by_w[1] * cuts.m + by_e;
        dJ_dv.row(v[2]) += by_w[2] * cuts.m + by_f;
    });
}

Quantity section_areas(const std::string& name, const TriMesh& start, const Vector3d& direction, int count,
                       const std::optional<SymmetryPlane>& symmetry) {
    if (!direction.allFinite() || direction.isZero(0))
        throw InvalidInput(text(name, ": the direction (", direction.transpose(), ") must be finite and not zero"));
    if (count < 1 || count > 1000) throw InvalidInput(text(name, ": stations = ", count, " must be in [1, 1000]"));
    AreaCuts cuts;
    cuts.axis = cuts.m = direction.stableNormalized();
    require_along(name, "direction", direction, symmetry);
    if (const auto failure = vertices_finite(name, start)) throw InvalidInput(failure->message);
    require_closed(name, start, symmetry);
    const double V = enclosed_volume(start), d = box_diagonal(start);
    if (!symmetry && V < -1e-6 * d * d * d)
        throw InvalidInput(text(name, ": the surface is inside out (volume ", V, "); orient it outward"));
    std::vector<std::string> names;
    for (int i = 1; i <= count; ++i) {
        cuts.stations.push_back(static_cast<double>(i) / (count + 1));
        names.push_back(text(name, ".", i));
    }
    return checked_quantity(name, names, start, [=](const QuantityRequest& request) {
        const AreaDistribution at = area_distribution(request.surface, cuts);
        QuantityResult result;
        for (int i = 0; i < count; ++i) result.values.push_back(at.area[i]);
        if (request.want_sensitivities) result.dJ_dv.resize(static_cast<std::size_t>(count));
        for (int i = 0; i < count; ++i) {
            if (!request.wants(static_cast<std::size_t>(i))) continue;
            Points& dJ_dv = result.dJ_dv[static_cast<std::size_t>(i)];
            dJ_dv = Points::Zero(request.surface.num_vertices(), 3);
            add_area_gradient(request.surface, cuts, at, Eigen::VectorXd::Unit(count, i), 0, 0, dJ_dv);
        }
        return result;
    });
}

}  // namespace strake
