#include "core/error.hpp"
#include "core/mesh/adjacency.hpp"
#include "core/planform/wing.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace strake {
namespace {

using Eigen::Vector3d;

constexpr double square_tolerance = 1e-6;  ///< of directions that must be perpendicular
constexpr double plane_rel = 1e-4;         ///< of the extent: boundary vertices in a plane
constexpr double mirror_rel = 0.01;        ///< of the chord: both sides of a wing are alike
constexpr double root_share = 0.35;        ///< of the extent: border of the listed triangles there is the root
constexpr double fall_rel = 0.02;          ///< of the chord, below its straight continuation: the tip is rounded
constexpr double kink_rel = 0.005;         ///< of the mean chord: departure of the edges from straight lines
constexpr int max_kinks = 10;

void check_directions(const WingDeclaration& declared) {
    const auto named = [&](const char* name, const Vector3d& d) {
        if (!d.allFinite() || std::abs(d.norm() - 1) > square_tolerance)
            throw InvalidInput(text("wing '", declared.name, "': ", name, " must be a unit vector"));
    };
    named("span", declared.span), named("downstream", declared.downstream), named("up", declared.up);
    const double worst =
        std::max({std::abs(declared.span.dot(declared.downstream)), std::abs(declared.span.dot(declared.up)),
                  std::abs(declared.downstream.dot(declared.up))});
    if (worst > square_tolerance)
        throw InvalidInput(text("wing '", declared.name,
                                "': span, downstream and up must be perpendicular to each other; choose another span "
                                "or state axes"));
    if (!(declared.axis >= 0 && declared.axis <= 1))
        throw InvalidInput(text("wing '", declared.name, "': axis = ", declared.axis, " must be in [0, 1]"));
    for (std::size_t i = 0; i < declared.stations.size(); ++i) {
        const double s = declared.stations[i];
        if (!(s >= 0 && s <= 1))
            throw InvalidInput(text("wing '", declared.name, "': stations[", i, "] = ", s, " must be in [0, 1]"));
        if (i > 0 && !(s > declared.stations[i - 1]))
            throw InvalidInput(text("wing '", declared.name, "': stations must ascend; stations[", i, "] = ", s,
                                    " follows ", declared.stations[i - 1]));
    }
}

}  // namespace

Wing::Wing(const TriMesh& start, const WingDeclaration& declaration) : declared_(declaration) {
    check_directions(declared_);
    declared_.triangles = part_of(start, std::move(declared_.triangles), text("wing '", declared_.name, "'"));
    find_sides(start);
    for (Side& side : sides_) {
        find_winglet(start, side);
        find_last(start, side);
    }
    stations_ = declared_.stations.empty() ? kinks(start) : declared_.stations;
}

namespace {

/// What the listed triangles border on.
struct Border {
    std::vector<std::array<int, 2>> open;   ///< edges of the surface's own boundary
    std::vector<std::array<int, 2>> inner;  ///< edges to other triangles of the surface
};

Border border_of(const TriMesh& mesh, const std::vector<int>& triangles) {
    std::vector<char> listed(static_cast<std::size_t>(mesh.num_triangles()), 0);
    for (const int t : triangles) listed[static_cast<std::size_t>(t)] = 1;
    const Adjacency adjacent = adjacency(mesh);
    Border border;
    for (int e = 0; e < adjacent.num_edges(); ++e) {
        int inside = 0;
        for (const int t : adjacent.edge_triangles[e]) inside += listed[static_cast<std::size_t>(t)];
        const int all = static_cast<int>(adjacent.edge_triangles[e].size());
        if (inside == 1 && all == 1) border.open.push_back(adjacent.edges[static_cast<std::size_t>(e)]);
        if (inside > 0 && inside < all) border.inner.push_back(adjacent.edges[static_cast<std::size_t>(e)]);
    }
    return border;
}

}  // namespace

/// One side, which begins at `from` (along its own span) or where its border with other triangles ends.
Wing::Side Wing::begun(const TriMesh& start, int sign, double from) const {
    Side side;
    side.span = sign * declared_.span;
    std::vector<char> used(static_cast<std::size_t>(start.num_vertices()), 0);
    const auto along = [&](int v) { return side.span.dot(start.vertices.row(v)); };
    for (const int t : declared_.triangles) {
        const auto corner = start.triangles.row(t);
        if (std::max({along(corner[0]), along(corner[1]), along(corner[2])}) < from) continue;
        side.triangles.push_back(t);
        for (const int v : corner) used[static_cast<std::size_t>(v)] = 1;
    }
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (int v = 0; v < start.num_vertices(); ++v)
        if (used[static_cast<std::size_t>(v)]) {
            side.vertices.push_back(v);
            low = std::min(low, along(v)), high = std::max(high, along(v));
        }
    if (!(high > low)) throw InvalidInput(text("wing '", declared_.name, "' has no extent along its span"));
    side.root = std::max(low, from);
    for (const auto& [a, b] : border_of(start, declared_.triangles).inner)
        for (const int v : {a, b})
            if (used[static_cast<std::size_t>(v)] && along(v) < low + root_share * (high - low))
                side.root = std::max(side.root, along(v)), side.is_joined = true;
    side.scale = high - side.root;
    Points positions(static_cast<Eigen::Index>(side.vertices.size()), 3);
    for (std::size_t i = 0; i < side.vertices.size(); ++i)
        positions.row(static_cast<Eigen::Index>(i)) = start.vertices.row(side.vertices[i]);
    side.tip = outermost(positions, side.vertices, side.span, side.scale);
    side.root_point = side.root * side.span;
    return side;
}

void Wing::split_at(const TriMesh& start, double centre, const std::vector<int>& signs) {
    centre_ = centre;
    for (const int sign : signs) sides_.push_back(begun(start, sign, sign * centre));
}

void Wing::find_sides(const TriMesh& start) {
    const auto along = [&](int v) { return declared_.span.dot(start.vertices.row(v)); };
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const int t : declared_.triangles)
        for (const int v : start.triangles.row(t)) low = std::min(low, along(v)), high = std::max(high, along(v));
    const double extent = high - low, slack = plane_rel * extent;
    if (!(extent > 0)) throw InvalidInput(text("wing '", declared_.name, "' has no extent along its span"));
    if (declared_.symmetry && std::abs(declared_.symmetry->normal.dot(declared_.span)) > 1 - square_tolerance) {
        const double centre = declared_.symmetry->offset * declared_.symmetry->normal.dot(declared_.span);
        keeps_centre_ = true;
        if (low >= centre - slack) return split_at(start, centre, {1});
        if (high <= centre + slack) return split_at(start, centre, {-1});
        return split_at(start, centre, {1, -1});
    }
    int open_low = 0, open_high = 0;
    for (const auto& [a, b] : border_of(start, declared_.triangles).open) {
        open_low += std::max(along(a), along(b)) <= low + slack;
        open_high += std::min(along(a), along(b)) >= high - slack;
    }
    if (open_low > 2 && open_high <= 2) return split_at(start, low, {1});
    if (open_high > 2 && open_low <= 2) return split_at(start, high, {-1});
    // Both ends are alike: a whole wing, or one of them is a root.
    const double centre = 0.5 * (low + high);
    split_at(start, centre, {1, -1});
    std::array<double, 2> outer{};
    keeps_centre_ = is_mirrored(start, outer);
    if (keeps_centre_) return;
    sides_.clear();
    const int sign = outer[0] <= outer[1] ? 1 : -1;  // the tip has the smaller chord
    split_at(start, sign > 0 ? low : high, {sign});
}

/// Whether both sides have the same chords at the same places; `outer`: chords near the tips.
bool Wing::is_mirrored(const TriMesh& start, std::array<double, 2>& outer) const {
    bool is_alike = true;
    for (const double place : {0.3, 0.5, 0.7, 0.9}) {
        std::array<double, 2> chord{}, nose{};
        for (std::size_t s = 0; s < 2; ++s)
            if (const auto at = section(start, sides_[s], place, false))
                chord[s] = at->chord().value, nose[s] = at->leading_edge().x.value;
        outer = chord;
        const double tolerance = mirror_rel * std::max(chord[0], chord[1]);
        is_alike = is_alike && chord[0] > 0 && std::abs(chord[0] - chord[1]) <= tolerance &&
                   std::abs(nose[0] - nose[1]) <= tolerance;
    }
    return is_alike;
}

/// Streamwise planes fail where the wing rises more steeply than 45 degrees, or is cut along a winglet.
void Wing::find_winglet(const TriMesh& start, Side& side) const {
    constexpr int count = 60;
    std::optional<std::array<double, 2>> before;
    for (int i = 0; i <= count; ++i) {
        const double place = 0.985 * i / count;
        const auto at = section(start, side, place, false);
        if (!at) continue;
        const double chord = at->chord().value, thick = at->max_thickness().value;
        const double z = 0.5 * (at->leading_edge().z.value + at->trailing_edge().z.value);
        const bool is_steep =
            before && std::abs(z - (*before)[1]) > (place - (*before)[0]) * side.scale * 1.05 + 0.01 * chord;
        if (place > 0.5 && (is_steep || thick > 0.4)) {
            march(start, side);
            return;
        }
        before = {place, z};
    }
}

namespace {

/// Of the line along which the sections of a wing with a winglet are laid.
struct Step {
    Vector3d axis;
    double direction, angle, chord, thickness;
};

/// Steps that turn near the end go around the edge of the tip.
/// @param by_planes those whose planes have turned, too, and within two thicknesses of the end; else within one
void leave_out_tip(std::vector<Step>& steps, bool by_planes) {
    constexpr double tip_turn = 3 * std::numbers::pi / 180;
    std::size_t before = steps.size() - 1;
    const double reach = by_planes ? 2 : 1;
    while (before > 0 && (steps.back().axis - steps[before].axis).norm() < reach * steps[before].thickness) --before;
    const auto turns = [&](double angle) { return std::abs(angle - steps[before].direction) > tip_turn; };
    const auto turned =
        std::find_if(steps.begin() + static_cast<std::ptrdiff_t>(before), steps.end(),
                     [&](const Step& step) { return turns(step.direction) || (by_planes && turns(step.angle)); });
    steps.erase(turned, steps.end());
}

/// Straight on from the last step to the plane of the outermost vertices: where steps end is an accident.
void extend_to_tip(const TriMesh& start, const std::vector<int>& vertices, const Vector3d& span, const Vector3d& up,
                   std::vector<Step>& steps) {
    if (steps.size() < 2) return;
    Step last = steps.back();
    const Vector3d n = std::cos(last.angle) * span + std::sin(last.angle) * up,
                   way = last.axis - steps[steps.size() - 2].axis;
    double tip = n.dot(last.axis);
    for (const int v : vertices) tip = std::max(tip, n.dot(start.vertices.row(v)));
    const double rest = tip - n.dot(last.axis);
    if (!(rest > 0 && n.dot(way) > 0)) return;
    last.axis += rest / n.dot(way) * way;
    steps.push_back(last);
}

}  // namespace

void Wing::march(const TriMesh& start, Side& side) const {
    constexpr double degree = std::numbers::pi / 180;
    const Vector3d e = side.span, up = declared_.up;
    const auto try_at = [&](const Vector3d& guess, double direction, double reach) -> std::optional<Step> {
        const double angle = std::abs(direction) > 45 * degree ? direction : 0;
        Plane plane;
        plane.frame = {std::cos(angle) * e + std::sin(angle) * up, declared_.downstream,
                       -std::sin(angle) * e + std::cos(angle) * up, 0};
        plane.frame.offset = plane.frame.normal.dot(guess);
        plane.near = guess;
        const auto at = section(start, side, plane, false);
        if (!at || at->max_thickness().value > 0.4) return {};
        const Vector3d middle = 0.5 * (in_space(plane, at->leading_edge()) + in_space(plane, at->trailing_edge()));
        const Vector3d off = middle - guess;
        if (std::hypot(off.dot(e), off.dot(up)) > reach) return {};
        const double chord = at->chord().value;
        return Step{middle, direction, angle, chord, at->max_thickness().value * chord};
    };
    const Plane root = plane(start, side, 0.002, false);
    const auto first = section(start, side, root, false);
    if (!first) return;
    std::vector<Step> steps{{0.5 * (in_space(root, first->leading_edge()) + in_space(root, first->trailing_edge())), 0,
                             0, first->chord().value, 0}};
    double h = side.scale / 60;
    while (h > side.scale / 2000 && steps.size() < 1000) {
        const Step& last = steps.back();
        std::optional<Step> next;
        for (const int turn : {0, 10, -10, 20, -20, 35, -35, 50, -50, 70, -70, 90, -90}) {
            const double direction = last.direction + turn * degree;
            next = try_at(last.axis + h * (std::cos(direction) * e + std::sin(direction) * up), direction, 0.6 * h);
            if (next && next->chord > 0.5 * last.chord && next->chord < 1.5 * last.chord) break;
            next.reset();
        }
        if (!next) {
            h /= 2;
            continue;
        }
        const Vector3d way = next->axis - last.axis;
        next->direction = std::atan2(way.dot(up), way.dot(e));
        steps.push_back(*next);
    }
    const bool is_to_tip = declared_.rules != WingRules::earlier;
    leave_out_tip(steps, is_to_tip);
    if (is_to_tip) extend_to_tip(start, side.vertices, e, up, steps);
    if (std::none_of(steps.begin(), steps.end(), [](const Step& step) { return step.angle != 0; })) return;
    std::vector<double> length{0};
    for (std::size_t i = 1; i < steps.size(); ++i) {
        const Vector3d way = steps[i].axis - steps[i - 1].axis;
        length.push_back(length.back() + std::hypot(way.dot(e), way.dot(up)));
    }
    side.length = length.back();
    side.root_point = steps.front().axis + (side.root - e.dot(steps.front().axis)) * e;
    for (std::size_t i = 0; i < steps.size(); ++i)
        side.nodes.push_back({length[i] / side.length, steps[i].angle, steps[i].axis});
    side.start.resize(static_cast<Eigen::Index>(side.vertices.size()), 3);
    for (std::size_t i = 0; i < side.vertices.size(); ++i)
        side.start.row(static_cast<Eigen::Index>(i)) = start.vertices.row(side.vertices[i]);
    for (Node& node : side.nodes) tie(start, side, node);
}

/// By the foremost and the aftmost point of the section; at a rounded tip by the outermost vertices.
void Wing::tie(const TriMesh& start, const Side& side, Node& node) const {
    Plane plane;
    plane.frame = {std::cos(node.angle) * side.span + std::sin(node.angle) * declared_.up, declared_.downstream,
                   -std::sin(node.angle) * side.span + std::cos(node.angle) * declared_.up, 0};
    plane.frame.offset = plane.frame.normal.dot(node.axis);
    plane.near = node.axis;
    const std::vector<Outline> found = outlines(start, side, plane, true);
    if (found.empty()) {
        const auto tip = outermost(side.start, side.vertices, plane.frame.normal, side.scale);
        for (const int v : tip) node.middle.emplace_back(v, 1.0 / static_cast<double>(tip.size()));
    } else {
        const auto [first, last] =
            std::minmax_element(found.front().points.begin(), found.front().points.end(),
                                [](const PlanePoint& a, const PlanePoint& b) { return a.x.value < b.x.value; });
        // A point of the section is (1 - t) a + t b, and downstream lies in the plane: its slopes along it are shares.
        for (const auto& [coordinate, slope] : (0.5 * first->x + 0.5 * last->x).slope) {
            if (node.middle.empty() || node.middle.back().first != coordinate / 3)
                node.middle.emplace_back(coordinate / 3, 0.0);
            node.middle.back().second += slope * declared_.downstream[coordinate % 3];
        }
    }
    for (const auto& [v, share] : node.middle) node.middle_at += share * start.vertices.row(v).transpose();
}

/// Chords at the tip that stay below the straight continuation of those before belong to its rounding.
void Wing::find_last(const TriMesh& start, Side& side) const {
    std::vector<std::pair<double, double>> taken;
    for (const double place : {0.91, 0.93, 0.95, 0.96, 0.97, 0.98, 0.985, 0.99, 0.995, 0.998}) {
        const auto at = section(start, side, place, false);
        const double chord = at ? at->chord().value : 0;
        if (taken.size() >= 3) {  // a kink farther in is a kink
            const auto [s0, c0] = taken[taken.size() - 2];
            const auto [s1, c1] = taken.back();
            const double expected = c1 + (c1 - c0) * std::min(1.0, (place - s1) / (s1 - s0));
            if (chord < expected - fall_rel * c1) break;
        }
        if (at) taken.emplace_back(place, chord);
    }
    side.last = taken.empty() ? 1 : taken.back().first;
}

/// Recursively halves where the edges leave the straight lines between stations most (Douglas & Peucker, 1973).
std::vector<double> Wing::kinks(const TriMesh& start) const {
    constexpr int count = 80;
    const Side& side = sides_.front();
    Eigen::Matrix<double, Eigen::Dynamic, 4> rows(count + 1, 4);  // station, leading, trailing edge, height
    double mean = 0;
    for (int i = 0; i <= count; ++i) {
        const double place = side.last * i / count;
        const Plane at = plane(start, side, place, false);
        const auto airfoil = section(start, side, at, false);
        if (!airfoil)
            throw InvalidInput(
                text("wing '", declared_.name, "' has no section at ", 100 * place, " % of its semispan"));
        const Vector3d lead = in_space(at, airfoil->leading_edge()), trail = in_space(at, airfoil->trailing_edge());
        rows.row(i) << place, declared_.downstream.dot(lead), declared_.downstream.dot(trail),
            declared_.up.dot(0.5 * (lead + trail));
        mean += airfoil->chord().value / (count + 1);
    }
    for (double tolerance = kink_rel * mean;; tolerance *= 1.5) {
        std::vector<int> chosen{0, count};
        for (std::size_t k = 0; k + 1 < chosen.size();) {
            const int a = chosen[k], b = chosen[k + 1];
            double worst = tolerance;
            int where = -1;
            for (int i = a + 1; i < b; ++i) {
                const double t = double(i - a) / (b - a);
                const auto straight = (1 - t) * rows.row(a) + t * rows.row(b);
                const double off = (rows.row(i) - straight).rightCols<3>().cwiseAbs().maxCoeff();
                if (off > worst) worst = off, where = i;
            }
            if (where >= 0)
                chosen.insert(chosen.begin() + static_cast<std::ptrdiff_t>(k) + 1, where);
            else
                ++k;
        }
        if (static_cast<int>(chosen.size()) > max_kinks) continue;
        std::vector<double> stations;
        for (const int i : chosen) stations.push_back(i == count ? 1 : std::round(1000 * rows(i, 0)) / 1000);
        return stations;
    }
}

}  // namespace strake
