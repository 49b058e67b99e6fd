#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "report/body_sheet.hpp"
#include "report/report_parts.hpp"
#include "report/wing_sheet.hpp"

#include <algorithm>
#include <cmath>

/// The wings and bodies of the report: their sheets at the start and at the best design.
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

/// Likewise, about the middle of the start's section, over half of its larger extent there: start and best compare.
Json sections_json(const BodySheet::Section& section, const BodySheet::Section& start) {
    const double across = start.at.across.value, up = start.at.up.value,
                 size = 0.5 * std::max(start.at.width.value, start.at.height.value);
    Json outlines = Json::array();
    for (const auto& outline : section.at.outline) {
        Json points = Json::array();
        for (const auto& [x, z] : outline) {
            points.push_back(std::round(outline_grid * (x - across) / size) / outline_grid);
            points.push_back(std::round(outline_grid * (z - up) / size) / outline_grid);
        }
        outlines.push_back(std::move(points));
    }
    return outlines;
}

Json sheet_json(const BodySheet& sheet, const BodySheet& start) {
    Json out = Json::object();
    add_json(sheet, out);
    for (std::size_t k = 0; k < sheet.stations.size(); ++k)
        out["stations"][k]["outlines"] = sections_json(sheet.stations[k], start.stations[k]);
    out["curve"] = Json::array();
    for (const BodySheet::Section& section : sheet.curve) out["curve"].push_back(section_json(section));
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

Json bodies_json(const ReportSubject& subject, const Points& best, std::vector<std::string>& notes) {
    Json bodies = Json::array();
    for (const auto& body : subject.bodies) {
        const std::string& name = body->declaration().name;
        try {
            const BodySheet start = body_sheet(*body, subject.surface);
            bodies.push_back({{"name", name}, {"start", sheet_json(start, start)}, {"best", nullptr}});
            if (best.rows() == subject.surface.num_vertices())
                bodies.back()["best"] = sheet_json(body_sheet(*body, with_vertices(subject.surface, best)), start);
        } catch (const InvalidInput& error) {
            notes.push_back(text("The sheet of the body '", name, "' is incomplete: ", error.what()));
        }
    }
    return bodies;
}

}  // namespace strake::page
