#include "core/error.hpp"
#include "core/planform/planform_motion.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

/// Variables of bodies: length, width, height and camber. Their motions are linear.
namespace strake {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int num_middles = 64;     ///< sections whose middles widths and heights are measured from
constexpr double pointed = 0.2;     ///< of the largest extent: a nose or tail that is a point or round
constexpr double probe = 1e-2;      ///< change for which sections are measured
constexpr double max_cut = 0.25;    ///< of a change: a section that shows less of it is not understood
constexpr double min_share = -0.9;  ///< nothing is left below

bool is_extent(PlanformChange change) { return change == PlanformChange::width || change == PlanformChange::height; }

const Varying& value_of(const FuselageStation& at, PlanformChange change) {
    return change == PlanformChange::width ? at.width : change == PlanformChange::height ? at.height : at.camber;
}

double largest_height(const TriMesh& start, const Fuselage& body) {
    double largest = 0;
    for (int k = 1; k < 20; ++k) try {
            largest = std::max(largest, body.station(start, k / 20.0).height.value);
        } catch (const InvalidInput&) {  // between two parts of it
        }
    return largest;
}

void check_body(const PlanformRange& range, const std::vector<PlanformMotion::Variable>& variables,
                const std::string& shown) {
    const auto refuse = [&](const std::string& why) { throw InvalidInput(shown + why); };
    if (!is_of_bodies(range.change)) refuse(" is a change of wings; a body has length, width, height and camber");
    if (range.root_held || range.keeps_thickness) refuse(": root and thickness belong to wings");
    if (range.by_station && range.change == PlanformChange::length) refuse(" has no stations");
    if (!(range.lower <= 0 && range.upper >= 0 && range.lower < range.upper) ||
        !std::isfinite(range.upper - range.lower))
        refuse(text(": its range [", range.lower, ", ", range.upper, "] must ascend and contain 0, no change"));
    if (range.lower < min_share)
        refuse(
            text(": its range begins at ", 100 * range.lower, " %, and must not fall below ", 100 * min_share, " %"));
    for (const PlanformMotion::Variable& other : variables)
        if (other.wing == range.wing && other.change == range.change &&
            (other.station < 0 || range.only.empty() ||
             std::find(range.only.begin(), range.only.end(), other.station) != range.only.end()))
            refuse(" has a range already");
}

/// Values at the stations that make a unit of each as sections show it: triangles cut the spline a little.
/// @param field_of the motion by values at the stations
template <class FieldOf>
Eigen::MatrixXd units_of(const TriMesh& start, const Fuselage& body, PlanformChange change,
                         const std::vector<double>& stations, const FieldOf& field_of) {
    const auto count = static_cast<Eigen::Index>(stations.size());
    Eigen::MatrixXd shown_by(count, count);
    for (Eigen::Index k = 0; k < count; ++k) {
        const Points field = field_of(VectorXd::Unit(count, k));
        const TriMesh now = with_vertices(start, start.vertices + probe * field);
        for (Eigen::Index i = 0; i < count; ++i) {
            const double s = stations[static_cast<std::size_t>(i)];
            const double before = value_of(body.station(start, s), change).value,
                         after = value_of(body.station(now, s), change).value;
            shown_by(i, k) = (after - before) / (probe * (is_extent(change) ? before : 1));
        }
    }
    const auto one = Eigen::MatrixXd::Identity(count, count);
    if (!((shown_by - one).cwiseAbs().maxCoeff() < max_cut)) return one;
    return shown_by.partialPivLu().solve(one);
}

}  // namespace

PlanformMotion::Along::Along(std::vector<double> at, VectorXd by, bool has_free_ends)
    : places(std::move(at)), values(std::move(by)), slopes(VectorXd::Zero(values.size())) {
    const Eigen::Index n = values.size();
    if (n < 2) return;
    Eigen::MatrixXd A = Eigen::MatrixXd::Identity(n, n);
    VectorXd b = VectorXd::Zero(n);
    const auto gap = [&](Eigen::Index i) {
        return places[static_cast<std::size_t>(i) + 1] - places[static_cast<std::size_t>(i)];
    };
    const auto rise = [&](Eigen::Index i) { return (values[i + 1] - values[i]) / gap(i); };
    for (Eigen::Index i = 1; i + 1 < n; ++i) {
        A(i, i - 1) = gap(i), A(i, i) = 2 * (gap(i - 1) + gap(i)), A(i, i + 1) = gap(i - 1);
        b[i] = 3 * (gap(i) * rise(i - 1) + gap(i - 1) * rise(i));
    }
    if (has_free_ends) {
        A(0, 0) = 2, A(0, 1) = 1, b[0] = 3 * rise(0);
        A(n - 1, n - 1) = 2, A(n - 1, n - 2) = 1, b[n - 1] = 3 * rise(n - 2);
    }
    slopes = A.partialPivLu().solve(b);
}

double PlanformMotion::Along::operator()(double s) const {
    if (s <= places.front() || values.size() < 2) return values[0];
    if (s >= places.back()) return values[values.size() - 1];
    Eigen::Index i = 0;
    while (places[static_cast<std::size_t>(i) + 1] < s) ++i;
    const double from = places[static_cast<std::size_t>(i)], h = places[static_cast<std::size_t>(i) + 1] - from;
    const double t = (s - from) / h, u = 1 - t;
    return u * u * (1 + 2 * t) * values[i] + t * t * (1 + 2 * u) * values[i + 1] +
           h * t * u * (u * slopes[i] - t * slopes[i + 1]);
}

void PlanformMotion::add_body(const TriMesh& start, const std::shared_ptr<const Fuselage>& body) {
    const FuselageDeclaration& declared = body->declaration();
    std::vector<char> is_listed(static_cast<std::size_t>(start.num_triangles()), 0),
        is_used(static_cast<std::size_t>(start.num_vertices()), 0);
    for (const int t : declared.triangles) {
        is_listed[static_cast<std::size_t>(t)] = 1;
        for (const int v : start.triangles.row(t)) is_used[static_cast<std::size_t>(v)] = 1;
    }
    for (int t = 0; t < start.num_triangles(); ++t)
        for (const int v : start.triangles.row(t))
            if (!is_listed[static_cast<std::size_t>(t)] && is_used[static_cast<std::size_t>(v)])
                throw InvalidInput(text("body '", declared.name, "' is joined to other triangles (triangle ", t,
                                        "), which would be torn; list them with it, or separate the parts"));
    for (const int v : vertices_)
        if (is_used[static_cast<std::size_t>(v)])
            throw InvalidInput(text("body '", declared.name, "' and a wing share vertices; only one may move"));
    for (const MovedBody& other : bodies_)
        for (const int v : other.vertices)
            if (is_used[static_cast<std::size_t>(v)])
                throw InvalidInput(text("bodies '", other.body->declaration().name, "' and '", declared.name,
                                        "' share vertices; only one may move"));
    MovedBody moved{body, {}, body->nose(start), body->length(start).value, {}, {}};
    for (int v = 0; v < start.num_vertices(); ++v)
        if (is_used[static_cast<std::size_t>(v)]) moved.vertices.push_back(v);
    for (int k = 0; k <= num_middles; ++k) try {
            const FuselageStation at = body->station(start, double(k) / num_middles);
            moved.places.push_back(double(k) / num_middles);
            moved.middles.emplace_back(at.across.value, at.up.value);
        } catch (const InvalidInput&) {  // between two parts of it
        }
    bodies_.push_back(std::move(moved));
}

/// The motion by a unit of the change at a point of space.
Vector3d PlanformMotion::body_motion(const MovedBody& moved, PlanformChange change, const Along& along,
                                     const Vector3d& x) const {
    const Fuselage& body = *moved.body;
    const Vector3d &axis = body.declaration().axis, &up = body.declaration().up;
    const double s = (axis.dot(x) - moved.nose) / moved.length;
    if (change == PlanformChange::length) return s * moved.length * axis;
    if (change == PlanformChange::camber) return along(s) * moved.length * up;
    std::size_t k = 1;
    while (k + 1 < moved.places.size() && moved.places[k] < s) ++k;
    const double t = std::clamp((s - moved.places[k - 1]) / (moved.places[k] - moved.places[k - 1]), 0.0, 1.0);
    const Eigen::Vector2d middle = (1 - t) * moved.middles[k - 1] + t * moved.middles[k];
    if (change == PlanformChange::width) return along(s) * (body.across().dot(x) - middle[0]) * body.across();
    return along(s) * (up.dot(x) - middle[1]) * up;
}

Points PlanformMotion::body_field(const MovedBody& moved, PlanformChange change, const Along& along) const {
    Points field = Points::Zero(start_.rows(), 3);
    for (const int v : moved.vertices) field.row(v) = body_motion(moved, change, along, start_.row(v));
    return field;
}

void PlanformMotion::add_body_range(const TriMesh& start, const PlanformRange& range) {
    const MovedBody& moved = bodies_[static_cast<std::size_t>(range.wing) - wings_.size()];
    const Fuselage& body = *moved.body;
    const std::string& word = planform_changes()[static_cast<std::size_t>(range.change)];
    const std::string shown = text(body.declaration().name, ".", word);
    check_body(range, variables_, shown);
    const auto add = [&](double station, Along along) {
        variables_.push_back({text(body.declaration().name, ".delta_", word, station < 0 ? "" : text("@", station)),
                              range.change, range.wing, station, range.lower, range.upper});
        shares_.emplace_back();
        angles_.push_back(0);
        fields_.resize(variables_.size() - 1);
        alongs_.resize(variables_.size() - 1);
        fields_.push_back(body_field(moved, range.change, along));
        alongs_.push_back(std::move(along));
    };
    if (!range.by_station)
        return add(-1, is_extent(range.change) ? Along({0}, VectorXd::Ones(1), false)
                                               : Along({0, 0.5, 1}, Eigen::Vector3d(0, 1, 0), true));
    const std::vector<double> stations = body_stations(start, moved, range, shown);
    // Camber is measured from the line between nose and tail.
    const bool is_extent_here = is_extent(range.change);
    std::vector<double> places = stations;
    if (!is_extent_here) places.insert(places.begin(), 0.0), places.push_back(1.0);
    const auto unit = [&](const VectorXd& by) {
        VectorXd values = VectorXd::Zero(static_cast<Eigen::Index>(places.size()));
        values.segment(is_extent_here ? 0 : 1, by.size()) = by;
        return Along(places, values, !is_extent_here);
    };
    const auto count = static_cast<Eigen::Index>(stations.size());
    const Eigen::MatrixXd units = units_of(start, body, range.change, stations, [&](const VectorXd& by) {
        return body_field(moved, range.change, unit(by));
    });
    for (Eigen::Index k = 0; k < count; ++k) {
        const double station = stations[static_cast<std::size_t>(k)];
        if (range.only.empty() || std::find(range.only.begin(), range.only.end(), station) != range.only.end())
            add(station, unit(units.col(k)));
    }
}

/// Those at which the change is one: not at a pointed end, and of camber not where the line from nose to tail ends.
std::vector<double> PlanformMotion::body_stations(const TriMesh& start, const MovedBody& moved,
                                                  const PlanformRange& range, const std::string& shown) const {
    const std::vector<double>& all = moved.body->declaration().stations;
    const double largest = largest_height(start, *moved.body);
    std::vector<double> found;
    for (const double s : all) {
        const bool is_end = s == 0 || s == 1;
        const FuselageStation at = moved.body->station(start, s);
        const double least = std::min(at.width.value, at.height.value);
        if (range.change == PlanformChange::camber ? !is_end : !is_end || least > pointed * largest) found.push_back(s);
    }
    for (const double wanted : range.only) {
        if (std::find(all.begin(), all.end(), wanted) == all.end()) {
            std::string words;
            for (const double s : all) words += text(words.empty() ? "" : ", ", s);
            throw InvalidInput(text(shown, "@", wanted, ": there is no such station; stations: ", words));
        }
        if (std::find(found.begin(), found.end(), wanted) == found.end())
            throw InvalidInput(text(shown, "@", wanted,
                                    range.change == PlanformChange::camber
                                        ? ": camber is measured from the line between nose and tail; leave it out"
                                        : ": the body is pointed there; leave it out"));
    }
    if (found.empty()) throw InvalidInput(shown + ": no station is left where it could change");
    return found;
}

void PlanformMotion::add_body_maps(const VectorXd& z, std::vector<Eigen::Matrix3d>& maps) const {
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
        const MovedBody& moved = bodies_[b];
        const double h = 1e-6 * moved.length;
        const auto motion = [&](const Vector3d& x) {
            Vector3d u = Vector3d::Zero();
            for (int j = 0; j < size(); ++j) {
                const Variable& v = variables_[static_cast<std::size_t>(j)];
                if (v.wing == static_cast<int>(wings_.size() + b) && z[j] != 0)
                    u += z[j] * body_motion(moved, v.change, alongs_[static_cast<std::size_t>(j)], x);
            }
            return u;
        };
        for (const int t : moved.body->declaration().triangles) {
            Vector3d x = Vector3d::Zero();
            for (const int v : triangles_.row(t)) x += start_.row(v).transpose() / 3;
            for (int c = 0; c < 3; ++c)
                maps[static_cast<std::size_t>(t)].col(c) +=
                    (motion(x + h * Vector3d::Unit(c)) - motion(x - h * Vector3d::Unit(c))) / (2 * h);
        }
    }
}

}  // namespace strake
