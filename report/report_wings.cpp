#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "report/report_parts.hpp"
#include "report/wing_sheet.hpp"

#include <cmath>

/// The wings of the report: their sheets at the start and at the best design.
namespace strake::page {
namespace {

constexpr double outline_grid = 1e5;  ///< points of outlines, in chords, to 1e-5

/// Each outline as x0, z0, x1, z1, ...
Json outline_json(const StationFacts& at) {
    Json outlines = Json::array();
    for (const auto& outline : at.outline) {
        Json points = Json::array();
        for (const auto& [x, z] : outline)
            for (const double c : {x, z}) points.push_back(std::round(outline_grid * c) / outline_grid);
        outlines.push_back(std::move(points));
    }
    return outlines;
}

Json sheet_json(const WingSheet& sheet) {
    Json out = Json::object();
    add_json(sheet, out);
    for (std::size_t k = 0; k < sheet.stations.size(); ++k)
        out["stations"][k]["outlines"] = outline_json(sheet.stations[k]);
    out["curve"] = Json::array();
    for (const StationFacts& at : sheet.curve) {
        Json one = station_json(at);
        one.erase("leading_edge"), one.erase("trailing_edge");
        out["curve"].push_back(std::move(one));
    }
    return out;
}

}  // namespace

Json wings_json(const ReportSubject& subject, const Points& best, std::vector<std::string>& notes) {
    Json wings = Json::array();
    for (const auto& wing : subject.wings) {
        const std::string& name = wing->declaration().name;
        try {
            Json one{{"name", name}, {"axis", wing->declaration().axis}};
            one["start"] = sheet_json(wing_sheet(*wing, subject.surface));
            one["best"] = nullptr;
            wings.push_back(std::move(one));
            if (best.rows() == subject.surface.num_vertices())
                wings.back()["best"] = sheet_json(wing_sheet(*wing, with_vertices(subject.surface, best)));
        } catch (const InvalidInput& error) {
            notes.push_back(text("The sheet of the wing '", name, "' is incomplete: ", error.what()));
        }
    }
    return wings;
}

}  // namespace strake::page
