#include "report/body_sheet.hpp"

#include "core/error.hpp"

namespace strake {
namespace {

using Json = nlohmann::ordered_json;

constexpr int num_curve_steps = 20;

}  // namespace

BodySheet body_sheet(const Fuselage& body, const TriMesh& surface) {
    BodySheet sheet{body.length(surface).value, {}, {}};
    for (const double s : body.declaration().stations) sheet.stations.push_back({s, body.station(surface, s)});
    for (int k = 0; k <= num_curve_steps; ++k) try {
            const double s = static_cast<double>(k) / num_curve_steps;
            sheet.curve.push_back({s, body.station(surface, s)});
        } catch (const InvalidInput&) {  // a chart may have gaps
            continue;
        }
    return sheet;
}

Json section_json(const BodySheet::Section& section) {
    return {{"station", section.station},
            {"width", section.at.width.value},
            {"height", section.at.height.value},
            {"camber", section.at.camber.value}};
}

void add_json(const BodySheet& sheet, Json& body) {
    body["length"] = sheet.length;
    body["stations"] = Json::array();
    for (const BodySheet::Section& section : sheet.stations) body["stations"].push_back(section_json(section));
}

}  // namespace strake
