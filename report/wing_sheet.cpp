#include "report/wing_sheet.hpp"

#include "core/error.hpp"

namespace strake {
namespace {

using Json = nlohmann::ordered_json;

constexpr int curve_places = 20;

Json point_json(const Eigen::Vector3d& p) { return {p[0], p[1], p[2]}; }

Json panel_json(const PanelFacts& panel) {
    return {{"from", panel.from},
            {"to", panel.to},
            {"width", panel.width.value},
            {"sweep", panel.sweep.value},
            {"dihedral", panel.dihedral.value}};
}

}  // namespace

Json station_json(const StationFacts& at) {
    Json one{{"station", at.station},
             {"leading_edge", point_json(at.leading_edge)},
             {"trailing_edge", point_json(at.trailing_edge)},
             {"chord", at.chord.value},
             {"twist", at.twist.value},
             {"thickness_to_chord", at.thickness_to_chord.value},
             {"thickness_at", at.thickness_at},
             {"camber", at.camber.value},
             {"camber_at", at.camber_at},
             {"leading_edge_radius", nullptr},
             {"trailing_edge_angle", at.trailing_edge_angle.value},
             {"trailing_edge_thickness", at.trailing_edge_thickness.value}};
    if (at.leading_edge_radius) one["leading_edge_radius"] = at.leading_edge_radius->value;
    return one;
}

WingSheet wing_sheet(const Wing& wing, const TriMesh& surface) {
    WingSheet sheet;
    sheet.facts = wing.facts(surface);
    for (const double s : wing.stations()) sheet.stations.push_back(wing.station(surface, s));
    const std::vector<double> ends = wing.panel_ends();
    for (std::size_t k = 0; k + 1 < ends.size(); ++k) sheet.panels.push_back(wing.panel(surface, ends[k]));
    for (int k = 0; k <= curve_places; ++k) try {
            sheet.curve.push_back(wing.station(surface, static_cast<double>(k) / curve_places));
        } catch (const InvalidInput&) {  // a chart may have gaps
            continue;
        }
    return sheet;
}

void add_json(const WingSheet& sheet, Json& wing) {
    const WingFacts& f = sheet.facts;
    wing["span"] = f.span.value;
    wing["area"] = f.area.value;
    wing["aspect_ratio"] = f.aspect_ratio.value;
    wing["taper"] = f.taper.value;
    wing["mean_chord"] = f.mean_chord.value;
    wing["sweep"] = f.sweep.value;
    wing["dihedral"] = f.dihedral.value;
    wing["stations"] = Json::array();
    for (const StationFacts& at : sheet.stations) wing["stations"].push_back(station_json(at));
    wing["panels"] = Json::array();
    for (const PanelFacts& panel : sheet.panels) wing["panels"].push_back(panel_json(panel));
}

}  // namespace strake
