#include "cli/planform_sheet.hpp"

#include "core/error.hpp"
#include "core/text/file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

namespace strake::cli {
namespace {

/// Without the sign of a zero as it is shown.
double in_degrees(double radians) {
    const double degrees = radians * 180 / std::numbers::pi;
    return std::abs(degrees) < 5e-4 ? 0 : degrees;
}

nlohmann::ordered_json point_json(const Eigen::Vector3d& p) { return {p[0], p[1], p[2]}; }

std::string in_percent(double fraction) {
    return fmt::format("{:.2f}", std::abs(fraction) < 5e-5 ? 0 : 100 * fraction);
}

}  // namespace

std::string way_words(const Eigen::Vector3d& d) {
    for (int c = 0; c < 3; ++c)
        if (std::abs(std::abs(d[c]) - 1) < 1e-12) return text(d[c] > 0 ? "+" : "-", "xyz"[c]);
    return text("[", d[0], ", ", d[1], ", ", d[2], "]");
}

void check_same_triangles(const TriMesh& start, const TriMesh& mesh) {
    if (start.triangles.rows() != mesh.triangles.rows() || start.triangles != mesh.triangles ||
        start.vertices.rows() != mesh.vertices.rows())
        throw InvalidInput(text("the surface to compare with has ", start.num_triangles(), " triangles of ",
                                start.num_vertices(), " vertices, this one ", mesh.num_triangles(), " of ",
                                mesh.num_vertices(), "; both need the same triangles in the same order"));
}

std::optional<PlanformSheet> planform_sheet(const TriMesh& mesh, const std::vector<double>& stations,
                                            const TriMesh* start) {
    if (start) check_same_triangles(*start, mesh);
    auto found = find_wing(start ? *start : mesh);
    if (!found) return {};
    if (!stations.empty()) found->declaration.stations = stations;
    PlanformSheet sheet;
    sheet.found = *found;
    const Wing wing(start ? *start : mesh, found->declaration);
    sheet.is_half = wing.num_sides() == 1;
    sheet.now = wing_sheet(wing, mesh);
    if (start) sheet.start = wing_sheet(wing, *start);
    return sheet;
}

namespace {

std::string station_line(const std::string& name, const StationFacts& at) {
    return fmt::format("{:<14} {:>9.5g} {:>8.3f} {:>6} {:>4.0f} {:>8} {:>4.0f} {:>10} {:>10.2f} {:>14.5g}\n", name,
                       at.chord.value, in_degrees(at.twist.value), in_percent(at.thickness_to_chord.value),
                       100 * at.thickness_at, in_percent(at.camber.value), 100 * at.camber_at,
                       at.leading_edge_radius ? in_percent(at.leading_edge_radius->value) : "-",
                       in_degrees(at.trailing_edge_angle.value), at.trailing_edge_thickness.value);
}

std::string panel_line(const std::string& name, const PanelFacts& panel) {
    return fmt::format("{:<20} {:>9.5g} {:>9.3f} {:>10.3f}\n", name, panel.width.value, in_degrees(panel.sweep.value),
                       in_degrees(panel.dihedral.value));
}

}  // namespace

std::string planform_words(const std::string& file, const std::optional<PlanformSheet>& sheet) {
    if (!sheet)
        return printable(file) +
               ": no wing found\n"
               "  A wing is followed from its tip along one of the coordinates, by sections thinner than 30 % of the\n"
               "  chord. Declare it in a case (planform) if it lies otherwise. A body is measured along its length\n"
               "  with --length x.\n";
    const WingDeclaration& declared = sheet->found.declaration;
    const WingFacts& f = sheet->now.facts;
    std::string out = printable(file) + "\n";
    const auto line = [&](const char* name, const std::string& value) {
        out += fmt::format("{:<16}{}\n", name, value);
    };
    const std::string whole = sheet->is_half ? ", of both sides; the file holds one" : "";
    const auto before = [&](const Varying WingFacts::*value, double unit = 1) {
        return sheet->start ? fmt::format(" (start {:.6g})", unit * (sheet->start->facts.*value).value) : std::string();
    };
    constexpr double degree = std::numbers::pi / 180;
    line("wing", text(sheet->found.has_body ? "beside a body" : "without body", ", ", sheet->found.why));
    line("directions", text("span ", way_words(declared.span), ", downstream ", way_words(declared.downstream), ", up ",
                            way_words(declared.up)));
    line("span", fmt::format("{:.6g}{}{}", f.span.value, before(&WingFacts::span), whole));
    line("area", fmt::format("{:.6g}{}{}{}", f.area.value, before(&WingFacts::area),
                             sheet->found.has_body ? ", exposed" : "", whole));
    line("aspect ratio", fmt::format("{:.4g}{}", f.aspect_ratio.value, before(&WingFacts::aspect_ratio)));
    line("taper", fmt::format("{:.4g}{}", f.taper.value, before(&WingFacts::taper)));
    line("mean chord", fmt::format("{:.6g}{}", f.mean_chord.value, before(&WingFacts::mean_chord)));
    line("sweep",
         fmt::format("{:.3f} deg{}, quarter chord", in_degrees(f.sweep.value), before(&WingFacts::sweep, 1 / degree)));
    line("dihedral", fmt::format("{:.3f} deg{}, quarter chord", in_degrees(f.dihedral.value),
                                 before(&WingFacts::dihedral, 1 / degree)));
    out +=
        "\nstation            chord    twist    t/c   at   camber   at    LE radius   TE angle   TE thickness\n"
        "of semispan                   deg      %     %    %        %     % chord     deg\n";
    for (std::size_t k = 0; k < sheet->now.stations.size(); ++k) {
        const std::string name = fmt::format("{:.3f}", sheet->now.stations[k].station);
        if (sheet->start) out += station_line(name + " start", sheet->start->stations[k]);
        out += station_line(sheet->start ? name + " now" : name, sheet->now.stations[k]);
    }
    out +=
        "\npanel                    width     sweep   dihedral\nof semispan                         deg        deg\n";
    for (std::size_t k = 0; k < sheet->now.panels.size(); ++k) {
        const std::string name = fmt::format("{:.3f}-{:.3f}", sheet->now.panels[k].from, sheet->now.panels[k].to);
        if (sheet->start) out += panel_line(name + " start", sheet->start->panels[k]);
        out += panel_line(sheet->start ? name + " now" : name, sheet->now.panels[k]);
    }
    return out;
}

nlohmann::ordered_json planform_json(const std::optional<PlanformSheet>& sheet) {
    if (!sheet) return nullptr;
    const WingDeclaration& declared = sheet->found.declaration;
    nlohmann::ordered_json wing{{"downstream", point_json(declared.downstream)},
                                {"up", point_json(declared.up)},
                                {"span_direction", point_json(declared.span)},
                                {"sides", sheet->is_half ? 1 : 2},
                                {"has_body", sheet->found.has_body}};
    add_json(sheet->now, wing);
    if (sheet->start) add_json(*sheet->start, wing["start"]);
    return wing;
}

std::string sections_csv(const PlanformSheet& sheet) {
    std::string out = "station,outline,x,z\n";
    for (const StationFacts& at : sheet.now.stations)
        for (std::size_t o = 0; o < at.outline.size(); ++o)
            for (const auto& [x, z] : at.outline[o])
                out += fmt::format("{:.6g},{},{:.12g},{:.12g}\n", at.station, o, x, z);
    return out;
}

std::string curve_svg(const std::string& title, const SheetCurve& start, const SheetCurve& now, double left, double top,
                      double width, double height) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const auto* curve : {&now, &start})
        for (const auto& [place, value] : *curve) low = std::min(low, value), high = std::max(high, value);
    if (!(high - low > 1e-9 * std::max(1.0, std::abs(high)))) low -= 0.5, high += 0.5;
    std::string out = fmt::format(
        "<text x=\"{0:.1f}\" y=\"{1:.1f}\">{2}</text>\n<rect x=\"{0:.1f}\" y=\"{3:.1f}\" width=\"{4:.1f}\" "
        "height=\"{5:.1f}\" fill=\"none\" stroke=\"#bbb\"/>\n<text x=\"{0:.1f}\" y=\"{6:.1f}\" font-size=\"10\">{7:.4g}"
        "</text>\n<text x=\"{0:.1f}\" y=\"{8:.1f}\" font-size=\"10\">{9:.4g}</text>\n",
        left, top - 6, title, top, width, height, top + 11, high, top + height - 3, low);
    for (const auto& [curve, colour] : {std::pair(&start, "#999"), std::pair(&now, "#14508c")}) {
        if (curve->empty()) continue;
        out += fmt::format("<polyline fill=\"none\" stroke=\"{}\" stroke-width=\"1.5\" points=\"", colour);
        for (const auto& [place, value] : *curve)
            out += fmt::format("{:.2f},{:.2f} ", left + width * place, top + height * (high - value) / (high - low));
        out += "\"/>\n";
    }
    return out;
}

namespace {

std::string charts(const PlanformSheet& sheet, double left, double top, double width, double height) {
    const std::vector<std::pair<const char*, std::function<double(const StationFacts&)>>> all{
        {"chord", [](const StationFacts& at) { return at.chord.value; }},
        {"twist, deg", [](const StationFacts& at) { return in_degrees(at.twist.value); }},
        {"t/c, %", [](const StationFacts& at) { return 100 * at.thickness_to_chord.value; }},
        {"camber, %", [](const StationFacts& at) { return 100 * at.camber.value; }},
        {"LE radius, %",
         [](const StationFacts& at) { return at.leading_edge_radius ? 100 * at.leading_edge_radius->value : 0.0; }}};
    constexpr double gap = 14;
    const double one = (width - gap * static_cast<double>(all.size() - 1)) / static_cast<double>(all.size());
    std::string out;
    for (std::size_t k = 0; k < all.size(); ++k) {
        const auto curve = [&](const std::vector<StationFacts>& of) {
            SheetCurve points;
            for (const StationFacts& at : of) points.emplace_back(at.station, all[k].second(at));
            return points;
        };
        out += curve_svg(all[k].first, sheet.start ? curve(sheet.start->curve) : SheetCurve(), curve(sheet.now.curve),
                         left + static_cast<double>(k) * (one + gap), top, one, height);
    }
    return out;
}

std::string outline_lines(const StationFacts& at, const char* colour, double left, double base, double chord) {
    std::string out;
    for (const auto& outline : at.outline) {
        out += fmt::format("<polyline fill=\"none\" stroke=\"{}\" stroke-width=\"1.5\" points=\"", colour);
        for (const auto& [x, z] : outline) out += fmt::format("{:.2f},{:.2f} ", left + chord * x, base - chord * z);
        out += "\"/>\n";
    }
    return out;
}

}  // namespace

std::string sections_svg(const PlanformSheet& sheet) {
    constexpr double width = 800, margin = 40, step = 170, chart_height = 110;
    const double first = 2 * margin + chart_height;
    const double height = first + margin + step * static_cast<double>(sheet.now.stations.size());
    std::string out = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" "
        "font-family=\"sans-serif\" font-size=\"13\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
        width, height);
    const double chord = width - 2 * margin;
    out += charts(sheet, margin, margin, chord, chart_height);
    for (std::size_t k = 0; k < sheet.now.stations.size(); ++k) {
        const StationFacts& at = sheet.now.stations[k];
        const double base = first + step * (static_cast<double>(k) + 0.6);
        out += fmt::format(
            "<text x=\"{}\" y=\"{:.1f}\">{:.1f} % of the semispan: chord {:.5g}, twist {:.2f} deg, t/c {:.2f} "
            "%</text>\n<line x1=\"{}\" y1=\"{:.1f}\" x2=\"{}\" y2=\"{:.1f}\" stroke=\"#bbb\"/>\n",
            margin, base - 0.5 * step, 100 * at.station, at.chord.value, in_degrees(at.twist.value),
            100 * at.thickness_to_chord.value, margin, base, margin + chord, base);
        if (sheet.start) out += outline_lines(sheet.start->stations[k], "#999", margin, base, chord);
        out += outline_lines(at, "#14508c", margin, base, chord);
    }
    return out + "</svg>\n";
}

}  // namespace strake::cli
