#include "core/error.hpp"
#include "core/planform/planform_motion.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

/// Where the vertices of wings lie between their stations, and the ranges of variables.
namespace strake {
namespace {

using Complex = std::complex<double>;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double same_station = 0.01;   ///< of the semispan: a kink beside a station is that station
constexpr double blunt_from = 5e-4;     ///< of the chord: thickness of a blunt trailing edge
constexpr double cambered_from = 5e-3;  ///< of the chord: height of a mean line that is more than rounding
constexpr int mean_line_terms = 6;      ///< a cubic mean line with room for two more humps
constexpr double min_share = -0.9;      ///< of span, chord, t/c: nothing is left below
constexpr int num_noses = 32;           ///< sections along the span whose noses are measured
constexpr double rounded_rows = 3;      ///< rows of vertices over which panels are rounded off
constexpr double max_rounding = 0.4;    ///< of a panel
constexpr double same_row = 0.02;       ///< of the distance of rows
constexpr double on_row = 1e-6;         ///< of the semispan

/// Mean line of the four-digit series, 1 at its top.
double four_digit_line(double xi) {
    constexpr double p = 0.4;
    if (xi < p) return (2 * p * xi - xi * xi) / (p * p);
    return (1 - 2 * p + 2 * p * xi - xi * xi) / ((1 - p) * (1 - p));
}

double mean_line(const VectorXd& factors, double xi) {
    double sum = 0, power = 1;
    for (const double factor : factors) sum += factor * power, power *= 2 * xi - 1;
    return xi * (1 - xi) * sum;
}

/// Where the plane meets elements of a wing; not in the gaps between them.
VectorXd fitted_mean_line(const Airfoil& airfoil) {
    constexpr int count = 24;
    std::vector<std::array<double, 2>> found;
    for (int i = 0; i < count; ++i) {
        const double xi = 0.5 * (1 - std::cos(std::numbers::pi * (i + 0.5) / count));
        try {
            const Airfoil::Heights at = airfoil.heights(xi);
            found.push_back({xi, 0.5 * (at.upper.value + at.lower.value) / airfoil.chord().value});
        } catch (const InvalidInput&) {
            continue;
        }
    }
    Eigen::MatrixXd terms(static_cast<Eigen::Index>(found.size()), mean_line_terms);
    VectorXd heights(terms.rows());
    for (Eigen::Index i = 0; i < terms.rows(); ++i) {
        const auto [xi, height] = found[static_cast<std::size_t>(i)];
        heights[i] = height;
        for (int k = 0; k < mean_line_terms; ++k) terms(i, k) = mean_line(VectorXd::Unit(k + 1, k), xi);
    }
    if (found.empty()) return VectorXd::Zero(mean_line_terms);
    return terms.colPivHouseholderQr().solve(heights);
}

/// Of the edges that cross the plane at a place: where they begin, how long they are, and the farthest end.
struct CutEdges {
    std::vector<double> inner, rows;
    double farthest = 0;
};

CutEdges cut_edges(const TriMesh& start, const Wing& wing, double reach, double place) {
    CutEdges found;
    for (const int t : wing.triangles(0))
        for (int c = 0; c < 3; ++c) {
            const auto at = [&](int corner) {
                const Vector3d x = start.vertices.row(start.triangles(t, corner % 3));
                return wing.fraction_at(0, reach, x);
            };
            const double from = std::min(at(c), at(c + 1)), to = std::max(at(c), at(c + 1));
            if (from > place - on_row || to < place + on_row) continue;
            found.inner.push_back(from);
            found.rows.push_back(to - from);
            found.farthest = std::max({found.farthest, place - from, to - place});
        }
    return found;
}

}  // namespace

PlanformMotion::PlanformMotion(const TriMesh& start, const std::vector<std::shared_ptr<const Wing>>& wings,
                               const std::vector<PlanformRange>& ranges,
                               const std::vector<std::shared_ptr<const Fuselage>>& bodies, StationCorners corners)
    : start_(start.vertices), triangles_(start.triangles), corners_(corners) {
    for (const auto& wing : wings) add_wing(start, wing);
    place_vertices(start);
    for (const auto& body : bodies) add_body(start, body);
    for (const PlanformRange& range : ranges) add(start, range);
}

PlanformMotion::Node PlanformMotion::node_at(const TriMesh& start, const Wing& wing, double station) const {
    const WingDeclaration& declared = wing.declaration();
    const std::vector<Wing::PlacedSection> sections = wing.placed_sections(start, station);
    const double share = 1.0 / static_cast<double>(sections.size());
    Node node{wing.place(0, station), 0, Vector3d::Zero(), VectorXd::Zero(mean_line_terms), {}, false};
    double blunt = 0;
    for (std::size_t s = 0; s < sections.size(); ++s) {
        const int side = static_cast<int>(s);
        const Airfoil& airfoil = sections[s].airfoil;
        const Vector3d up = wing.up_at(side, wing.place(side, station));
        const Vector3d& nose = sections[s].leading_edge;
        const Vector3d chord = sections[s].trailing_edge - nose, axis = nose + declared.axis * chord;
        node.chord += share * Complex(chord.dot(declared.downstream), chord.dot(up));
        node.axis += share * Vector3d(wing.span(side).dot(axis) - wing.root(side), declared.downstream.dot(axis),
                                      declared.up.dot(axis));
        node.mean_line += share * fitted_mean_line(airfoil);
        blunt += share * airfoil.trailing_edge_thickness().value / airfoil.chord().value;
    }
    double highest = 0;
    for (int i = 1; i < 100; ++i)
        if (const double height = mean_line(node.mean_line, i / 100.0); std::abs(height) > std::abs(highest))
            highest = height;
    if (std::abs(highest) > cambered_from) node.bump = node.mean_line / highest;
    node.is_blunt = blunt > blunt_from;
    return node;
}

/// The nodes are the wing's stations, the kinks of its edges, root and tip.
void PlanformMotion::add_wing(const TriMesh& start, const std::shared_ptr<const Wing>& wing) {
    WingDeclaration plain = wing->declaration();
    plain.stations.clear();
    std::vector<double> stations = wing->stations();
    std::vector<double> more = Wing(start, plain).stations();
    more.insert(more.begin(), {0.0, 1.0});
    for (const double kink : more)
        if (std::none_of(
                stations.begin(), stations.end(),
                [&](double s) { return std::abs(s - kink) < same_station && (kink == s || kink > 0) && kink < 1; }) &&
            std::find(stations.begin(), stations.end(), kink) == stations.end())
            stations.push_back(kink);
    std::sort(stations.begin(), stations.end());
    MovedWing moved;
    moved.wing = wing;
    for (const double s : stations) {
        Node node = node_at(start, *wing, s);
        if (moved.nodes.empty() || node.place > moved.nodes.back().place + 1e-9) moved.nodes.push_back(std::move(node));
    }
    if (moved.nodes.size() < 2)
        throw InvalidInput(text("wing '", wing->declaration().name, "' has no sections between which it could change"));
    for (int s = 0; s < wing->num_sides(); ++s) moved.reach.push_back(wing->reach(start, s));
    round_corners(start, *wing, moved.reach.front(), moved.nodes);
    const WingFacts facts = wing->facts(start);
    moved.span = facts.span.value;
    moved.sweep = facts.sweep.value;
    moved.dihedral = facts.dihedral.value;
    moved.mean_chord = facts.mean_chord.value;
    wings_.push_back(std::move(moved));
}

void PlanformMotion::round_corners(const TriMesh& start, const Wing& wing, double reach,
                                   std::vector<Node>& nodes) const {
    if (wing.has_winglet()) return;
    const bool is_level = corners_ == StationCorners::level;
    const bool begins_at_joint = is_level && wing.is_joined(0);
    for (std::size_t k = begins_at_joint ? 0 : 1; k + (is_level ? 0 : 1) < nodes.size(); ++k) {
        const double place = nodes[k].place;
        auto [inner, rows, farthest] = cut_edges(start, wing, reach, place);
        if (rows.empty()) continue;
        const auto middle = rows.begin() + static_cast<std::ptrdiff_t>(rows.size() / 2);
        std::nth_element(rows.begin(), middle, rows.end());
        const auto [first, last] = std::minmax_element(inner.begin(), inner.end());
        const bool is_first = k == 0, is_last = k + 1 == nodes.size();
        if (!is_first && *last - *first < same_row * *middle) continue;
        const double panel =
            std::min(is_first ? 1.0 : place - nodes[k - 1].place, is_last ? 1.0 : nodes[k + 1].place - place);
        const double rounding = std::max(rounded_rows * *middle, is_level ? rounded_rows * farthest : 0.0);
        if (is_level) nodes[k].level = std::min(farthest, 0.5 * max_rounding * panel);
        if (!is_last) nodes[k].rounding = std::min(rounding, max_rounding * panel);
    }
}

double PlanformMotion::angle_of(const MovedWing& moved, PlanformChange change) {
    return change == PlanformChange::sweep ? moved.sweep : change == PlanformChange::dihedral ? moved.dihedral : 0;
}

void PlanformMotion::check_range(const PlanformRange& range, const std::string& shown) const {
    const MovedWing& moved = wings_[static_cast<std::size_t>(range.wing)];
    const auto refuse = [&](const std::string& why) { throw InvalidInput(shown + why); };
    if (!(range.lower <= 0 && range.upper >= 0 && range.lower < range.upper) ||
        !std::isfinite(range.upper - range.lower))
        refuse(text(": its range [", range.lower, ", ", range.upper, "] must ascend and contain 0, no change"));
    if (!is_angle(range.change) && range.change != PlanformChange::camber && range.lower < min_share)
        refuse(
            text(": its range begins at ", 100 * range.lower, " %, and must not fall below ", 100 * min_share, " %"));
    if (range.by_station && !has_stations(range.change)) refuse(" is one of the whole wing and has no stations");
    for (const Variable& other : variables_)
        if (other.wing == range.wing && other.change == range.change &&
            (other.station < 0 || range.only.empty() ||
             std::find(range.only.begin(), range.only.end(), other.station) != range.only.end()))
            refuse(" has a range already");
    if (!has_panels(range.change) || !range.by_station) check_angle(range, angle_of(moved, range.change), shown);
}

void PlanformMotion::add(const TriMesh& start, const PlanformRange& range) {
    const std::size_t count = wings_.size() + bodies_.size();
    if (range.wing < 0 || range.wing >= static_cast<int>(count))
        throw InvalidInput(text("planform range: wing ", range.wing, " must be in [0, ", count, ")"));
    if (range.wing >= static_cast<int>(wings_.size())) return add_body_range(start, range);
    MovedWing& moved = wings_[static_cast<std::size_t>(range.wing)];
    const std::string shown =
        text(moved.wing->declaration().name, ".", planform_changes()[static_cast<std::size_t>(range.change)]);
    const auto refuse = [&](const std::string& why) { throw InvalidInput(shown + why); };
    if (!is_of_wings(range.change)) refuse(" is a change of bodies; declare one by its length");
    check_range(range, shown);
    if (!range.by_station && range.root_held) refuse(": root: held belongs to by: station");
    const bool is_root_named = std::find(range.only.begin(), range.only.end(), 0.0) != range.only.end();
    if (range.root_held && is_root_named) refuse("@0: root: held leaves the root no variable; remove one of the two");
    const bool is_of_axis = range.change == PlanformChange::span || has_panels(range.change);
    if (is_shift(range.change) && (moved.wing->is_joined(0) || moved.wing->is_joined(moved.wing->num_sides() - 1)))
        refuse(": the wing is joined to other triangles at its root, which cannot move with it");
    if ((is_of_axis || is_shift(range.change)) && !range.by_station) {
        add_variable(range, -1, {}, angle_of(moved, range.change));
        if (range.change == PlanformChange::span) set_span_right(start, moved);
        return;
    }
    const bool is_joined = moved.wing->is_joined(0) || moved.wing->is_joined(moved.wing->num_sides() - 1);
    const bool is_root_held = range.root_held || (!range.only.empty() && !is_root_named);
    if (has_panels(range.change)) return add_panels(start, range, is_root_held, shown);
    if (is_joined && !(range.by_station && is_root_held))
        refuse(
            ": the wing is joined to other triangles at its root, which cannot change with it; write by: station, "
            "root: held");
    moved.keeps_thickness = moved.keeps_thickness || range.keeps_thickness;
    if (!range.by_station)
        return add_variable(range, -1, VectorXd::Ones(static_cast<Eigen::Index>(moved.nodes.size())));
    add_stations(start, range, is_root_held, shown);
}

/// Sections of a winglet stay as thick as they are, so that its outermost vertices move less than its axis.
void PlanformMotion::set_span_right(const TriMesh& start, MovedWing& moved) const {
    if (!moved.wing->has_winglet() || moved.wing->declaration().rules != WingRules::latest) return;
    const Points by_one = derivative(VectorXd::Zero(size()), size() - 1);
    double shown = 0;
    for (const auto& [coordinate, slope] : moved.wing->facts(start, true).span.slope)
        shown += slope * by_one(coordinate / 3, coordinate % 3);
    moved.span *= moved.span / shown;
}

/// What a change of slope by 1 at a node makes less than a corner, at a distance from it: straight as far as it is
/// level, then tangent to both lines.
double PlanformMotion::rounded_off(const Node& node, double d) {
    const double w = node.rounding, level = node.level;
    if (d >= w) return 0;
    if (level == 0) return 0.5 * d * (d * (2 * w - d) / (w * w) - 1);
    if (d <= level) return -0.5 * d;
    const double t = (d - level) / (w - level);
    return -0.5 * (1 - t) * (1 - t) * (level * (1 + 2 * t) + (w - level) * t);
}

/// Of changes of sections at a point between two nodes: constant beside each as far as it is level, then such that
/// straight edges stay straight.
void PlanformMotion::set_shares(const Node& a, const Node& b, Place& at) {
    at.turned = at.ratio;
    at.first = (1 - at.ratio) * a.chord / at.e;
    if (a.level == 0 && b.level == 0) return;
    const double from = a.level / (b.place - a.place), to = 1 - b.level / (b.place - a.place);
    at.turned = std::clamp((at.ratio - from) / (to - from), 0.0, 1.0);
    at.first = at.turned == 0 ? 1.0 : (1 - at.turned) * (a.chord + from * (b.chord - a.chord)) / at.e;
}

PlanformMotion::Place PlanformMotion::place_at(int wing, int side, const Vector3d& x) const {
    const MovedWing& moved = wings_[static_cast<std::size_t>(wing)];
    const Wing& of = *moved.wing;
    const Vector3d& downstream = of.declaration().downstream;
    const double s = of.fraction_at(side, moved.reach[static_cast<std::size_t>(side)], x);
    Place at;
    if (of.is_joined(side) && s <= 0) return at;
    at.wing = wing;
    at.side = side;
    while (at.node + 2 < moved.nodes.size() && moved.nodes[at.node + 1].place < s) ++at.node;
    const Node &a = moved.nodes[at.node], &b = moved.nodes[at.node + 1];
    const double straight = (s - a.place) / (b.place - a.place);
    at.ratio = std::clamp(straight, 0.0, 1.0);
    at.straight = straight;
    at.corner = at.node + (straight > 0.5 ? 1 : 0);
    at.off_corner = rounded_off(moved.nodes[at.corner], std::abs(s - moved.nodes[at.corner].place));
    at.e = a.chord + at.ratio * (b.chord - a.chord);
    set_shares(a, b, at);
    const Vector3d axis = a.axis + straight * (b.axis - a.axis);
    at.up = of.up_at(side, s);
    Vector3d from(of.span(side).dot(x) - of.root(side), downstream.dot(x), of.declaration().up.dot(x));
    at.arm = axis - moved.nodes.front().axis;
    at.arm[0] = axis[0];
    from -= axis;
    if (!of.has_winglet()) at.arm[0] += from[0];
    const Complex w(from[1], from[0] * at.up.dot(of.span(side)) + from[2] * at.up.dot(of.declaration().up));
    at.zeta = w / at.e;
    const double xi = at.zeta.real() + of.declaration().axis;
    at.height = at.zeta.imag() - blend(mean_line(a.mean_line, xi), mean_line(b.mean_line, xi), at.ratio);
    const auto bump = [&](const Node& node) {
        return node.bump.size() > 0 ? mean_line(node.bump, xi) : four_digit_line(xi);
    };
    at.bump = blend(bump(a), bump(b), at.ratio);
    at.kept = a.is_blunt || b.is_blunt ? 1 - std::pow(std::max(xi, 0.0), 8) : 1;
    const std::vector<double>& noses = moved.nose_places;
    if (noses.size() < 2) return at;
    std::size_t k = 1;
    while (k + 1 < noses.size() && noses[k] < s) ++k;
    const double along = std::clamp((s - noses[k - 1]) / (noses[k] - noses[k - 1]), 0.0, 1.0);
    const Complex aft = 1.0 - (at.zeta + of.declaration().axis);
    const auto nose = [&](const std::vector<Complex>& by) { return aft * (by[k - 1] + along * (by[k] - by[k - 1])); };
    at.lead_by_thickness = nose(moved.nose_by_thickness);
    at.lead_by_camber = nose(moved.nose_by_camber);
    return at;
}

/// Where noses are measured, behind the place that they stand for: even along the span; as far as a node is level its
/// own.
std::vector<std::pair<double, double>> PlanformMotion::nose_places(const MovedWing& moved) {
    std::vector<std::pair<double, double>> found;
    for (int k = 0; k <= num_noses; ++k) {
        const double place = moved.wing->place(0, 1) * k / num_noses;
        if (std::none_of(moved.nodes.begin(), moved.nodes.end(), [&](const Node& node) {
                return std::abs(place - node.place) <= node.level && node.level > 0;
            }))
            found.emplace_back(place, place);
    }
    for (const Node& node : moved.nodes)
        for (const double sign : {-1.0, 1.0})
            if (node.level > 0) found.emplace_back(node.place + sign * node.level, node.place);
    std::sort(found.begin(), found.end());
    return found;
}

/// Thickness and camber turn a round nose a little, whose foremost point then is another one.
void PlanformMotion::measure_noses(const TriMesh& start, int number) {
    MovedWing& moved = wings_[static_cast<std::size_t>(number)];
    const Wing& wing = *moved.wing;
    std::vector<int> row(static_cast<std::size_t>(start.num_vertices()), -1);
    for (std::size_t i = 0; i < vertices_.size(); ++i)
        if (places_[i].wing == number) row[static_cast<std::size_t>(vertices_[i])] = static_cast<int>(i);
    for (const auto& [stand, place] : nose_places(moved)) {
        const auto at = wing.edges(start, start, 0, place, true);
        if (!at) continue;
        const auto change = [&](const Varying& of, double Place::*by) {
            double sum = 0;
            for (const auto& [coordinate, slope] : of.slope) {
                const int i = row[static_cast<std::size_t>(coordinate / 3)];
                if (i < 0) continue;
                const Place& vertex = places_[static_cast<std::size_t>(i)];
                sum += slope * in_space(vertex, Vector3d::Zero(), Complex(0, vertex.*by) * vertex.e)[coordinate % 3];
            }
            return sum;
        };
        const Vector3d chord = at->trailing_point - at->leading_point;
        const Complex e(chord.dot(wing.declaration().downstream), chord.dot(at->up));
        moved.nose_places.push_back(stand);
        const auto nose = [&](double Place::*by) {
            return Complex(change(at->leading.x, by), change(at->leading.z, by)) / e;
        };
        moved.nose_by_thickness.push_back(nose(&Place::height));
        moved.nose_by_camber.push_back(nose(&Place::bump));
    }
    for (std::size_t i = 0; i < vertices_.size(); ++i)
        if (places_[i].wing == number) places_[i] = place_at(number, places_[i].side, start.vertices.row(vertices_[i]));
}

void PlanformMotion::place_vertices(const TriMesh& start) {
    std::vector<int> owner(static_cast<std::size_t>(start.num_vertices()), -1);
    for (int w = 0; w < static_cast<int>(wings_.size()); ++w) {
        const Wing& wing = *wings_[static_cast<std::size_t>(w)].wing;
        for (int s = 0; s < wing.num_sides(); ++s)
            for (const int v : wing.vertices(s)) {
                int& of = owner[static_cast<std::size_t>(v)];
                if (of == w) continue;
                if (of >= 0)
                    throw InvalidInput(text("wings '", wings_[static_cast<std::size_t>(of)].wing->declaration().name,
                                            "' and '", wing.declaration().name, "' share vertices; only one may move"));
                of = w;
                const Vector3d x = start.vertices.row(v);
                const auto outboard = [&](int side) { return wing.span(side).dot(x) - wing.root(side); };
                const int side = wing.num_sides() > 1 && outboard(1) > outboard(0) ? 1 : 0;
                const Place at = place_at(w, side, x);
                if (at.wing < 0) continue;
                vertices_.push_back(v);
                places_.push_back(at);
            }
    }
    for (int w = 0; w < static_cast<int>(wings_.size()); ++w) measure_noses(start, w);
}

}  // namespace strake
