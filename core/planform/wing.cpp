#include "core/planform/wing.hpp"

#include "core/error.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace strake {
namespace {

using Eigen::Vector3d;

constexpr double inside_rel = 1e-9;  ///< of the semispan: planes at the ends cut what lies inside of them
constexpr double tip_rel = 1e-6;     ///< of the semispan: vertices of a tip that is cut straight
constexpr double join_rel = 2e-3;    ///< of the semispan: cracks

/// Two points a panel of Gauss's rule on [0, 1]: even panels up to 90 %, then finer towards the tip, where a rounded
/// wing's chord falls like a square root.
std::vector<std::pair<double, double>> quadrature() {
    std::vector<double> ends;
    for (int i = 0; i <= 36; ++i) ends.push_back(0.9 * i / 36);
    for (int i = 1; i <= 12; ++i) ends.push_back(1 - 0.1 * std::pow(1 - i / 12.0, 2));
    std::vector<std::pair<double, double>> points;
    for (std::size_t i = 0; i + 1 < ends.size(); ++i)
        for (const double x : {-1 / std::sqrt(3.0), 1 / std::sqrt(3.0)})
            points.emplace_back(0.5 * (ends[i] + ends[i + 1]) + 0.5 * x * (ends[i + 1] - ends[i]),
                                0.5 * (ends[i + 1] - ends[i]));
    return points;
}

}  // namespace

std::vector<int> outermost(const Points& positions, const std::vector<int>& vertices, const Vector3d& n, double scale) {
    const Eigen::VectorXd height = positions * n;
    const double top = height.maxCoeff();
    std::vector<int> found;
    for (std::size_t i = 0; i < vertices.size(); ++i)
        if (height[static_cast<Eigen::Index>(i)] >= top - tip_rel * scale) found.push_back(vertices[i]);
    return found;
}

bool Wing::has_winglet() const { return !sides_.front().nodes.empty(); }

double Wing::semispan(const TriMesh& mesh) const { return plane(mesh, sides_.front(), 0, false).reach.value; }

double Wing::place_of(const Side& side, double station) { return station == 1 ? side.last : station; }

Wing::Side::Between Wing::Side::nodes_at(double fraction) const {
    std::size_t k = 1;
    while (k + 1 < nodes.size() && nodes[k].station < fraction) ++k;
    const Node &a = nodes[k - 1], &b = nodes[k];
    return {a, b, std::clamp((fraction - a.station) / (b.station - a.station), 0.0, 1.0)};
}

Wing::Plane Wing::plane(const TriMesh& surface, const Side& side, double place, bool sensitivities) const {
    const Vector3d& e = side.span;
    Plane result;
    result.frame = {e, declared_.downstream, declared_.up, 0};
    const double fraction = std::max(place, inside_rel);
    const bool has_nodes = !side.nodes.empty();
    if (has_nodes) {
        const auto [a, b, t] = side.nodes_at(fraction);
        const double angle = a.angle + t * (b.angle - a.angle);
        result.frame.normal = std::cos(angle) * e + std::sin(angle) * declared_.up;
        result.frame.up = -std::sin(angle) * e + std::cos(angle) * declared_.up;
        result.near = a.axis + t * (b.axis - a.axis);
    }
    const Vector3d& n = result.frame.normal;
    const std::vector<int> tip = has_nodes ? outermost(side.start, side.vertices, n, side.scale) : side.tip;
    const double share = 1.0 / static_cast<double>(tip.size()), root = n.dot(side.root_point);
    std::vector<Varying> heights;
    for (const int v : tip) heights.push_back(share * component(surface, v, n, sensitivities));
    result.length = result.reach = sum(heights) - root;
    if (!has_nodes) {
        result.frame.offset = root + fraction * result.reach;
    } else if (declared_.rules == WingRules::latest) {
        follow(surface, side, fraction, sensitivities, result);
    } else {
        double reach = -root;
        for (const int v : tip) {
            const auto row = std::lower_bound(side.vertices.begin(), side.vertices.end(), v) - side.vertices.begin();
            reach += n.dot(side.start.row(row)) / static_cast<double>(tip.size());
        }
        result.stretch = side.length / reach;
        result.frame.offset = root + n.dot(*result.near - side.root_point) / reach * result.reach;
    }
    return result;
}

/// How far the section's edges have gone along a direction.
Varying Wing::Node::gone(const TriMesh& surface, const Vector3d& way, bool sensitivities) const {
    std::vector<Varying> terms;
    for (const auto& [v, share] : middle) terms.push_back(share * component(surface, v, way, sensitivities));
    return sum(terms) - way.dot(middle_at);
}

/// Takes the plane of a wing with winglet, as it lies at the start, to where the edges of its section have gone.
void Wing::follow(const TriMesh& surface, const Side& side, double fraction, bool sensitivities, Plane& plane) const {
    const auto [a, b, t] = side.nodes_at(fraction);
    const Vector3d axis = *plane.near;
    const auto at = [&, &a = a, &b = b, t = t](const Vector3d& way) {
        return way.dot(axis) + (1 - t) * a.gone(surface, way, sensitivities) + t * b.gone(surface, way, sensitivities);
    };
    plane.length = (1 / (b.station - a.station)) * step(surface, side, a, b, sensitivities);
    plane.frame.offset = at(plane.frame.normal);
    Vector3d now = Vector3d::Zero();
    for (const Vector3d& way : {side.span, declared_.downstream, declared_.up}) now += at(way).value * way;
    plane.near = now;
}

/// Distance of two nodes seen from the front.
Varying Wing::step(const TriMesh& surface, const Side& side, const Node& a, const Node& b, bool sensitivities) const {
    const auto way = [&](const Vector3d& d) {
        return d.dot(b.axis - a.axis) + b.gone(surface, d, sensitivities) - a.gone(surface, d, sensitivities);
    };
    const Varying out = way(side.span), rise = way(declared_.up);
    return sqrt(out * out + rise * rise);
}

namespace {

/// With winglets: the outline at the point; others belong to other parts of the wing that the plane meets.
void keep_nearest(std::vector<Outline>& outlines, const SectionFrame& frame, const Vector3d& near) {
    const double x = frame.downstream.dot(near), z = frame.up.dot(near);
    double best = std::numeric_limits<double>::infinity();
    std::size_t kept = 0;
    for (std::size_t o = 0; o < outlines.size(); ++o) {
        double low = std::numeric_limits<double>::infinity(), high = -low, sum = 0;
        for (const PlanePoint& p : outlines[o].points) {
            low = std::min(low, p.x.value), high = std::max(high, p.x.value);
            sum += p.z.value;
        }
        const double middle = sum / static_cast<double>(outlines[o].points.size());
        const double off = std::hypot(0.5 * (low + high) - x, middle - z);
        if (off < best) best = off, kept = o;
    }
    if (!outlines.empty()) outlines = {outlines[kept]};
}

}  // namespace

std::vector<Outline> Wing::outlines(const TriMesh& surface, const Side& side, const Plane& plane, bool sensitivities,
                                    const std::vector<int>* triangles) const {
    std::vector<Outline> found =
        cut(surface, triangles ? *triangles : side.triangles, plane.frame, {sensitivities, join_rel * side.scale});
    if (plane.near) keep_nearest(found, plane.frame, *plane.near);
    return found;
}

std::optional<Airfoil> Wing::section(const TriMesh& surface, const Side& side, const Plane& plane, bool sensitivities,
                                     const std::vector<int>* triangles) const {
    return Airfoil::from(outlines(surface, side, plane, sensitivities, triangles), corner_of_noses());
}

std::optional<Airfoil> Wing::section(const TriMesh& surface, const Side& side, double place, bool sensitivities) const {
    return section(surface, side, plane(surface, side, place, sensitivities), sensitivities);
}

Airfoil Wing::needed(const TriMesh& surface, const Side& side, double place, bool sensitivities) const {
    auto found = section(surface, side, place, sensitivities);
    if (!found)
        throw InvalidInput(text("wing '", declared_.name, "' has no section at ", 100 * place, " % of its semispan"));
    return std::move(*found);
}

std::vector<Airfoil> Wing::sections(const TriMesh& surface, double station, bool sensitivities) const {
    std::vector<Airfoil> found;
    for (const Side& side : sides_) found.push_back(needed(surface, side, place_of(side, station), sensitivities));
    return found;
}

Eigen::Vector3d Wing::in_space(const Plane& plane, const PlanePoint& point) {
    return plane.frame.offset.value * plane.frame.normal + point.x.value * plane.frame.downstream +
           point.z.value * plane.frame.up;
}

std::vector<Wing::PlacedSection> Wing::placed_sections(const TriMesh& surface, double station) const {
    std::vector<PlacedSection> found;
    for (const Side& side : sides_) {
        const double place = place_of(side, station);
        const Plane at = plane(surface, side, place, false);
        Airfoil airfoil = needed(surface, side, place, false);
        const Vector3d leading = in_space(at, airfoil.leading_edge()), trailing = in_space(at, airfoil.trailing_edge());
        found.push_back({std::move(airfoil), leading, trailing});
    }
    return found;
}

std::optional<Wing::Edges> Wing::edges(const TriMesh& surface, const TriMesh& planes_of, int number, double place,
                                       bool sensitivities, const std::vector<int>* triangles) const {
    const Plane at = plane(planes_of, this->at(number), place, false);
    const auto airfoil = section(surface, this->at(number), at, sensitivities, triangles);
    if (!airfoil) return {};
    return Edges{airfoil->leading_edge(),
                 airfoil->trailing_edge(),
                 at.frame.normal,
                 at.frame.up,
                 in_space(at, airfoil->leading_edge()),
                 in_space(at, airfoil->trailing_edge()),
                 airfoil->num_nose_points(),
                 airfoil->nose_turning()};
}

Vector3d Wing::up_at(int number, double place) const {
    const Side& side = at(number);
    if (side.nodes.empty()) return declared_.up;
    const auto [a, b, t] = side.nodes_at(place);
    const double angle = a.angle + t * (b.angle - a.angle);
    return -std::sin(angle) * side.span + std::cos(angle) * declared_.up;
}

StationFacts Wing::station(const TriMesh& surface, double station, bool sensitivities) const {
    StationFacts facts;
    facts.station = station;
    const double share = 1.0 / num_sides();
    Varying radius;
    bool has_radius = true;
    for (std::size_t s = 0; s < sides_.size(); ++s) {
        const Side& side = sides_[s];
        const Plane at = plane(surface, side, place_of(side, station), sensitivities);
        const Airfoil airfoil = needed(surface, side, place_of(side, station), sensitivities);
        facts.chord = facts.chord + share * airfoil.chord();
        facts.twist = facts.twist + share * airfoil.twist();
        facts.leading_x = facts.leading_x + share * airfoil.leading_edge().x;
        facts.trailing_x = facts.trailing_x + share * airfoil.trailing_edge().x;
        facts.thickness_to_chord = facts.thickness_to_chord + share * airfoil.max_thickness();
        facts.camber = facts.camber + share * airfoil.max_camber();
        facts.trailing_edge_angle = facts.trailing_edge_angle + share * airfoil.trailing_edge_angle();
        facts.trailing_edge_thickness = facts.trailing_edge_thickness + share * airfoil.trailing_edge_thickness();
        const auto one = airfoil.leading_edge_radius();
        has_radius = has_radius && one;
        if (has_radius) radius = radius + share * *one;
        if (s > 0) continue;
        facts.leading_edge = in_space(at, airfoil.leading_edge());
        facts.trailing_edge = in_space(at, airfoil.trailing_edge());
        facts.thickness_at = airfoil.max_thickness_at();
        facts.camber_at = airfoil.max_camber_at();
        facts.outline = airfoil.in_chords();
    }
    if (has_radius) facts.leading_edge_radius = radius;
    return facts;
}

namespace {

/// Sums over all sides while sections are visited.
struct Sums {
    std::vector<Varying> area, square;     ///< weights times chord, chord^2
    std::vector<Varying> weight, y, x, z;  ///< of the axis, streamwise planes only
    std::vector<double> fit;               ///< weights of the lines
};

/// Slope of the straight line through values over y, by least squares.
Varying slope_of(const std::vector<Varying>& values, const std::vector<Varying>& y, const std::vector<double>& weight) {
    double total = 0;
    for (const double w : weight) total += w;
    const auto mean = [&](const std::vector<Varying>& of) {
        std::vector<Varying> terms;
        for (std::size_t i = 0; i < of.size(); ++i) terms.push_back((weight[i] / total) * of[i]);
        return sum(terms);
    };
    const Varying y0 = mean(y);
    std::vector<Varying> products, squares;
    for (std::size_t i = 0; i < y.size(); ++i) {
        const Varying arm = y[i] - y0;
        products.push_back(weight[i] * (arm * values[i]));
        squares.push_back(weight[i] * (arm * arm));
    }
    return sum(products) / sum(squares);
}

}  // namespace

/// A share of the exposed semispan.
Varying Wing::length_of(const TriMesh& surface, const Side& side, const Plane& root, double share,
                        bool sensitivities) const {
    if (!follows()) return share * root.stretch * root.length;
    std::vector<Varying> steps;
    for (std::size_t k = 1; k < side.nodes.size(); ++k)
        steps.push_back(share * step(surface, side, side.nodes[k - 1], side.nodes[k], sensitivities));
    return sum(steps);
}

WingFacts Wing::facts(const TriMesh& surface, bool sensitivities) const {
    static const std::vector<std::pair<double, double>> points = quadrature();
    Varying area, square, exposed, across, sweep, dihedral;
    const double share = 1.0 / num_sides();
    for (const Side& side : sides_) {
        Sums sums;
        for (const auto& [place, weight] : points) {
            const Plane at = plane(surface, side, place, sensitivities);
            const auto airfoil = section(surface, side, at, sensitivities);
            if (!airfoil && place > side.last) continue;  // beside a tip that is not normal to the span
            if (!airfoil)
                throw InvalidInput(
                    text("wing '", declared_.name, "' has no section at ", 100 * place, " % of its semispan"));
            const Varying length = (weight * at.stretch) * at.length;
            sums.area.push_back(length * airfoil->chord());
            sums.square.push_back(length * airfoil->chord() * airfoil->chord());
            if (at.frame.normal != side.span || place > side.last) continue;
            const PlanePoint axis =
                airfoil->leading_edge() + declared_.axis * (airfoil->trailing_edge() - airfoil->leading_edge());
            sums.fit.push_back(weight);
            sums.y.push_back(at.frame.offset);
            sums.x.push_back(axis.x);
            sums.z.push_back(axis.z);
        }
        area = area + sum(sums.area);
        square = square + sum(sums.square);
        sweep = sweep + share * atan2(slope_of(sums.x, sums.y, sums.fit), 1);
        dihedral = dihedral + share * atan2(slope_of(sums.z, sums.y, sums.fit), 1);
        const Plane root = plane(surface, side, 0, sensitivities);
        exposed = exposed + length_of(surface, side, root, share, sensitivities);
        // The tips move; root and plane of symmetry do not.
        across =
            across + (2 * share) *
                         (root.reach +
                          (keeps_centre_ ? side.root - (side.span.dot(declared_.span) > 0 ? centre_ : -centre_) : 0.0));
    }
    WingFacts facts;
    facts.span = across;
    facts.area = (2.0 / num_sides()) * area;
    facts.aspect_ratio = 4.0 * exposed * exposed / facts.area;
    facts.sweep = sweep;
    facts.dihedral = dihedral;
    facts.mean_chord = square / area;
    Varying first, last;
    for (const Airfoil& airfoil : sections(surface, 0, sensitivities)) first = first + airfoil.chord();
    for (const Airfoil& airfoil : sections(surface, 1, sensitivities)) last = last + airfoil.chord();
    facts.taper = last / first;
    return facts;
}

Varying Wing::volume(const TriMesh& surface, std::pair<double, double> chord, std::pair<double, double> span,
                     bool sensitivities) const {
    constexpr int panels = 16;
    std::vector<Varying> terms;
    for (const Side& side : sides_) {
        const double from = place_of(side, span.first), to = place_of(side, span.second);
        for (int i = 0; i < panels; ++i)
            for (const double x : {-1 / std::sqrt(3.0), 1 / std::sqrt(3.0)}) {
                const double place = from + (to - from) * (i + 0.5 + 0.5 * x) / panels;
                const Plane at = plane(surface, side, place, sensitivities);
                const auto airfoil = section(surface, side, at, sensitivities);
                if (!airfoil)
                    throw InvalidInput(
                        text("wing '", declared_.name, "' has no section at ", 100 * place, " % of its semispan"));
                terms.push_back((0.5 * (to - from) / panels * at.stretch) * at.length *
                                airfoil->area(chord.first, chord.second));
            }
    }
    return (2.0 / num_sides()) * sum(terms);
}

}  // namespace strake
