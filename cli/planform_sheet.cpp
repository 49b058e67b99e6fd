#include "cli/planform_sheet.hpp"

#include "core/error.hpp"
#include "core/text/file.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace strake::cli {
namespace {

double in_degrees(double radians) { return radians * 180 / std::numbers::pi; }

/// "+x", or the vector.
std::string way_words(const Eigen::Vector3d& d) {
    for (int c = 0; c < 3; ++c)
        if (std::abs(std::abs(d[c]) - 1) < 1e-12) return text(d[c] > 0 ? "+" : "-", "xyz"[c]);
    return text("[", d[0], ", ", d[1], ", ", d[2], "]");
}

nlohmann::ordered_json point_json(const Eigen::Vector3d& p) { return {p[0], p[1], p[2]}; }

std::string in_percent(double fraction) { return fmt::format("{:.2f}", 100 * fraction); }

}  // namespace

std::optional<PlanformSheet> planform_sheet(const TriMesh& mesh, const std::vector<double>& stations) {
    auto found = find_wing(mesh);
    if (!found) return {};
    found->declaration.stations = stations;
    PlanformSheet sheet{*found, false, {}, {}};
    const Wing wing(mesh, found->declaration);
    sheet.is_half = wing.num_sides() == 1;
    sheet.facts = wing.facts(mesh);
    for (const double s : wing.stations()) sheet.stations.push_back(wing.station(mesh, s));
    return sheet;
}

std::string planform_words(const std::string& file, const std::optional<PlanformSheet>& sheet) {
    if (!sheet)
        return printable(file) +
               ": no wing found\n"
               "  A wing is followed from its tip along one of the coordinates, by sections thinner than 30 % of the\n"
               "  chord. Declare it in a case (planform) if it lies otherwise.\n";
    const WingDeclaration& declared = sheet->found.declaration;
    const WingFacts& f = sheet->facts;
    std::string out = printable(file) + "\n";
    const auto line = [&](const char* name, const std::string& value) {
        out += fmt::format("{:<16}{}\n", name, value);
    };
    const std::string whole = sheet->is_half ? ", of both sides; the file holds one" : "";
    line("wing", text(sheet->found.has_body ? "beside a body" : "without body", ", ", sheet->found.why));
    line("directions", text("span ", way_words(declared.span), ", downstream ", way_words(declared.downstream), ", up ",
                            way_words(declared.up)));
    line("span", fmt::format("{:.6g}{}", f.span.value, whole));
    line("area", fmt::format("{:.6g}{}{}", f.area.value, sheet->found.has_body ? ", exposed" : "", whole));
    line("aspect ratio", fmt::format("{:.4g}", f.aspect_ratio.value));
    line("taper", fmt::format("{:.4g}", f.taper.value));
    line("mean chord", fmt::format("{:.6g}", f.mean_chord.value));
    line("sweep", fmt::format("{:.3f} deg, quarter chord", in_degrees(f.sweep.value)));
    line("dihedral", fmt::format("{:.3f} deg, quarter chord", in_degrees(f.dihedral.value)));
    out +=
        "\nstation      chord    twist    t/c   at   camber   at    LE radius   TE angle   TE thickness\n"
        "of semispan             deg      %     %    %        %     % chord     deg\n";
    for (const StationFacts& at : sheet->stations)
        out += fmt::format("{:<8.3f} {:>9.5g} {:>8.3f} {:>6} {:>4.0f} {:>8} {:>4.0f} {:>10} {:>10.2f} {:>14.5g}\n",
                           at.station, at.chord.value, in_degrees(at.twist.value),
                           in_percent(at.thickness_to_chord.value), 100 * at.thickness_at, in_percent(at.camber.value),
                           100 * at.camber_at, at.leading_edge_radius ? in_percent(at.leading_edge_radius->value) : "-",
                           in_degrees(at.trailing_edge_angle.value), at.trailing_edge_thickness.value);
    return out;
}

nlohmann::ordered_json planform_json(const std::optional<PlanformSheet>& sheet) {
    if (!sheet) return nullptr;
    const WingDeclaration& declared = sheet->found.declaration;
    const WingFacts& f = sheet->facts;
    nlohmann::ordered_json wing{{"downstream", point_json(declared.downstream)},
                                {"up", point_json(declared.up)},
                                {"span_direction", point_json(declared.span)},
                                {"sides", sheet->is_half ? 1 : 2},
                                {"has_body", sheet->found.has_body},
                                {"span", f.span.value},
                                {"area", f.area.value},
                                {"aspect_ratio", f.aspect_ratio.value},
                                {"taper", f.taper.value},
                                {"mean_chord", f.mean_chord.value},
                                {"sweep", f.sweep.value},
                                {"dihedral", f.dihedral.value},
                                {"stations", nlohmann::ordered_json::array()}};
    for (const StationFacts& at : sheet->stations) {
        nlohmann::ordered_json one{{"station", at.station},
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
        wing["stations"].push_back(std::move(one));
    }
    return wing;
}

std::string sections_csv(const PlanformSheet& sheet) {
    std::string out = "station,outline,x,z\n";
    for (const StationFacts& at : sheet.stations)
        for (std::size_t o = 0; o < at.outline.size(); ++o)
            for (const auto& [x, z] : at.outline[o])
                out += fmt::format("{:.6g},{},{:.12g},{:.12g}\n", at.station, o, x, z);
    return out;
}

std::string sections_svg(const PlanformSheet& sheet) {
    constexpr double width = 800, margin = 40, step = 170;
    const double height = 2 * margin + step * static_cast<double>(sheet.stations.size());
    std::string out = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" "
        "font-family=\"sans-serif\" font-size=\"13\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
        width, height);
    const double chord = width - 2 * margin;
    for (std::size_t k = 0; k < sheet.stations.size(); ++k) {
        const StationFacts& at = sheet.stations[k];
        const double base = margin + step * (static_cast<double>(k) + 0.6);
        out += fmt::format(
            "<text x=\"{}\" y=\"{:.1f}\">{:.1f} % of the semispan: chord {:.5g}, twist {:.2f} deg, t/c {:.2f} "
            "%</text>\n<line x1=\"{}\" y1=\"{:.1f}\" x2=\"{}\" y2=\"{:.1f}\" stroke=\"#bbb\"/>\n",
            margin, base - 0.5 * step, 100 * at.station, at.chord.value, in_degrees(at.twist.value),
            100 * at.thickness_to_chord.value, margin, base, margin + chord, base);
        for (const auto& outline : at.outline) {
            out += "<polyline fill=\"none\" stroke=\"#14508c\" stroke-width=\"1.5\" points=\"";
            for (const auto& [x, z] : outline)
                out += fmt::format("{:.2f},{:.2f} ", margin + chord * x, base - chord * z);
            out += "\"/>\n";
        }
    }
    return out + "</svg>\n";
}

}  // namespace strake::cli
