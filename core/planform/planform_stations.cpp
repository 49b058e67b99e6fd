#include "core/error.hpp"
#include "core/planform/planform_motion.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

/// Variables by station: of sections, and of the panels between them.
namespace strake {
namespace {

using Eigen::VectorXd;

constexpr double steepest = 80 * std::numbers::pi / 180;
constexpr double probe = 1e-2;         ///< change for which sections are measured
constexpr double hardly_shown = 1e-3;  ///< of a change: a station that moves nothing
constexpr double max_cut = 0.25;       ///< of a change: a section that shows less of it is not understood

std::string station_word(double station) { return text("@", station); }

void check_station(const std::vector<double>& stations, double wanted, const std::string& shown,
                   const char* missing = "no such station; stations") {
    if (std::find(stations.begin(), stations.end(), wanted) != stations.end()) return;
    std::string all;
    for (const double s : stations) all += text(all.empty() ? "" : ", ", s);
    throw InvalidInput(text(shown, station_word(wanted), ": there is ", missing, ": ", all));
}

/// 1 at place k, 0 at those beside it, straight between, constant beyond the first and the last.
double hat(const std::vector<double>& places, std::size_t k, double s) {
    if (k > 0 && s < places[k]) return std::max(0.0, (s - places[k - 1]) / (places[k] - places[k - 1]));
    if (k + 1 < places.size() && s > places[k]) return std::max(0.0, (places[k + 1] - s) / (places[k + 1] - places[k]));
    return 1;
}

/// What a change is about, as a section or a panel shows it; of angles of panels the tangent, of the dihedral of an
/// upright one how far it rises.
double shown_value(const Wing& wing, PlanformChange change, const TriMesh& surface, double station) {
    if (has_panels(change)) {
        const PanelFacts at = wing.panel(surface, station);
        if (change == PlanformChange::dihedral && at.is_upright) return at.width.value * std::sin(at.dihedral.value);
        return std::tan(change == PlanformChange::sweep ? at.sweep.value : at.dihedral.value);
    }
    const StationFacts at = wing.station(surface, station);
    return change == PlanformChange::chord       ? at.chord.value
           : change == PlanformChange::twist     ? at.twist.value
           : change == PlanformChange::thickness ? at.thickness_to_chord.value
                                                 : at.camber.value;
}

/// What triangles make of each unit, set right: they cut the corner at a station between two rows of vertices.
void set_right(const Eigen::MatrixXd& shown_by, Eigen::MatrixXd& shares) {
    const auto one = Eigen::MatrixXd::Identity(shown_by.rows(), shown_by.cols());
    if ((shown_by - one).cwiseAbs().maxCoeff() < max_cut)
        shares = shown_by.transpose().partialPivLu().solve(shares).eval();
}

}  // namespace

void PlanformMotion::add_variable(const PlanformRange& range, double station, VectorXd shares, double angle) {
    const std::string& wing = wings_[static_cast<std::size_t>(range.wing)].wing->declaration().name;
    const std::string& word = planform_changes()[static_cast<std::size_t>(range.change)];
    variables_.push_back({text(wing, ".delta_", word, station < 0 ? "" : station_word(station)), range.change,
                          range.wing, station, range.lower, range.upper});
    shares_.push_back(std::move(shares));
    angles_.push_back(angle);
}

void PlanformMotion::check_angle(const PlanformRange& range, double now, const std::string& shown) {
    if (!is_angle(range.change)) return;
    for (const double end : {now + range.lower, now + range.upper})
        if (std::abs(end) > steepest)
            throw InvalidInput(
                text(shown, " would reach ", end * 180 / std::numbers::pi, " degrees; it must stay within 80"));
}

Eigen::MatrixXd PlanformMotion::measured(const TriMesh& start, const PlanformRange& range,
                                         const std::vector<double>& stations, const Eigen::MatrixXd& shares,
                                         const std::vector<double>& angles) {
    const Wing& wing = *wings_[static_cast<std::size_t>(range.wing)].wing;
    const bool is_share = range.change == PlanformChange::chord || range.change == PlanformChange::thickness;
    const auto count = static_cast<Eigen::Index>(stations.size());
    Eigen::MatrixXd result(count, count);
    for (Eigen::Index j = 0; j < count; ++j) {
        PlanformRange alone = range;
        const double angle = angles.empty() ? 0 : angles[static_cast<std::size_t>(j)];
        add_variable(alone, -1, shares.row(j), angle);  // for this measurement
        VectorXd z = VectorXd::Zero(size());
        z[size() - 1] = (range.upper > 0 ? 1 : -1) * probe;
        const double change =
            has_panels(range.change) ? std::tan(angle + z[size() - 1]) - std::tan(angle) : z[size() - 1];
        const TriMesh moved = with_vertices(start, start.vertices + displacement(z));
        for (Eigen::Index i = 0; i < count; ++i) {
            const double before = shown_value(wing, range.change, start, stations[static_cast<std::size_t>(i)]);
            const double after = shown_value(wing, range.change, moved, stations[static_cast<std::size_t>(i)]);
            result(i, j) = (after - before) / (change * (is_share ? before : 1));
        }
        variables_.pop_back();
        shares_.pop_back();
        angles_.pop_back();
    }
    return result;
}

/// One variable each, with hats between the stations: kinks between two have what a straight line through both has.
void PlanformMotion::add_stations(const TriMesh& start, const PlanformRange& range, bool is_root_held,
                                  const std::string& shown) {
    const MovedWing& moved = wings_[static_cast<std::size_t>(range.wing)];
    std::vector<double> stations = moved.wing->stations();
    for (const double wanted : range.only) check_station(stations, wanted, shown);
    if (is_root_held && stations.front() > 0) stations.insert(stations.begin(), 0.0);
    const std::size_t first = is_root_held ? 1 : 0;
    if (stations.size() == first) throw InvalidInput(shown + ": no station is left where it could change");
    std::vector<double> places;
    for (const double station : stations) places.push_back(moved.wing->place(0, station));
    for (std::size_t k = 1; k < places.size(); ++k)
        if (places[k] <= places[k - 1])
            throw InvalidInput(text(shown, ": the station ", stations[k - 1], " lies on the rounded tip, beyond ",
                                    places[k], ", where the station 1 is; leave one of them out of the stations"));
    const std::vector<double> free(stations.begin() + static_cast<std::ptrdiff_t>(first), stations.end());
    const auto count = static_cast<Eigen::Index>(free.size());
    Eigen::MatrixXd shares(count, static_cast<Eigen::Index>(moved.nodes.size()));
    for (std::size_t k = first; k < stations.size(); ++k)
        for (std::size_t n = 0; n < moved.nodes.size(); ++n)
            shares(static_cast<Eigen::Index>(k - first), static_cast<Eigen::Index>(n)) =
                hat(places, k, moved.nodes[n].place);
    const Eigen::MatrixXd shown_by = measured(start, range, free, shares);
    set_right(shown_by, shares);
    for (Eigen::Index k = 0; k < count; ++k) {
        const double station = free[static_cast<std::size_t>(k)];
        const bool is_named = std::find(range.only.begin(), range.only.end(), station) != range.only.end();
        if (!range.only.empty() && !is_named) continue;
        if (std::abs(shown_by(k, k)) < hardly_shown) {  // a pointed tip: no vertex but its point
            if (is_named)
                throw InvalidInput(text(shown, station_word(station),
                                        ": no vertex of the wing moves with this station, "
                                        "as at a tip that is a point; leave it out"));
            continue;
        }
        add_variable(range, station, shares.row(k));
    }
}

namespace {

/// In runs of before sections of a winglet were not where they had been when dihedral lifted it.
bool slides(const Wing& wing) { return wing.has_winglet() && wing.declaration().rules != WingRules::latest; }

/// Those that vary; and of dihedral upright ones that begin where planes are streamwise. What triangles cut of the
/// corner at the foot would make them longer or shorter. Where they begin on the winglet, a section slides along it
/// instead, which changes no angle.
std::vector<PanelFacts> panels_of(const Wing& wing, const TriMesh& start, const PlanformRange& range, bool is_root_held,
                                  const std::string& shown) {
    std::vector<double> free = wing.panel_ends();
    free.pop_back();
    for (const double wanted : range.only) check_station(free, wanted, shown, "no panel that begins there; panels");
    if (is_root_held) free.erase(free.begin());
    std::vector<PanelFacts> panels;
    bool is_any_free = false;
    for (const double station : free) {
        const PanelFacts panel = wing.panel(start, station);
        const bool is_free = range.change != PlanformChange::dihedral || !panel.is_upright;
        const bool begins_level = wing.up_at(0, wing.place(0, station)) == wing.declaration().up;
        if (is_free || (!slides(wing) && begins_level)) panels.push_back(panel);
        is_any_free = is_any_free || is_free;
        if (!is_free && std::find(range.only.begin(), range.only.end(), station) != range.only.end())
            throw InvalidInput(text(shown, station_word(station),
                                    ": the panel is upright (more than 45 degrees of dihedral), which no shear "
                                    "tilts; vary its sweep, or leave it out"));
    }
    if (!is_any_free) throw InvalidInput(shown + ": no panel is left that could change");
    return panels;
}

}  // namespace

/// One variable a panel, which shears by itself and takes along what lies outboard.
void PlanformMotion::add_panels(const TriMesh& start, const PlanformRange& range, bool is_root_held,
                                const std::string& shown) {
    const MovedWing& moved = wings_[static_cast<std::size_t>(range.wing)];
    const Wing& wing = *moved.wing;
    const bool is_dihedral = range.change == PlanformChange::dihedral;
    const std::vector<PanelFacts> panels = panels_of(wing, start, range, is_root_held, shown);
    const auto count = static_cast<Eigen::Index>(panels.size());
    Eigen::MatrixXd shares(count, static_cast<Eigen::Index>(moved.nodes.size()));
    std::vector<double> angles, free;
    for (const PanelFacts& panel : panels) {
        const bool is_lift = is_dihedral && panel.is_upright;  // no variable, but it rises as much as before
        const double from = wing.place(0, panel.from), to = wing.place(0, panel.to),
                     width = is_lift ? 1 : panel.width.value;
        const auto k = static_cast<Eigen::Index>(free.size());
        for (std::size_t n = 0; n < moved.nodes.size(); ++n)
            shares(k, static_cast<Eigen::Index>(n)) =
                width * std::clamp((moved.nodes[n].place - from) / (to - from), 0.0, 1.0);
        angles.push_back(is_lift ? 0 : is_dihedral ? panel.dihedral.value : panel.sweep.value);
        free.push_back(panel.from);
    }
    if (!is_dihedral || !slides(wing)) set_right(measured(start, range, free, shares, angles), shares);
    for (Eigen::Index k = 0; k < count; ++k) {
        const double station = free[static_cast<std::size_t>(k)], angle = angles[static_cast<std::size_t>(k)];
        if (is_dihedral && panels[static_cast<std::size_t>(k)].is_upright) continue;
        if (!range.only.empty() && std::find(range.only.begin(), range.only.end(), station) == range.only.end())
            continue;
        check_angle(range, angle, shown + station_word(station));
        add_variable(range, station, shares.row(k), angle);
    }
}

}  // namespace strake
