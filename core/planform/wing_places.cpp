#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "core/planform/wing.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

/// Where points lie in a wing, and the regions that follow from it.
namespace strake {
namespace {

using Eigen::Vector3d;

constexpr int num_rows = 120;       ///< sections between which the edges are straight
constexpr double end_slack = 1e-6;  ///< of semispan and chord: ends are included

struct Row {
    double place;
    Vector3d lead, trail;
};

double interpolated(const std::vector<Row>& rows, double place, const Vector3d& x, const Vector3d& downstream) {
    std::size_t k = 1;
    while (k + 1 < rows.size() && rows[k].place < place) ++k;
    const Row &a = rows[k - 1], &b = rows[k];
    const double t = std::clamp((place - a.place) / (b.place - a.place), 0.0, 1.0);
    const Vector3d lead = a.lead + t * (b.lead - a.lead), trail = a.trail + t * (b.trail - a.trail);
    const double chord = downstream.dot(trail - lead);
    return chord > 0 ? downstream.dot(x - lead) / chord : 0.5;
}

}  // namespace

/// Fraction of the semispan at a point; with a winglet that of the nearest point of the line seen from the front.
double Wing::along(const Side& side, double reach, const Vector3d& x) const {
    if (side.nodes.empty()) return (side.span.dot(x) - side.root) / reach;
    const auto flat = [&](const Vector3d& p) { return Eigen::Vector2d(side.span.dot(p), declared_.up.dot(p)); };
    double least = std::numeric_limits<double>::infinity(), place = 0;
    for (std::size_t k = 1; k < side.nodes.size(); ++k) {
        const Node &a = side.nodes[k - 1], &b = side.nodes[k];
        const Eigen::Vector2d way = flat(b.axis - a.axis), from = flat(x - a.axis);
        const double raw = from.dot(way) / way.squaredNorm();
        const double t = std::clamp(raw, k == 1 ? raw : 0.0, k + 1 == side.nodes.size() ? raw : 1.0);
        const double off = (from - t * way).norm();
        if (off < least) least = off, place = a.station + t * (b.station - a.station);
    }
    return place;
}

std::vector<Wing::Place> Wing::places(const TriMesh& surface) const {
    std::vector<std::vector<Row>> rows;
    for (const Side& side : sides_) {
        auto& own = rows.emplace_back();
        for (int i = 0; i <= num_rows; ++i) {
            const double place = side.last * i / num_rows;
            const Plane at = plane(surface, side, place, false);
            if (const auto airfoil = section(surface, side, at, false))
                own.push_back({place, in_space(at, airfoil->leading_edge()), in_space(at, airfoil->trailing_edge())});
        }
        if (own.size() < 2) throw InvalidInput(text("wing '", declared_.name, "' has no sections along its span"));
    }
    std::vector<double> reach;
    for (const Side& side : sides_) reach.push_back(plane(surface, side, 0, false).reach.value);
    std::vector<Place> found(static_cast<std::size_t>(surface.num_vertices()));
    for (int v = 0; v < surface.num_vertices(); ++v) {
        const Vector3d x = surface.vertices.row(v);
        int s = 0;
        if (sides_.size() > 1 && declared_.span.dot(x) < centre_) s = 1;
        const Side& side = sides_[static_cast<std::size_t>(s)];
        const double place = along(side, reach[static_cast<std::size_t>(s)], x);
        found[static_cast<std::size_t>(v)] = {
            s, place, interpolated(rows[static_cast<std::size_t>(s)], place, x, declared_.downstream)};
    }
    return found;
}

std::vector<char> Wing::region(const TriMesh& surface, std::pair<double, double> chord, std::pair<double, double> span,
                               int side) const {
    const std::vector<Place> place = places(surface);
    // What lies before the leading edge of the table belongs to a range that begins there; likewise at all ends.
    const auto within = [](double x, const std::pair<double, double>& range) {
        return (range.first <= 0 || x >= range.first - end_slack) &&
               (range.second >= 1 || x <= range.second + end_slack);
    };
    const Points normal = triangle_normals(surface);
    std::vector<char> marks(static_cast<std::size_t>(surface.num_triangles()), 0);
    for (const int t : declared_.triangles) {
        bool inside = side == 0 || side * normal.row(t).dot(declared_.up.transpose()) > 0;
        for (const int v : surface.triangles.row(t)) {
            const Place& at = place[static_cast<std::size_t>(v)];
            inside = inside && within(at.span, span) && within(at.chord, chord);
        }
        marks[static_cast<std::size_t>(t)] = inside;
    }
    return marks;
}

}  // namespace strake
