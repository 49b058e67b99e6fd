#include "cli/body_measures.hpp"

#include "cli/planform_sheet.hpp"
#include "core/error.hpp"
#include "core/mesh/adjacency.hpp"
#include "core/text/file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace strake::cli {
namespace {

using Eigen::Vector3d;
using Json = nlohmann::ordered_json;

constexpr double plane_rel = 1e-4;  ///< of the extent: open edges in a plane

Vector3d direction(const std::string& way) {
    const bool has_sign = way.size() == 2 && (way[0] == '+' || way[0] == '-');
    const std::size_t axis = std::string("xyz").find(way.empty() ? ' ' : way.back());
    if (axis == std::string::npos || way.size() != (has_sign ? 2U : 1U))
        throw InvalidInput(text("--length ", printable(way), ": must be x, y or z, or one of them with a sign"));
    return (way[0] == '-' ? -1 : 1) * Vector3d::Unit(static_cast<Eigen::Index>(axis));
}

/// The plane that holds all open edges, across the body: the surface is half of it.
std::optional<SymmetryPlane> half_plane(const TriMesh& mesh, const Vector3d& across) {
    const Adjacency adjacent = adjacency(mesh);
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (int e = 0; e < adjacent.num_edges(); ++e)
        if (adjacent.edge_triangles[e].size() == 1)
            for (const int v : adjacent.edges[static_cast<std::size_t>(e)]) {
                const double at = across.dot(mesh.vertices.row(v));
                low = std::min(low, at), high = std::max(high, at);
            }
    const Eigen::VectorXd all = mesh.vertices * across;
    const double extent = all.maxCoeff() - all.minCoeff();
    if (!(low <= high) || !(extent > 0) || !(high - low <= plane_rel * extent)) return {};  // closed, flat, other edges
    return SymmetryPlane{across, 0.5 * (low + high)};
}

std::string percent(double fraction) { return fmt::format("{:.3f}", std::abs(fraction) < 5e-6 ? 0 : 100 * fraction); }

}  // namespace

BodyMeasures body_measures(const TriMesh& mesh, const std::string& file, const std::string& way,
                           const std::vector<double>& stations, const TriMesh* start) {
    const TriMesh& first = start ? *start : mesh;
    if (start) check_same_triangles(*start, mesh);
    BodyMeasures body;
    body.declared.axis = direction(way);
    body.declared.up = std::abs(body.declared.axis.z()) > 0 ? Vector3d::UnitY() : Vector3d::UnitZ();
    body.declared.symmetry = half_plane(first, body.declared.up.cross(body.declared.axis));
    if (!stations.empty()) body.declared.stations = stations;
    if (const auto wing = find_wing(first)) {
        std::vector<char> is_wing(static_cast<std::size_t>(first.num_triangles()), 0);
        for (const int t : wing->declaration.triangles) is_wing[static_cast<std::size_t>(t)] = 1;
        for (int t = 0; t < first.num_triangles(); ++t)
            if (!is_wing[static_cast<std::size_t>(t)]) body.declared.triangles.push_back(t);
        body.is_beside_wing = !wing->declaration.triangles.empty();
        if (!body.is_beside_wing || body.declared.triangles.empty())
            throw InvalidInput(text(printable(file),
                                    ": the wing that is found is the whole surface, with what it is joined to; leave "
                                    "--length out for the wing, or declare the body in a case: planform: {body: "
                                    "{length: ",
                                    way_words(body.declared.axis), ", on: REGION}}"));
    }
    const Fuselage fuselage(first, body.declared);
    body.now = body_sheet(fuselage, mesh);
    if (start) body.start = body_sheet(fuselage, *start);
    return body;
}

std::string body_words(const std::string& file, const BodyMeasures& body) {
    std::string out = printable(file) + "\n";
    out += fmt::format("{:<16}{}{}\n", "body", body.is_beside_wing ? "what is not of the wing" : "the whole surface",
                       body.declared.symmetry ? "; half a body: widths are of both sides" : "");
    out += fmt::format("{:<16}length {}, up {}\n", "directions", way_words(body.declared.axis),
                       way_words(body.declared.up));
    out += fmt::format("{:<16}{:.6g}{}\n", "length", body.now.length,
                       body.start ? fmt::format(" (start {:.6g})", body.start->length) : "");
    out += "\nstation            width     height    camber\nof length                               % of length\n";
    const auto line = [&](const std::string& name, const BodySheet::Section& at) {
        out += fmt::format("{:<14} {:>10.5g} {:>10.5g} {:>9}\n", name, at.at.width.value, at.at.height.value,
                           percent(at.at.camber.value));
    };
    for (std::size_t k = 0; k < body.now.stations.size(); ++k) {
        const std::string name = fmt::format("{:.3f}", body.now.stations[k].station);
        if (body.start) line(name + " start", body.start->stations[k]);
        line(body.start ? name + " now" : name, body.now.stations[k]);
    }
    return out;
}

Json body_json(const BodyMeasures& body) {
    const auto point = [](const Vector3d& p) { return Json{p[0], p[1], p[2]}; };
    Json out{{"length_direction", point(body.declared.axis)},
             {"up", point(body.declared.up)},
             {"half", body.declared.symmetry.has_value()},
             {"beside_wing", body.is_beside_wing}};
    add_json(body.now, out);
    if (body.start) add_json(*body.start, out["start"]);
    return out;
}

std::string body_csv(const BodyMeasures& body) {
    std::string out = "station,outline,across,up\n";
    for (const BodySheet::Section& section : body.now.stations)
        for (std::size_t o = 0; o < section.at.outline.size(); ++o)
            for (const auto& [x, z] : section.at.outline[o])
                out += fmt::format("{:.6g},{},{:.12g},{:.12g}\n", section.station, o, x, z);
    return out;
}

namespace {

/// In three columns: charts, and sections below them.
struct BodyPicture {
    static constexpr double width = 800, margin = 40, gap = 20, chart_height = 110, step = 190;
    static constexpr double one = (width - 2 * margin - 2 * gap) / 3, first = 2 * margin + chart_height;
    static double left_of(std::size_t k) { return margin + static_cast<double>(k % 3) * (one + gap); }
};

/// All in one scale, about the middle of the start's.
std::string section_drawings(const BodyMeasures& body) {
    std::string out;
    double extent = 0;
    for (const BodySheet* sheet : {&body.now, body.start ? &*body.start : nullptr})
        if (sheet)
            for (const BodySheet::Section& at : sheet->stations)
                extent = std::max({extent, at.at.width.value, at.at.height.value});
    const double scale = 0.8 * std::min(BodyPicture::one, BodyPicture::step) / extent;
    for (std::size_t k = 0; k < body.now.stations.size(); ++k) {
        const BodySheet::Section& now = body.now.stations[k];
        const FuselageStation& middle = body.start ? body.start->stations[k].at : now.at;
        const double x0 = BodyPicture::left_of(k) + 0.5 * BodyPicture::one,
                     y0 = BodyPicture::first + BodyPicture::step * (static_cast<double>(k / 3) + 0.55);
        out += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\">{:.1f} % of the length</text>\n", BodyPicture::left_of(k),
                           y0 - 0.5 * BodyPicture::step, 100 * now.station);
        const auto lines = [&](const FuselageStation& at, const char* colour) {
            for (const auto& outline : at.outline) {
                out += fmt::format("<polyline fill=\"none\" stroke=\"{}\" stroke-width=\"1.5\" points=\"", colour);
                for (const auto& [x, z] : outline)
                    out += fmt::format("{:.2f},{:.2f} ", x0 + scale * (x - middle.across.value),
                                       y0 - scale * (z - middle.up.value));
                out += "\"/>\n";
            }
        };
        if (body.start) lines(body.start->stations[k].at, "#999");
        lines(now.at, "#14508c");
    }
    return out;
}

}  // namespace

std::string body_svg(const BodyMeasures& body) {
    const std::size_t rows = (body.now.stations.size() + 2) / 3;
    const double height = BodyPicture::first + BodyPicture::margin + BodyPicture::step * static_cast<double>(rows);
    std::string out = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" "
        "font-family=\"sans-serif\" font-size=\"13\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
        BodyPicture::width, height);
    const std::vector<std::pair<const char*, double (*)(const FuselageStation&)>> values{
        {"width", [](const FuselageStation& at) { return at.width.value; }},
        {"height", [](const FuselageStation& at) { return at.height.value; }},
        {"camber, %", [](const FuselageStation& at) { return 100 * at.camber.value; }}};
    for (std::size_t k = 0; k < values.size(); ++k) {
        const auto curve = [&](const BodySheet& sheet) {
            SheetCurve points;
            for (const BodySheet::Section& at : sheet.curve) points.emplace_back(at.station, values[k].second(at.at));
            return points;
        };
        out += curve_svg(values[k].first, body.start ? curve(*body.start) : SheetCurve(), curve(body.now),
                         BodyPicture::left_of(k), BodyPicture::margin, BodyPicture::one, BodyPicture::chart_height);
    }
    return out + section_drawings(body) + "</svg>\n";
}

}  // namespace strake::cli
