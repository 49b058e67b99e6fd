#include "cli/commands.hpp"
#include "core/error.hpp"
#include "core/mesh/file.hpp"
#include "core/mesh/io.hpp"
#include "core/mesh/topology.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <set>

/// `strake info`: what a surface file holds, and what is wrong with it.
namespace strake::cli {
namespace {

struct Quality {
    double edge_min = 0, edge_mean = 0, edge_max = 0;
    double angle_min_deg = 0, angle_max_deg = 0;
    int max_valence = 0;  ///< triangles at a vertex
};

struct Report {
    SurfaceFile surface;
    Adjacency adjacent;
    TopologyFacts facts;
    std::optional<Intersections> pairs;  ///< none: too many to look at
    Box box;
    double diagonal = 0, area = 0, volume = 0;
    Quality quality;
};

Quality quality(const TriMesh& mesh, const Adjacency& adjacent) {
    Quality q;
    double sum = 0;
    q.edge_min = adjacent.num_edges() > 0 ? std::numeric_limits<double>::infinity() : 0;
    for (const auto& [a, b] : adjacent.edges) {
        const double length = (mesh.vertices.row(a) - mesh.vertices.row(b)).stableNorm();
        q.edge_min = std::min(q.edge_min, length);
        q.edge_max = std::max(q.edge_max, length);
        sum += length;
    }
    q.edge_mean = sum / std::max(1, adjacent.num_edges());
    const Points angles = corner_angles(mesh);
    q.angle_min_deg = angles.minCoeff() * 180 / std::numbers::pi;
    q.angle_max_deg = angles.maxCoeff() * 180 / std::numbers::pi;
    for (int v = 0; v < mesh.num_vertices(); ++v)
        q.max_valence = std::max(q.max_valence, static_cast<int>(adjacent.vertex_triangles[v].size()));
    return q;
}

/// All pairs of triangles around a vertex are looked at: seconds up to here, hours for a fan of a million.
bool pairs_are_affordable(const Adjacency& adjacent) {
    double pairs = 0;
    for (int v = 0; v < adjacent.vertex_triangles.size(); ++v)
        pairs += 0.5 * std::pow(static_cast<double>(adjacent.vertex_triangles[v].size()), 2);
    return pairs <= 1e8;
}

Report examine(const std::string& file) {
    Report r{.surface = read_surface(file), .adjacent = {}, .facts = {}, .pairs = {}, .box = {}, .quality = {}};
    const TriMesh& mesh = r.surface.mesh;
    r.adjacent = adjacency(mesh);
    r.facts = topology(mesh, r.adjacent);
    if (pairs_are_affordable(r.adjacent)) r.pairs = intersections(mesh);
    r.box = bounding_box(mesh);
    r.diagonal = box_diagonal(mesh);
    r.area = surface_area(mesh);
    r.volume = enclosed_volume(mesh);
    r.quality = quality(mesh, r.adjacent);
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

nlohmann::ordered_json as_json(const Report& r) {
    const TriMesh& mesh = r.surface.mesh;
    const TopologyFacts& f = r.facts;
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
    if (r.pairs) {
        j["self_intersections"] = r.pairs->apart.size();
        j["adjacent_intersections"] = r.pairs->adjacent.size();
    }
    j["closed"] = f.closed;
    j["box"] = {{r.box.min.x(), r.box.min.y(), r.box.min.z()}, {r.box.max.x(), r.box.max.y(), r.box.max.z()}};
    j["diagonal"] = r.diagonal;
    j["area"] = r.area;
    j["volume"] = nullptr;
    if (f.closed) j["volume"] = r.volume;
    j["orientable"] = f.orientable;
    j["isolated_vertices"] = f.isolated_vertices.size();
    j["duplicate_vertices"] = f.duplicate_vertices.size();
    j["format"] = title_of(r.surface.format);
    j["file_vertices"] = r.surface.file_vertices;
    j["edge_length"] = {{"min", r.quality.edge_min}, {"mean", r.quality.edge_mean}, {"max", r.quality.edge_max}};
    j["angle_deg"] = {{"min", r.quality.angle_min_deg}, {"max", r.quality.angle_max_deg}};
    j["max_valence"] = r.quality.max_valence;
    j["groups"] = nlohmann::ordered_json::array();
    const auto counts = triangles_per_group(mesh);
    for (std::size_t g = 0; g < counts.size(); ++g)
        j["groups"].push_back({{"name", printable(mesh.group_names[g])}, {"triangles", counts[g]}});
    return j;
}

std::string first_few(std::size_t count, const auto& item) {
    std::string list;
    for (std::size_t i = 0; i < std::min<std::size_t>(count, 5); ++i) list += (i ? ", " : "") + item(i);
    return count > 5 ? list + ", ..." : list;
}

std::string first_few(const std::vector<int>& ids) {
    return first_few(ids.size(), [&](std::size_t i) { return std::to_string(ids[i]); });
}

std::string first_edges(const Report& r, const std::vector<int>& edges) {
    return first_few(edges.size(), [&](std::size_t i) {
        return text(r.adjacent.edges[edges[i]][0], "-", r.adjacent.edges[edges[i]][1]);
    });
}

std::string first_pairs(const std::vector<std::array<int, 2>>& pairs) {
    return first_few(pairs.size(), [&](std::size_t i) { return text(pairs[i][0], "/", pairs[i][1]); });
}

std::string first_loops(const Report& r) {
    const auto& loops = r.facts.boundary_loops;
    return first_few(loops.size(),
                     [&](std::size_t i) { return text(loops[i].size(), " vertices from ", loops[i].front()); });
}

/// Vertices on open boundaries with another one closer than `tolerance`: the two sides of a crack.
int crack_vertices(const Report& r, double tolerance) {
    // Swept along a direction in which no usual surface is flat.
    const Eigen::Vector3d direction = Eigen::Vector3d(0.8191, 0.4527, 0.3517).normalized();
    std::set<int> vertices;
    for (const auto& loop : r.facts.boundary_loops) vertices.insert(loop.begin(), loop.end());
    std::vector<std::pair<double, int>> sweep;
    const Points& p = r.surface.mesh.vertices;
    for (const int v : vertices) sweep.push_back({p.row(v).dot(direction), v});
    std::sort(sweep.begin(), sweep.end());
    std::vector<char> near(sweep.size());
    for (std::size_t i = 0; i < sweep.size(); ++i)
        for (std::size_t j = i + 1; j < sweep.size() && sweep[j].first - sweep[i].first <= tolerance; ++j)
            if ((p.row(sweep[j].second) - p.row(sweep[i].second)).norm() <= tolerance) near[i] = near[j] = 1;
    return static_cast<int>(std::count(near.begin(), near.end(), 1));
}

/// Every defect in a sentence of its own.
std::vector<std::string> defects(const Report& r) {
    std::vector<std::string> list;
    const auto add = [&](std::size_t count, const char* what, const std::string& ids) {
        if (count > 0) list.push_back(text(count, " ", what, ": ", ids));
    };
    const TopologyFacts& f = r.facts;
    add(f.boundary_loops.size(), "open boundary loop(s)", first_loops(r));
    const double tolerance = 1e-6 * r.diagonal;
    if (const int cracks = crack_vertices(r, tolerance); cracks > 0)
        list.push_back(text("cracks: ", cracks, " boundary vertices lie within 1e-6 diagonal of another; a weld with ",
                            "tolerance ", tolerance, " may close them"));
    add(f.nonmanifold_edges.size(), "non-manifold edge(s), more than two triangles, vertices",
        first_edges(r, f.nonmanifold_edges));
    add(f.nonmanifold_vertices.size(), "non-manifold vertex(es), triangles in more than one fan, vertices",
        first_few(f.nonmanifold_vertices));
    add(f.misoriented_edges.size(), "edge(s) whose two triangles disagree in orientation, vertices",
        first_edges(r, f.misoriented_edges));
    if (!f.orientable) list.push_back("not orientable: turning triangles cannot make them agree");
    if (f.closed && r.volume < 0) list.push_back("oriented inward: the enclosed volume is negative");
    add(f.duplicate_triangles.size(), "duplicate triangle(s), same vertices as an earlier one, triangles",
        first_few(f.duplicate_triangles));
    add(f.degenerate_triangles.size(), "degenerate triangle(s), area below 1e-14 diagonal^2, triangles",
        first_few(f.degenerate_triangles));
    add(f.isolated_vertices.size(), "isolated vertex(es), in no triangle, vertices", first_few(f.isolated_vertices));
    add(f.duplicate_vertices.size(), "duplicate vertex(es), at the place of an earlier one, vertices",
        first_few(f.duplicate_vertices));
    if (r.pairs) {
        add(r.pairs->apart.size(), "pair(s) of triangles intersect, triangles", first_pairs(r.pairs->apart));
        add(r.pairs->adjacent.size(), "pair(s) of neighbouring triangles overlap beside what they share, triangles",
            first_pairs(r.pairs->adjacent));
    } else {
        list.push_back(
            text("self-intersections were not looked for: a vertex has ", r.quality.max_valence, " triangles"));
    }
    return list;
}

void print(const std::string& words) {
    if (std::fputs(words.c_str(), stdout) < 0 || std::fflush(stdout) != 0)
        throw OutputError(text("standard output: cannot write: ", std::strerror(errno)));
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
    line("components", text(r.facts.components));
    const auto counts = triangles_per_group(mesh);
    if (!counts.empty())
        line("groups", text(counts.size(), ": ", first_few(counts.size(), [&](std::size_t g) {
                                return text(printable(mesh.group_names[g], 60), " (", counts[g], ")");
                            })));
    line("closed", r.facts.closed ? "yes" : "no");
    line("box", text(vector_text(r.box.min), "  to  ", vector_text(r.box.max)));
    line("diagonal", text(r.diagonal));
    line("area", text(r.area));
    line("volume", r.facts.closed ? text(r.volume) : "none, the surface is not closed");
    line("edge length", text(r.quality.edge_min, " to ", r.quality.edge_max, ", mean ", r.quality.edge_mean));
    line("angles", text(r.quality.angle_min_deg, " to ", r.quality.angle_max_deg, " degrees"));
    line("valence", text("at most ", r.quality.max_valence, " triangles at a vertex"));
    const auto list = defects(r);
    out += list.empty() ? "no defects\n" : "defects (numbers count from 0 in the order of the file):\n";
    for (const auto& d : list) out += "  " + d + "\n";
    print(out);
}

}  // namespace

void add_info(CLI::App& app) {
    struct Options {
        std::string surface;
        bool json = false;
    };
    auto options = std::make_shared<Options>();
    CLI::App* command = app.add_subcommand("info", "what a surface file holds, and what is wrong with it");
    command
        ->add_option("SURFACE", options->surface,
                     "STL, OBJ, PLY, OFF, Cart3D .tri, VTK, SU2, Gmsh or NASTRAN file, also packed (.gz)")
        ->required();
    command->add_flag("--json", options->json, "one JSON object instead of words");
    command->callback([options] {
        const Report r = examine(options->surface);
        if (options->json)
            print(as_json(r).dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
        else
            print_words(options->surface, r);
    });
}

}  // namespace strake::cli
