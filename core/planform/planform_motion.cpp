#include "core/planform/planform_motion.hpp"

#include "core/error.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

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
constexpr double map_step = 1e-6;       ///< of the semispan
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

double blend(double a, double b, double ratio) { return a + ratio * (b - a); }

/// Changes of a section between two nodes.
struct Between {
    Complex factor;
    double thickness, kept, camber;
};

}  // namespace

const std::vector<std::string>& planform_changes() {
    static const std::vector<std::string> words{"span", "sweep", "dihedral", "chord",  "twist", "thickness",
                                                "aft",  "up",    "camber",   "length", "width", "height"};
    return words;
}

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
    if ((is_of_axis || is_shift(range.change)) && !range.by_station)
        return add_variable(range, -1, {}, angle_of(moved, range.change));
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

void PlanformMotion::check_size(const VectorXd& z) const {
    if (z.size() != size() || !z.allFinite())
        throw InvalidInput(text("planform: ", z.size(), " values for ", size(), " variables, all of them finite"));
}

PlanformMotion::Changes PlanformMotion::zero(int wing) const {
    const std::size_t count = wings_[static_cast<std::size_t>(wing)].nodes.size();
    const std::vector<double> none(count);
    return {std::vector<Complex>(count), none, none, none, none, none};
}

PlanformMotion::Changes PlanformMotion::changes_of(int wing, const VectorXd& z) const {
    const MovedWing& moved = wings_[static_cast<std::size_t>(wing)];
    Changes now = zero(wing);
    const auto count = static_cast<Eigen::Index>(moved.nodes.size());
    VectorXd chord = VectorXd::Zero(count), twist = chord;
    for (int j = 0; j < size(); ++j) {
        const Variable& v = variables_[static_cast<std::size_t>(j)];
        if (v.wing != wing || z[j] == 0) continue;
        const VectorXd& shares = shares_[static_cast<std::size_t>(j)];
        const double angle = angles_[static_cast<std::size_t>(j)];
        const VectorXd change = (has_panels(v.change) ? std::tan(angle + z[j]) - std::tan(angle) : z[j]) * shares;
        const auto add_to = [&](std::vector<double>& all) { Eigen::Map<VectorXd>(all.data(), count) += change; };
        switch (v.change) {
            case PlanformChange::span:
                now.stretch = 0.5 * z[j] * moved.span / moved.reach.front();
                break;
            case PlanformChange::sweep:
                if (shares.size() > 0)
                    add_to(now.aft);
                else
                    now.sweep = std::tan(angle + z[j]) - std::tan(angle);
                break;
            case PlanformChange::dihedral:
                if (shares.size() > 0)
                    add_to(now.rise);
                else
                    now.dihedral = std::tan(angle + z[j]) - std::tan(angle);
                break;
            case PlanformChange::chord:
                chord += change;
                break;
            case PlanformChange::twist:
                twist += change;
                break;
            case PlanformChange::thickness:
                add_to(now.thickness);
                break;
            case PlanformChange::camber:
                add_to(now.camber);
                break;
            case PlanformChange::length:
            case PlanformChange::width:
            case PlanformChange::height:
                break;  // of bodies
            case PlanformChange::aft:
                now.shift_aft = z[j] * moved.mean_chord;
                break;
            case PlanformChange::up:
                now.shift_up = z[j] * moved.mean_chord;
                break;
        }
    }
    for (Eigen::Index n = 0; n < count; ++n) {
        const auto k = static_cast<std::size_t>(n);
        const double half = std::sin(0.5 * twist[n]);
        const Complex turn_less_1(-2 * half * half, -std::sin(twist[n]));  // exp(-i twist) - 1 without cancellation
        now.factor[k] = chord[n] + (1 + chord[n]) * turn_less_1;
        if (moved.keeps_thickness) now.kept[k] = -chord[n] / (1 + chord[n]);
    }
    return now;
}

std::vector<PlanformMotion::Changes> PlanformMotion::changes(const VectorXd& z) const {
    check_size(z);
    std::vector<Changes> all;
    for (int w = 0; w < static_cast<int>(wings_.size()); ++w) all.push_back(changes_of(w, z));
    return all;
}

PlanformMotion::Changes PlanformMotion::rates(const Changes& now, int j, const VectorXd& z) const {
    const Variable& v = variables_[static_cast<std::size_t>(j)];
    const MovedWing& moved = wings_[static_cast<std::size_t>(v.wing)];
    const VectorXd& shares = shares_[static_cast<std::size_t>(j)];
    Changes rate = zero(v.wing);
    const double cosine = std::cos(angles_[static_cast<std::size_t>(j)] + z[j]), slope = 1 / (cosine * cosine);
    if (v.change == PlanformChange::span) rate.stretch = 0.5 * moved.span / moved.reach.front();
    if (v.change == PlanformChange::aft) rate.shift_aft = moved.mean_chord;
    if (v.change == PlanformChange::up) rate.shift_up = moved.mean_chord;
    if (v.change == PlanformChange::sweep && shares.size() == 0) rate.sweep = slope;
    if (v.change == PlanformChange::dihedral && shares.size() == 0) rate.dihedral = slope;
    for (Eigen::Index n = 0; n < shares.size(); ++n) {
        const auto k = static_cast<std::size_t>(n);
        const Complex factor = 1.0 + now.factor[k];
        if (v.change == PlanformChange::chord) {
            rate.factor[k] = shares[n] * factor / std::abs(factor);
            if (moved.keeps_thickness) rate.kept[k] = -shares[n] / std::norm(factor);
        }
        if (v.change == PlanformChange::twist) rate.factor[k] = shares[n] * Complex(0, -1) * factor;
        if (v.change == PlanformChange::thickness) rate.thickness[k] = shares[n];
        if (v.change == PlanformChange::camber) rate.camber[k] = shares[n];
        if (v.change == PlanformChange::sweep) rate.aft[k] = slope * shares[n];
        if (v.change == PlanformChange::dihedral) rate.rise[k] = slope * shares[n];
    }
    return rate;
}

Vector3d PlanformMotion::in_space(const Place& at, const Vector3d& axis, Complex section) const {
    const Wing& wing = *wings_[static_cast<std::size_t>(at.wing)].wing;
    return axis[0] * wing.span(at.side) + (axis[1] + section.real()) * wing.declaration().downstream +
           axis[2] * wing.declaration().up + section.imag() * at.up;
}

Vector3d PlanformMotion::moved(const Place& at, const Changes& by) const { return moved_rate(at, {}, by); }

Vector3d PlanformMotion::moved_rate(const Place& at, const Changes& by, const Changes& rate) const {
    const auto& nodes = wings_[static_cast<std::size_t>(at.wing)].nodes;
    const Complex first = at.first, second = 1.0 - first;
    const auto between = [&](const Changes& of) -> Between {
        if (of.factor.empty()) return {};
        const auto linear = [&](const std::vector<double>& all) {
            return blend(all[at.node], all[at.node + 1], at.turned);
        };
        return {first * of.factor[at.node] + second * of.factor[at.node + 1], linear(of.thickness), linear(of.kept),
                linear(of.camber)};
    };
    const bool is_whole = by.factor.empty();  // the motion itself, not a rate of it
    const Between now = between(is_whole ? rate : by), change = between(rate);
    // q (1 + t (1 - b)) - 1 without the difference of nearly equal numbers
    const double thick = now.kept + (1 + now.kept) * now.thickness * at.kept;
    const double thick_rate = change.kept * (1 + now.thickness * at.kept) + (1 + now.kept) * change.thickness * at.kept;
    // The same at the nose, where b is zero.
    const double at_nose = now.kept + (1 + now.kept) * now.thickness,
                 at_nose_rate = change.kept * (1 + now.thickness) + (1 + now.kept) * change.thickness;
    const auto shape = [&](double thickness, double by_nose, double camber) {
        return Complex(0, thickness * at.height + camber * at.bump) - by_nose * at.lead_by_thickness -
               camber * at.lead_by_camber;
    };
    const Complex h = shape(thick, at_nose, now.camber), h_rate = shape(thick_rate, at_nose_rate, change.camber);
    const Complex section = is_whole ? now.factor * at.zeta + (1.0 + now.factor) * h
                                     : change.factor * (at.zeta + h) + (1.0 + now.factor) * h_rate;
    const double stretch = is_whole ? rate.stretch : by.stretch;
    Vector3d axis = rate.stretch * at.arm;
    const auto sheared = [&](const Changes& of, double slope, const std::vector<double>& panels) {
        if (of.factor.empty()) return 0.0;
        const double straight = slope * at.arm[0] + blend(panels[at.node], panels[at.node + 1], at.straight);
        if (at.off_corner == 0) return straight;
        const auto slope_from = [&](std::size_t k) {
            return (panels[k + 1] - panels[k]) / (nodes[k + 1].place - nodes[k].place);
        };
        if (at.corner > 0) return straight + at.off_corner * (slope_from(at.corner) - slope_from(at.corner - 1));
        // Inboard of the root nothing moves, and nothing does on what its plane cuts.
        const double reach = wings_[static_cast<std::size_t>(at.wing)].reach[static_cast<std::size_t>(at.side)];
        return straight + 2 * at.off_corner * (slope_from(0) + slope * reach);
    };
    axis[1] += sheared(rate, rate.sweep, rate.aft) * (1 + stretch);
    axis[2] += sheared(rate, rate.dihedral, rate.rise) * (1 + stretch);
    axis[1] += rate.shift_aft;
    axis[2] += rate.shift_up;
    if (!is_whole) {
        axis[1] += sheared(by, by.sweep, by.aft) * rate.stretch;
        axis[2] += sheared(by, by.dihedral, by.rise) * rate.stretch;
    }
    return in_space(at, axis, section * at.e);
}

Points PlanformMotion::displacement(const VectorXd& z) const {
    const std::vector<Changes> now = changes(z);
    Points result = Points::Zero(start_.rows(), 3);
    for (std::size_t i = 0; i < places_.size(); ++i)
        result.row(vertices_[i]) = moved(places_[i], now[static_cast<std::size_t>(places_[i].wing)]);
    for (int j = 0; j < size(); ++j)
        if (const Points* field = body_field(j); field && z[j] != 0) result += z[j] * *field;
    return result;
}

Points PlanformMotion::derivative(const VectorXd& z, int j) const { return rate(z, VectorXd::Unit(size(), j)); }

Points PlanformMotion::rate(const VectorXd& z, const VectorXd& dz) const {
    const std::vector<Changes> now = changes(z);
    check_size(dz);
    Points result = Points::Zero(start_.rows(), 3);
    for (int j = 0; j < size(); ++j) {
        if (dz[j] == 0) continue;
        if (const Points* field = body_field(j)) {
            result += dz[j] * *field;
            continue;
        }
        const int wing = variables_[static_cast<std::size_t>(j)].wing;
        const Changes& of = now[static_cast<std::size_t>(wing)];
        const Changes by = rates(of, j, z);
        for (std::size_t i = 0; i < places_.size(); ++i)
            if (places_[i].wing == wing) result.row(vertices_[i]) += dz[j] * moved_rate(places_[i], of, by);
    }
    return result;
}

VectorXd PlanformMotion::gradient(const VectorXd& z, const Points& dJ_dv) const {
    const std::vector<Changes> now = changes(z);
    VectorXd result = VectorXd::Zero(size());
    for (int j = 0; j < size(); ++j) {
        if (const Points* field = body_field(j)) {
            result[j] = field->cwiseProduct(dJ_dv).sum();
            continue;
        }
        const int wing = variables_[static_cast<std::size_t>(j)].wing;
        const Changes& of = now[static_cast<std::size_t>(wing)];
        const Changes by = rates(of, j, z);
        for (std::size_t i = 0; i < places_.size(); ++i)
            if (places_[i].wing == wing) result[j] += dJ_dv.row(vertices_[i]).dot(moved_rate(places_[i], of, by));
    }
    return result;
}

Eigen::Matrix3d PlanformMotion::slope_at(int wing, int side, const Vector3d& x, const Changes& now) const {
    const double h = map_step * wings_[static_cast<std::size_t>(wing)].reach.front();
    Eigen::Matrix3d slope;
    for (int c = 0; c < 3; ++c) {
        std::array<Vector3d, 2> ends{Vector3d::Zero(), Vector3d::Zero()};
        for (const int sign : {-1, 1}) {
            const Place at = place_at(wing, side, x + sign * h * Vector3d::Unit(c));
            if (at.wing >= 0) ends[sign > 0] = moved(at, now);
        }
        slope.col(c) = (ends[1] - ends[0]) / (2 * h);
    }
    return slope;
}

std::vector<Eigen::Matrix3d> PlanformMotion::local_maps(const VectorXd& z) const {
    const std::vector<Changes> now = changes(z);
    std::vector<Eigen::Matrix3d> maps(static_cast<std::size_t>(triangles_.rows()), Eigen::Matrix3d::Identity());
    for (std::size_t w = 0; w < wings_.size(); ++w) {
        const Wing& wing = *wings_[w].wing;
        for (int s = 0; s < wing.num_sides(); ++s)
            for (const int t : wing.triangles(s)) {
                Vector3d x = Vector3d::Zero();
                for (const int v : triangles_.row(t)) x += start_.row(v).transpose() / 3;
                const auto outboard = [&](int side) { return wing.span(side).dot(x) - wing.root(side); };
                if (wing.num_sides() > 1 && outboard(1 - s) > outboard(s)) continue;
                maps[static_cast<std::size_t>(t)] += slope_at(static_cast<int>(w), s, x, now[w]);
            }
    }
    add_body_maps(z, maps);
    return maps;
}

}  // namespace strake
