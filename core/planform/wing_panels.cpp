#include "core/planform/wing.hpp"

#include <algorithm>
#include <cmath>

/// Sweep and dihedral from station to station.
namespace strake {
namespace {

constexpr double min_panel = 1e-3;  ///< of the semispan

}  // namespace

std::vector<double> Wing::panel_ends() const {
    double tip = 1;
    for (const Side& side : sides_) tip = std::min(tip, place_of(side, 1));
    std::vector<double> ends;
    for (const double s : stations_)
        if (s == 1 || s < tip - min_panel) ends.push_back(s);
    if (ends.empty() || ends.front() > 0) ends.insert(ends.begin(), 0.0);
    if (ends.back() < 1) ends.push_back(1.0);
    return ends;
}

/// The axis in the section at a station: outboard, downstream, up.
std::array<Varying, 3> Wing::axis_at(const TriMesh& surface, const Side& side, double station,
                                     bool sensitivities) const {
    const double place = place_of(side, station);
    const Plane at = plane(surface, side, place, sensitivities);
    const Airfoil airfoil = needed(surface, side, place, sensitivities);
    const PlanePoint axis =
        airfoil.leading_edge() + declared_.axis * (airfoil.trailing_edge() - airfoil.leading_edge());
    const auto along = [&](const Eigen::Vector3d& d) {
        return at.frame.normal.dot(d) * at.frame.offset + at.frame.up.dot(d) * axis.z;
    };
    return {along(side.span), axis.x, along(declared_.up)};
}

/// By the start's line of the axis, which only wings with a winglet have; others have no steep panels.
bool Wing::is_upright(double from, double to) const {
    const Side& side = sides_.front();
    if (side.nodes.empty()) return false;
    const auto at = [&](double station) -> Eigen::Vector3d {
        const auto [a, b, ratio] = side.nodes_at(station);
        return a.axis + ratio * (b.axis - a.axis);
    };
    const Eigen::Vector3d way = at(place_of(side, to)) - at(place_of(side, from));
    return std::abs(way.dot(declared_.up)) > std::abs(way.dot(side.span));
}

PanelFacts Wing::panel(const TriMesh& surface, double station, bool sensitivities) const {
    const std::vector<double> ends = panel_ends();
    const auto beyond = std::upper_bound(ends.begin() + 1, ends.end() - 1, station);
    PanelFacts panel;
    panel.from = *(beyond - 1);
    panel.to = *beyond;
    panel.is_upright = is_upright(panel.from, panel.to);
    const double share = 1.0 / num_sides();
    for (const Side& side : sides_) {
        const auto inner = axis_at(surface, side, panel.from, sensitivities),
                   outer = axis_at(surface, side, panel.to, sensitivities);
        const Varying out = outer[0] - inner[0], aft = outer[1] - inner[1], rise = outer[2] - inner[2];
        const Varying width = panel.is_upright ? sqrt(out * out + rise * rise) : out;
        panel.width = panel.width + share * width;
        panel.sweep = panel.sweep + share * atan2(aft, width);
        panel.dihedral = panel.dihedral + share * atan2(rise, out);
    }
    return panel;
}

}  // namespace strake
