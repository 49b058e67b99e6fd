#include "core/planform/fuselage.hpp"

#include "core/error.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace strake {
namespace {

using Eigen::Vector3d;

constexpr double square_tolerance = 1e-6;  ///< of directions that must be perpendicular
constexpr double end_rel = 1e-6;           ///< of the length: vertices of nose and tail
constexpr double end_margin = 1e-3;        ///< of the length: planes stay so far inside
constexpr double plane_rel = 1e-4;         ///< of the length: a half ends at the plane

/// The middle between the lowest and the highest of some vertices.
Varying middle(const TriMesh& mesh, const std::vector<int>& vertices, const Vector3d& n, bool sensitivities) {
    const auto at = [&](int v) { return n.dot(mesh.vertices.row(v)); };
    const auto [low, high] =
        std::minmax_element(vertices.begin(), vertices.end(), [&](int a, int b) { return at(a) < at(b); });
    return 0.5 * (component(mesh, *low, n, sensitivities) + component(mesh, *high, n, sensitivities));
}

Varying mean(const TriMesh& mesh, const std::vector<int>& vertices, const Vector3d& n, bool sensitivities) {
    std::vector<Varying> terms;
    for (const int v : vertices) terms.push_back(component(mesh, v, n, sensitivities));
    return (1.0 / static_cast<double>(vertices.size())) * sum(terms);
}

std::vector<std::pair<double, double>> drawn(const Outline& outline) {
    std::vector<std::pair<double, double>> points;
    for (const PlanePoint& p : outline.points) points.emplace_back(p.x.value, p.z.value);
    if (outline.is_closed) points.push_back(points.front());
    return points;
}

void check(const FuselageDeclaration& declared) {
    const auto refuse = [&](const std::string& why) { throw InvalidInput(text("body '", declared.name, "': ", why)); };
    for (const Vector3d& d : {declared.axis, declared.up})
        if (!d.allFinite() || std::abs(d.norm() - 1) > square_tolerance) refuse("directions must be unit vectors");
    if (std::abs(declared.axis.dot(declared.up)) > square_tolerance)
        refuse("its length and up must be perpendicular; choose another direction of the length, or state axes");
    if (declared.stations.empty()) refuse("it has no stations");
    for (std::size_t i = 0; i < declared.stations.size(); ++i) {
        const double s = declared.stations[i];
        if (!(s >= 0 && s <= 1) || (i > 0 && !(s > declared.stations[i - 1])))
            refuse(text("stations[", i, "] = ", s, " must be in [0, 1] and above the one before"));
    }
}

}  // namespace

Fuselage::Fuselage(const TriMesh& start, const FuselageDeclaration& declaration) : declared_(declaration) {
    check(declared_);
    declared_.triangles = part_of(start, std::move(declared_.triangles), text("body '", declared_.name, "'"));
    std::vector<int> vertices;
    for (const int t : declared_.triangles)
        for (const int v : start.triangles.row(t)) vertices.push_back(v);
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    double low = std::numeric_limits<double>::infinity(), high = -low, left = low, right = high;
    for (const int v : vertices) {
        const Vector3d x = start.vertices.row(v);
        low = std::min(low, declared_.axis.dot(x)), high = std::max(high, declared_.axis.dot(x));
        left = std::min(left, across().dot(x)), right = std::max(right, across().dot(x));
    }
    if (!(high > low)) throw InvalidInput(text("body '", declared_.name, "' has no extent along its length"));
    const double slack = end_rel * (high - low);
    for (const int v : vertices) {
        const double x = declared_.axis.dot(start.vertices.row(v));
        if (x <= low + slack) nose_.push_back(v);
        if (x >= high - slack) tail_.push_back(v);
    }
    if (declared_.symmetry && std::abs(declared_.symmetry->normal.dot(across())) > 1 - square_tolerance) {
        plane_ = declared_.symmetry->offset * declared_.symmetry->normal.dot(across());
        const auto ends_at_plane = [&](double at) { return std::abs(at - plane_) <= plane_rel * (high - low); };
        if (ends_at_plane(left) != ends_at_plane(right)) half_ = ends_at_plane(left) ? 1 : -1;
    }
    for (const double s : declared_.stations) station(start, s);
}

double Fuselage::nose(const TriMesh& surface) const { return ends(surface, false).nose.value; }

Fuselage::Ends Fuselage::ends(const TriMesh& surface, bool sensitivities) const {
    return {mean(surface, nose_, declared_.axis, sensitivities), mean(surface, tail_, declared_.axis, sensitivities),
            middle(surface, nose_, declared_.up, sensitivities), middle(surface, tail_, declared_.up, sensitivities)};
}

Varying Fuselage::length(const TriMesh& surface, bool sensitivities) const {
    const Ends at = ends(surface, sensitivities);
    return at.tail - at.nose;
}

FuselageStation Fuselage::station(const TriMesh& surface, double station, bool sensitivities) const {
    const Ends at = ends(surface, sensitivities);
    const Varying length = at.tail - at.nose;
    const double s = std::clamp(station, end_margin, 1 - end_margin);
    const SectionFrame frame{declared_.axis, across(), declared_.up, at.nose + s * length};
    const std::vector<Outline> outlines = cut(surface, declared_.triangles, frame, {sensitivities, 0});
    const PlanePoint *left = nullptr, *right = nullptr, *low = nullptr, *high = nullptr;
    FuselageStation found;
    for (const Outline& outline : outlines) {
        found.outline.push_back(drawn(outline));
        for (const PlanePoint& p : outline.points) {
            if (!left || p.x.value < left->x.value) left = &p;
            if (!right || p.x.value > right->x.value) right = &p;
            if (!low || p.z.value < low->z.value) low = &p;
            if (!high || p.z.value > high->z.value) high = &p;
        }
    }
    if (!left)
        throw InvalidInput(text("body '", declared_.name, "' has no section at ", 100 * station, " % of its length"));
    found.width = half_ > 0 ? 2 * (right->x - plane_) : half_ < 0 ? 2 * (plane_ - left->x) : right->x - left->x;
    found.across = half_ != 0 ? Varying(plane_) : 0.5 * (left->x + right->x);
    found.height = high->z - low->z;
    found.up = 0.5 * (high->z + low->z);
    found.camber = (found.up - ((1 - s) * at.nose_height + s * at.tail_height)) / length;
    return found;
}

}  // namespace strake
