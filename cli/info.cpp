#include "cli/body_measures.hpp"
#include "cli/commands.hpp"
#include "cli/detail.hpp"
#include "cli/outputs.hpp"
#include "cli/planform_sheet.hpp"
#include "core/error.hpp"
#include "core/formats/io.hpp"
#include "core/formats/obj_skipped.hpp"
#include "core/repair/checkup.hpp"
#include "core/text/file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

/// `strake info`: what a surface file contains and what is wrong with it.
namespace strake::cli {
namespace {

struct Report {
    SurfaceFile surface;
    Checkup found;
    std::string skipped;  ///< what the file holds beside its triangles
};

Report examine(const std::string& file) {
    Report r{.surface = read_logged(file), .found = {}, .skipped = {}};
    if (r.surface.format == SurfaceFormat::obj && !file.ends_with(".gz"))
        r.skipped = formats::skipped_in_obj(read_bytes(file));
    r.found = checkup(r.surface.mesh);
    return r;
}

const char* title_of(SurfaceFormat format) {
    switch (format) {
        case SurfaceFormat::stl_binary:
            return "STL, binary";
        case SurfaceFormat::stl_ascii:
            return "STL, text";
        case SurfaceFormat::obj:
            return "OBJ";
        case SurfaceFormat::ply_ascii:
            return "PLY, text";
        case SurfaceFormat::ply_binary:
            return "PLY, binary";
        case SurfaceFormat::off:
            return "OFF";
        case SurfaceFormat::tri:
            return "Cart3D tri";
        case SurfaceFormat::vtk:
            return "VTK, legacy";
        case SurfaceFormat::vtp:
            return "VTP";
        case SurfaceFormat::su2:
            return "SU2 mesh";
        case SurfaceFormat::gmsh:
            return "Gmsh msh";
        case SurfaceFormat::nastran:
            return "NASTRAN bulk data";
    }
    return "";
}

bool is_stl(const Report& r) {
    return r.surface.format == SurfaceFormat::stl_binary || r.surface.format == SurfaceFormat::stl_ascii;
}

std::vector<int> triangles_per_group(const TriMesh& mesh) {
    std::vector<int> count(mesh.group_names.size());
    for (const int g : mesh.group) ++count[g];
    return count;
}

nlohmann::ordered_json vector_json(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

nlohmann::ordered_json histogram_json(const Histogram& h) { return {{"limits", h.limits}, {"counts", h.counts}}; }

nlohmann::ordered_json loops_json(const Checkup& c) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const BoundaryLoop& loop : c.loops) {
        nlohmann::ordered_json one{{"vertices", loop.vertices.size()},
                                   {"first_vertex", loop.vertices.front()},
                                   {"length", loop.length},
                                   {"size", loop.size},
                                   {"center", vector_json(loop.center)},
                                   {"normal", vector_json(loop.normal)},
                                   {"deviation", loop.deviation},
                                   {"planar", loop.is_planar},
                                   {"symmetry", nullptr}};
        if (loop.symmetry_axis >= 0)
            one["symmetry"] = {{"plane", std::string(1, "xyz"[loop.symmetry_axis])}, {"at", loop.symmetry_at}};
        list.push_back(std::move(one));
    }
    return list;
}

nlohmann::ordered_json quality_json(const SurfaceQuality& q) {
    return {{"mean", q.mean},
            {"smallest", q.smallest},
            {"fifth_percentile", q.fifth_percentile},
            {"histogram", histogram_json(q.ratios)},
            {"angles_deg", histogram_json(q.angles_deg)},
            {"edges_in_means", histogram_json(q.edges)}};
}

nlohmann::ordered_json as_json(const Report& r) {
    const TriMesh& mesh = r.surface.mesh;
    const Checkup& c = r.found;
    const TopologyFacts& f = c.facts;
    nlohmann::ordered_json j;
    j["vertices"] = mesh.num_vertices();
    j["triangles"] = mesh.num_triangles();
    j["components"] = f.components;
    j["boundary_loops"] = f.boundary_loops.size();
    j["nonmanifold_edges"] = f.nonmanifold_edges.size();
    j["nonmanifold_vertices"] = f.nonmanifold_vertices.size();
    j["misoriented_edges"] = f.misoriented_edges.size();
    j["duplicate_triangles"] = f.duplicate_triangles.size();
    j["degenerate_triangles"] = f.degenerate_triangles.size();
    j["self_intersections"] = nullptr;
    j["adjacent_intersections"] = nullptr;
    if (c.pairs) {
        j["self_intersections"] = c.pairs->apart.size();
        j["adjacent_intersections"] = c.pairs->adjacent.size();
    }
    j["closed"] = f.closed;
    j["box"] = {vector_json(c.box.min), vector_json(c.box.max)};
    j["diagonal"] = c.diagonal;
    j["area"] = c.area;
    j["volume"] = nullptr;
    if (f.closed) j["volume"] = c.volume;
    j["orientable"] = f.orientable;
    j["isolated_vertices"] = f.isolated_vertices.size();
    j["duplicate_vertices"] = f.duplicate_vertices.size();
    j["format"] = title_of(r.surface.format);
    j["file_vertices"] = r.surface.file_vertices;
    j["skipped"] = nullptr;
    if (!r.skipped.empty()) j["skipped"] = r.skipped;
    const SurfaceQuality& q = c.quality;
    j["edge_length"] = {{"min", q.edge_min}, {"mean", q.edge_mean}, {"max", q.edge_max}, {"median", q.edge_median}};
    j["angle_deg"] = {{"min", q.angle_min_deg}, {"max", q.angle_max_deg}};
    j["max_valence"] = q.max_valence;
    j["groups"] = nlohmann::ordered_json::array();
    const auto counts = triangles_per_group(mesh);
    for (std::size_t g = 0; g < counts.size(); ++g)
        j["groups"].push_back({{"name", printable(mesh.group_names[g])}, {"triangles", counts[g]}});
    j["inverted_triangles"] = c.inverted_triangles.size();
    j["crack_vertices"] = c.crack_vertices.size();
    j["inward_components"] = c.inward_components;
    j["loops"] = loops_json(c);
    j["quality"] = quality_json(q);
    j["defects"] = defects_in_words(mesh, c);
    j["advice"] = advice(mesh, c);
    return j;
}

/// The groups of a histogram, for example "15-30: 4 %".
std::string shares(const Histogram& h, const char* unit) {
    double total = 0;
    for (const int count : h.counts) total += count;
    std::string words;
    for (std::size_t i = 0; i < h.counts.size(); ++i)
        if (h.counts[i] > 0)
            words += fmt::format("{}{:g}-{:g}{}: {:.3g} %", words.empty() ? "" : ", ", h.limits[i], h.limits[i + 1],
                                 unit, 100 * h.counts[i] / total);
    return words;
}

void print_info(const std::string& words) {
    std::fputs(words.c_str(), stdout);  // main reports output that cannot be written
}

std::string vector_text(const Eigen::Vector3d& v) { return text(v.x(), " ", v.y(), " ", v.z()); }

void print_words(const std::string& file, const Report& r) {
    const TriMesh& mesh = r.surface.mesh;
    std::string out = text(printable(file), " (", title_of(r.surface.format), ")\n");
    const auto line = [&](const char* name, const std::string& value) {
        out += name + std::string(14 - std::string(name).size(), ' ') + value + "\n";
    };
    line("vertices", is_stl(r) ? text(mesh.num_vertices(), " (", r.surface.file_vertices,
                                      " corners welded where coordinates are equal, tolerance 0)")
                               : text(mesh.num_vertices()));
    line("triangles", text(mesh.num_triangles()));
    const Checkup& c = r.found;
    if (!r.skipped.empty()) line("skipped", r.skipped);
    line("components", text(c.facts.components));
    const auto counts = triangles_per_group(mesh);
    if (!counts.empty()) {
        std::string names;
        for (std::size_t g = 0; g < std::min<std::size_t>(counts.size(), 5); ++g)
            names += text(g ? ", " : "", printable(mesh.group_names[g], 60), " (", counts[g], ")");
        line("groups", text(counts.size(), ": ", names, counts.size() > 5 ? ", ..." : ""));
    }
    line("closed", c.facts.closed ? "yes" : "no");
    line("box", text(vector_text(c.box.min), "  to  ", vector_text(c.box.max)));
    line("diagonal", text(c.diagonal));
    line("area", text(c.area));
    line("volume", c.facts.closed ? text(c.volume) : "none, the surface is not closed");
    const SurfaceQuality& q = c.quality;
    line("edge length", text(q.edge_min, " to ", q.edge_max, ", mean ", q.edge_mean));
    line("", "relative to the mean: " + shares(q.edges, ""));
    line("angles", text(q.angle_min_deg, " to ", q.angle_max_deg, " degrees"));
    line("", shares(q.angles_deg, " deg"));
    line("quality", fmt::format("2 inradius / circumradius: mean {:.3f}, 5th percentile {:.3f}, smallest {:.2g}",
                                q.mean, q.fifth_percentile, q.smallest));
    line("", shares(q.ratios, ""));
    line("valence", text("at most ", q.max_valence, " triangles at a vertex"));
    const auto list = defects_in_words(mesh, c), advised = advice(mesh, c);
    out += list.empty() ? "no defects\n" : "defects (numbers count from 0 in the order of the file):\n";
    for (const auto& d : list) out += "  " + d + "\n";
    if (!advised.empty()) out += "advice:\n";
    for (const auto& a : advised) out += "  " + a + "\n";
    print_info(out);
}

std::optional<PlanformSheet> sheet_of(const TriMesh& mesh, const std::vector<double>& stations,
                                      const std::string& start) {
    if (start.empty()) return planform_sheet(mesh, stations);
    const TriMesh before = read_logged(start).mesh;
    return planform_sheet(mesh, stations, &before);
}

std::optional<BodyMeasures> body_of(const TriMesh& mesh, const std::string& file, const std::string& way,
                                    const std::vector<double>& stations, const std::string& start) {
    if (way.empty()) return {};
    if (start.empty()) return body_measures(mesh, file, way, stations);
    const TriMesh before = read_logged(start).mesh;
    return body_measures(mesh, file, way, stations, &before);
}

void write_sections(const std::string& file, const std::optional<PlanformSheet>& sheet,
                    const std::optional<BodyMeasures>& body) {
    if (file.empty()) return;
    if (!sheet && !body) throw InvalidInput(text("no wing found: there are no sections for ", printable(file)));
    const bool is_picture = file.ends_with(".svg");
    if (!is_picture && !file.ends_with(".csv"))
        throw InvalidInput(text(printable(file), ": --sections writes .csv or .svg"));
    if (body)
        write_atomically(file, is_picture ? body_svg(*body) : body_csv(*body));
    else
        write_atomically(file, is_picture ? sections_svg(*sheet) : sections_csv(*sheet));
}

}  // namespace

void add_info(CLI::App& app) {
    struct Options {
        std::string surface;
        std::string vtp, sections, start, length;
        std::vector<double> stations;
        bool json = false, planform = false;
    };
    auto options = std::make_shared<Options>();
    CLI::App* command = app.add_subcommand("info", "report what a surface file contains and what is wrong with it");
    command
        ->add_option("SURFACE", options->surface,
                     "STL, OBJ, PLY, OFF, Cart3D .tri, VTK, VTP, SU2, Gmsh or NASTRAN file, also gzipped (.gz)")
        ->required();
    command->add_flag("--json", options->json, "print one JSON object instead of words");
    command->add_option("--vtp", options->vtp, "write the surface with every defect marked, for ParaView");
    CLI::Option* planform = command->add_flag(
        "--planform", options->planform, "measure the wing: span, area, sweep, and chord, twist, thickness by station");
    command
        ->add_option(
            "--stations", options->stations,
            "with --planform: fractions of the semispan, for example 0,0.37,1 (default: where edges kink); with "
            "--length: of the length")
        ->delimiter(',')
        ->needs(planform);
    command
        ->add_option(
            "--length", options->length,
            "with --planform: measure the body along x, y or z (with a sign: from the nose to the tail) instead "
            "of the wing: length, and width, height, camber by station")
        ->needs(planform);
    command
        ->add_option("--start", options->start,
                     "with --planform: the same surface before it was changed; lists and draws start and now")
        ->needs(planform);
    command
        ->add_option("--sections", options->sections,
                     "with --planform: write the airfoils, in fractions of the chord, as FILE.csv or FILE.svg; with "
                     "--length: the body's sections, in the file's unit")
        ->needs(planform);
    command->callback([options] {
        std::vector<std::filesystem::path> inputs{options->surface};
        if (!options->start.empty()) inputs.emplace_back(options->start);
        check_outputs({options->vtp, options->sections}, inputs);
        if (options->planform && !options->json && options->vtp.empty()) {
            const TriMesh mesh = read_logged(options->surface).mesh;
            const auto body = body_of(mesh, options->surface, options->length, options->stations, options->start);
            const auto sheet = body ? std::nullopt : sheet_of(mesh, options->stations, options->start);
            write_sections(options->sections, sheet, body);
            print_info(body ? body_words(options->surface, *body) : planform_words(options->surface, sheet));
            return;
        }
        const Report r = examine(options->surface);
        if (!options->vtp.empty()) {
            const DefectFields fields = defect_fields(r.surface.mesh, r.found);
            write_vtp(options->vtp, r.surface.mesh, fields.points, fields.cells);
        }
        nlohmann::ordered_json answer = as_json(r);
        if (options->planform) {
            const auto body =
                body_of(r.surface.mesh, options->surface, options->length, options->stations, options->start);
            const auto sheet = body ? std::nullopt : sheet_of(r.surface.mesh, options->stations, options->start);
            write_sections(options->sections, sheet, body);
            if (body)
                answer["body"] = body_json(*body);
            else
                answer["planform"] = planform_json(sheet);
        }
        if (options->json)
            print_info(answer.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
        else
            print_words(options->surface, r);
    });
}

}  // namespace strake::cli
