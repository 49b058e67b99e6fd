#include "core/fields/typical_motions.hpp"

#include "core/error.hpp"
#include "core/mesh/closest_point.hpp"
#include "core/mesh/geometry.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <functional>

namespace strake {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int num_slices = 16;
constexpr double nearly_all_held = 0.5;  ///< of the length
constexpr double bump_radius = 0.15;     ///< diagonals
constexpr double nothing_left = 0.1;     ///< of a motion, by what the kind of shape allows

/// Where every vertex is, in terms of the sections.
struct Places {
    FieldFrame frame;
    VectorXd s, t;  ///< place in [-1, 1]; distance from what is held in [0, 1]
    VectorXd side;  ///< in [-1, 1]: to which side of what is held; +-1 where that cuts the body in two
    Points arm;     ///< from the middle of its section
    bool is_held = false;
};

std::vector<char> held_vertices(const TriMesh& rest, const std::vector<int>& held) {
    std::vector<char> is_held(static_cast<std::size_t>(rest.num_vertices()), 0);
    for (const int t : held)
        for (int k = 0; k < 3; ++k) is_held[static_cast<std::size_t>(rest.triangles(t, k))] = 1;
    return is_held;
}

/// Distance along the axis from what is held, or in space where that leaves little of the length.
void set_distances(const TriMesh& rest, const std::vector<int>& held, Places& places) {
    const std::vector<char> is_held = held_vertices(rest, held);
    double low = 2, high = -2;
    for (int v = 0; v < rest.num_vertices(); ++v)
        if (is_held[static_cast<std::size_t>(v)]) low = std::min(low, places.s[v]), high = std::max(high, places.s[v]);
    const double length = places.s.maxCoeff() - places.s.minCoeff();
    TriMesh part = rest;
    part.triangles.resize(static_cast<Eigen::Index>(held.size()), 3);
    for (std::size_t i = 0; i < held.size(); ++i)
        part.triangles.row(static_cast<Eigen::Index>(i)) = rest.triangles.row(held[i]);
    const bool in_space = high - low > nearly_all_held * length;
    const ClosestPointTree closest(part);
    const double middle = 0.5 * (low + high);
    const double reach = std::max(places.s.maxCoeff() - middle, middle - places.s.minCoeff());
    for (int v = 0; v < rest.num_vertices(); ++v) {
        // Beside what is held, what moves away to both sides must not be torn.
        places.side[v] = in_space ? (places.s[v] - middle) / reach : places.s[v] < middle ? -1 : 1;
        places.t[v] = is_held[static_cast<std::size_t>(v)] ? 0
                      : in_space                           ? closest.find(rest.vertices.row(v)).distance
                                                           : std::max({0.0, places.s[v] - high, low - places.s[v]});
    }
    const double largest = places.t.maxCoeff();
    if (!(largest > 0)) throw InvalidInput("typical motions: all of the surface is held");
    places.t /= largest;
}

/// From the polygon through the mean places of slices, by area.
void set_arms(const TriMesh& rest, bool is_half, Places& places) {
    const VectorXd area = vertex_areas(rest);
    const double low = places.s.minCoeff(), step = (places.s.maxCoeff() - low) / num_slices;
    Points sum = Points::Zero(num_slices, 3);
    VectorXd weight = VectorXd::Zero(num_slices);
    for (int v = 0; v < rest.num_vertices(); ++v) {
        const int slice = std::clamp(static_cast<int>((places.s[v] - low) / step), 0, num_slices - 1);
        sum.row(slice) += area[v] * rest.vertices.row(v);
        weight[slice] += area[v];
    }
    std::vector<double> at;
    std::vector<Vector3d> middle;
    for (int i = 0; i < num_slices; ++i) {
        if (!(weight[i] > 0)) continue;
        Vector3d x = sum.row(i) / weight[i];
        const int plane = places.frame.plane_axis;
        if (is_half && plane > 0) {  // the whole's middle lies on the plane
            const Vector3d n = places.frame.axes.col(plane);
            x += (places.frame.middle[plane] - n.dot(x)) * n;
        }
        at.push_back(places.frame.local(x)[0]);
        middle.push_back(x);
    }
    for (int v = 0; v < rest.num_vertices(); ++v) {
        std::size_t i = 1;
        while (i + 1 < at.size() && places.s[v] > at[i]) ++i;
        Vector3d center = middle.front();
        if (at.size() > 1) {
            const double share = (places.s[v] - at[i - 1]) / (at[i] - at[i - 1]);
            center = (1 - share) * middle[i - 1] + share * middle[i];
        }
        const Vector3d arm = Vector3d(rest.vertices.row(v)) - center, a = places.frame.axes.col(0);
        places.arm.row(v) = arm - arm.dot(a) * a;
    }
}

Places places_of(const TriMesh& rest, const FieldConditions& conditions, const std::optional<Vector3d>& axis) {
    const int n = rest.num_vertices();
    const auto& plane = conditions.cut ? conditions.cut : conditions.mirror;
    Places places{field_frame(rest, plane, conditions.cut.has_value(), axis, conditions.kind),
                  VectorXd(n),
                  VectorXd::Zero(n),
                  VectorXd::Ones(n),
                  Points(n, 3),
                  !conditions.held.empty()};
    for (int v = 0; v < n; ++v) places.s[v] = places.frame.local(rest.vertices.row(v))[0];
    if (places.is_held) set_distances(rest, conditions.held, places);
    set_arms(rest, conditions.cut.has_value(), places);
    return places;
}

/// Without its rigid part (by area).
Points without_rigid(const TriMesh& rest, const Points& u, const std::optional<SymmetryPlane>& plane) {
    const VectorXd weight = vertex_areas(rest).cwiseSqrt();
    const int n = rest.num_vertices();
    const std::vector<Points> motions = rigid_motions(rest, plane);
    Eigen::MatrixXd rigid(3 * n, static_cast<Eigen::Index>(motions.size()));
    for (std::size_t k = 0; k < motions.size(); ++k)
        for (int v = 0; v < n; ++v)
            rigid.block<3, 1>(3 * v, static_cast<Eigen::Index>(k)) = weight[v] * motions[k].row(v).transpose();
    VectorXd own(3 * n);
    for (int v = 0; v < n; ++v) own.segment<3>(3 * v) = weight[v] * u.row(v).transpose();
    const VectorXd share = rigid.completeOrthogonalDecomposition().solve(own);
    Points result = u;
    for (std::size_t k = 0; k < motions.size(); ++k) result -= share[static_cast<Eigen::Index>(k)] * motions[k];
    return result;
}

/// A smooth dent of the middle of what is free, and of its mirror image.
Points bump(const TriMesh& rest, const Places& places, const std::optional<SymmetryPlane>& plane) {
    const Points normal = triangle_normals(rest);
    Points at_vertex = Points::Zero(rest.num_vertices(), 3);
    const VectorXd area = triangle_areas(rest);
    for (int t = 0; t < rest.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k) at_vertex.row(rest.triangles(t, k)) += area[t] * normal.row(t);
    int best = 0;
    const Vector3d up = places.frame.axes.col(2);
    double least = 1e300;
    for (int v = 0; v < rest.num_vertices(); ++v) {
        const double off = std::abs(places.is_held ? places.t[v] - 0.5 : places.s[v]);
        const double lean = 1 - std::abs(at_vertex.row(v).normalized().dot(up));
        if (off + lean < least) least = off + lean, best = v;
    }
    const double radius = bump_radius * box_diagonal(rest);
    Points u = Points::Zero(rest.num_vertices(), 3);
    const auto raise = [&](const Vector3d& center, const Vector3d& direction) {
        for (int v = 0; v < rest.num_vertices(); ++v) {
            const double ratio = (Vector3d(rest.vertices.row(v)) - center).squaredNorm() / (radius * radius);
            const double facing = at_vertex.row(v).normalized().dot(direction);
            if (ratio < 1 && facing > 0 && !(places.is_held && places.t[v] == 0))
                u.row(v) += (1 - ratio) * (1 - ratio) * direction.transpose();
        }
    };
    const Vector3d center = rest.vertices.row(best), direction = at_vertex.row(best).normalized();
    raise(center, direction);
    if (plane)
        raise(center - 2 * (plane->normal.dot(center) - plane->offset) * plane->normal,
              direction - 2 * plane->normal.dot(direction) * plane->normal);
    return u;
}

}  // namespace

std::vector<Points> rigid_motions(const TriMesh& rest, const std::optional<SymmetryPlane>& plane) {
    std::vector<Points> all;
    const Vector3d middle = rest.vertices.colwise().mean();
    const Eigen::Matrix3d basis =
        plane ? Eigen::Matrix3d(Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitX(), plane->normal))
              : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
    for (int c = 0; c < 6; ++c) {
        if (plane && (c == 0 || c == 4 || c == 5)) continue;  // along the normal, and about axes in the plane
        const Vector3d axis = basis.col(c % 3);
        Points motion(rest.num_vertices(), 3);
        for (int v = 0; v < rest.num_vertices(); ++v)
            motion.row(v) = c < 3 ? axis : Vector3d(axis.cross(Vector3d(rest.vertices.row(v)) - middle));
        all.push_back(std::move(motion));
    }
    return all;
}

namespace {

/// The motions at a vertex, as functions of its place.
struct NamedMotion {
    const char* name;
    bool is_symmetric;  ///< allowed by the plane of symmetry
    std::function<Vector3d(int)> at;
};

std::vector<NamedMotion> motions_of_sections(const Places& at) {
    const Vector3d a = at.frame.axes.col(0), b = at.frame.axes.col(1), c = at.frame.axes.col(2);
    const int plane = at.frame.plane_axis;
    const bool is_held = at.is_held;
    const auto arm = [&at](int v) { return Vector3d(at.arm.row(v)); };
    const auto square = [&at](int v) { return at.s[v] * at.s[v]; };
    const auto first = [=, &at](int v) { return is_held ? at.t[v] : plane == 0 ? square(v) : at.s[v]; };
    const auto straight = [=, &at](int v) { return is_held ? at.t[v] : square(v); };
    const auto second = [=, &at](int v) { return is_held ? at.t[v] * at.t[v] : square(v); };
    const auto middle = [=, &at](int v) { return is_held ? 4 * at.t[v] * (1 - at.t[v]) : 1 - square(v); };
    const auto along = [=, &at](int v) { return is_held ? at.side[v] * at.t[v] : at.s[v]; };
    const auto flat = [=, &at](int v) { return is_held ? at.t[v] : 1.0; };
    return {{"bend", plane != 2, [=](int v) { return Vector3d(second(v) * c); }},
            {"sweep", plane != 1, [=](int v) { return Vector3d(straight(v) * b); }},
            {"span", true, [=](int v) { return Vector3d(along(v) * a); }},
            {"twist", plane < 1, [=](int v) { return Vector3d(first(v) * a.cross(arm(v))); }},
            {"taper", true, [=](int v) { return Vector3d(-first(v) * arm(v)); }},
            {"thicken", true, [=](int v) { return Vector3d(second(v) * arm(v).dot(c) * c); }},
            {"swell", true, [=](int v) { return Vector3d(middle(v) * arm(v)); }},
            {"flatten", true, [=](int v) { return Vector3d(flat(v) * (arm(v).dot(b) * b - arm(v).dot(c) * c)); }}};
}

}  // namespace

std::vector<TypicalMotion> typical_motions(const TriMesh& surface, const FieldConditions& conditions,
                                           const std::optional<Vector3d>& axis) {
    const TriMesh rest = with_loose_vertices_joined(surface);
    const Places at = places_of(rest, conditions, axis);
    const auto& plane = conditions.cut ? conditions.cut : conditions.mirror;
    std::optional<Invariance> invariance;
    if (conditions.kind) invariance.emplace(rest, *conditions.kind, 1e-6, conditions.cut);
    std::vector<TypicalMotion> all;
    const auto add = [&](const char* name, Points u) {
        const double whole = u.rowwise().norm().maxCoeff();
        if (invariance) u = invariance->projected(u);
        if (!at.is_held) u = without_rigid(rest, u, plane);
        const double size = u.rowwise().norm().maxCoeff();
        if (size > (invariance ? nothing_left : 1e-9) * whole) all.push_back({name, u / size});
    };
    for (const NamedMotion& motion : motions_of_sections(at)) {
        if (plane && !motion.is_symmetric) continue;
        Points u(rest.num_vertices(), 3);
        for (int v = 0; v < rest.num_vertices(); ++v) u.row(v) = motion.at(v);
        add(motion.name, std::move(u));
    }
    add("bump", bump(rest, at, plane));
    return all;
}

}  // namespace strake
