#include "cli/commands.hpp"
#include "cli/designs.hpp"
#include "cli/detail.hpp"
#include "cli/outputs.hpp"
#include "core/error.hpp"
#include "core/formats/io.hpp"
#include "core/formats/vtp.hpp"
#include "core/mesh/geometry.hpp"
#include "core/mesh/surface_distance.hpp"
#include "core/text/file.hpp"
#include "objectives/geometry/measures.hpp"
#include "optimize/run/stored_design.hpp"
#include "report/json_number.hpp"

#include <fmt/core.h>
#include <memory>
#include <nlohmann/json.hpp>

/// `strake compare`: the distance between two surfaces, where it is largest, and the change of volume and area.
namespace strake::cli {
namespace {

struct CompareArguments {
    std::string a, b, vtp;
    bool json = false;
};

/// A surface, with what a run folder adds.
struct Shape {
    TriMesh mesh;
    std::optional<SymmetryPlane> symmetry;
    std::vector<Patch> patches;  ///< of the run's best design
};

struct PatchDifference {
    std::string name;
    SurfaceDistance distance;       ///< from the run's surface to the other one
    double area_a = 0, area_b = 0;  ///< of the same triangles; NaN for a surface with other triangles
};

struct Compared {
    SurfaceDistance ab, ba;
    double area_a = 0, area_b = 0, volume_a = 0, volume_b = 0, diagonal = 0;  ///< volume NaN: not closed
    Points displacement;  ///< n x 3 from A to B; empty: different triangles
    std::vector<PatchDifference> patches;
};

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

Shape read_shape(const std::string& path, bool at_start = false) {
    if (!is_run_folder(path)) return {read_logged(path).mesh, {}, {}};
    const Deformation d = run_deformation(path);
    const StoredDesign design = read_design(std::filesystem::path(path) / "levels/best.design");
    Shape out{at_start ? d.rest : with_vertices(d.rest, d.vertices), d.symmetry, {}};
    for (const auto& [level, id] : design.front)
        out.patches.push_back(
            design.tree.levels.at(static_cast<std::size_t>(level)).patches.at(static_cast<std::size_t>(id)));
    return out;
}

double volume_of(const TriMesh& mesh, const std::optional<SymmetryPlane>& symmetry) {
    try {
        const QuantityResult result = volume(mesh, symmetry).evaluate({mesh, false, 0, 0, {}});
        return result.failure ? nan : result.values.at(0);
    } catch (const InvalidInput&) {
        return nan;  // open
    }
}

double area_of(const TriMesh& mesh, const std::vector<int>& triangles) {
    double sum = 0;
    for (const int t : triangles) sum += area_vector(mesh, t).norm();
    return sum;
}

Compared compare(const Shape& a, const Shape& b) {
    Compared out;
    out.ab = surface_distance(a.mesh, b.mesh);
    out.ba = surface_distance(b.mesh, a.mesh);
    out.diagonal = box_diagonal(a.mesh);
    out.area_a = surface_area(a.mesh);
    out.area_b = surface_area(b.mesh);
    const auto& plane = a.symmetry ? a.symmetry : b.symmetry;
    out.volume_a = volume_of(a.mesh, plane);
    out.volume_b = volume_of(b.mesh, plane);
    const bool alike = same_triangles(a.mesh, b.mesh);
    if (alike) out.displacement = b.mesh.vertices - a.mesh.vertices;
    const bool of_b = !b.patches.empty();
    const Shape &with_patches = of_b ? b : a, &other = of_b ? a : b;
    for (const Patch& patch : with_patches.patches) {
        PatchDifference p{patch.name, surface_distance(with_patches.mesh, other.mesh, patch.triangles), nan, nan};
        if (alike || !of_b) p.area_a = area_of(a.mesh, patch.triangles);
        if (alike || of_b) p.area_b = area_of(b.mesh, patch.triangles);
        out.patches.push_back(std::move(p));
    }
    return out;
}

nlohmann::ordered_json json_of(const Eigen::Vector3d& x) { return {x[0], x[1], x[2]}; }

nlohmann::ordered_json json_of(const SurfaceDistance& d) {
    return {{"max", json_number(d.max)}, {"mean", json_number(d.mean)},   {"rms", json_number(d.rms)},
            {"at", json_of(d.at)},       {"nearest", json_of(d.nearest)}, {"triangle", d.triangle}};
}

Eigen::Index largest_row(const Points& rows) {
    Eigen::Index worst = 0;
    rows.rowwise().squaredNorm().maxCoeff(&worst);
    return worst;
}

void print_json(const Compared& c) {
    nlohmann::ordered_json j;
    j["distance"] = {
        {"a_to_b", json_of(c.ab)}, {"b_to_a", json_of(c.ba)}, {"max", json_number(std::max(c.ab.max, c.ba.max))}};
    j["diagonal"] = json_number(c.diagonal);
    j["area"] = {{"a", json_number(c.area_a)}, {"b", json_number(c.area_b)}};
    j["volume"] = {{"a", json_number(c.volume_a)}, {"b", json_number(c.volume_b)}};
    j["same_triangles"] = c.displacement.rows() > 0;
    if (c.displacement.rows() > 0) {
        const Eigen::Index v = largest_row(c.displacement);
        j["displacement"] = {{"max", json_number(c.displacement.row(v).norm())},
                             {"vertex", v},
                             {"rms", json_number(std::sqrt(c.displacement.rowwise().squaredNorm().mean()))}};
    }
    nlohmann::ordered_json patches = nlohmann::ordered_json::array();
    for (const PatchDifference& p : c.patches)
        patches.push_back({{"name", p.name},
                           {"distance", json_of(p.distance)},
                           {"area", {{"a", json_number(p.area_a)}, {"b", json_number(p.area_b)}}}});
    if (!c.patches.empty()) j["patches"] = patches;
    fmt::print("{}\n", j.dump(2));
}

std::string words(const Eigen::Vector3d& x) { return fmt::format("({:.6g}, {:.6g}, {:.6g})", x[0], x[1], x[2]); }

void print_distance(const char* title, const SurfaceDistance& d, double diagonal) {
    fmt::print("{}  max {:.6g} ({:.3g} % of the diagonal) at {}, mean {:.6g}, rms {:.6g}\n", title, d.max,
               100 * d.max / diagonal, words(d.at), d.mean, d.rms);
}

void print_change(const char* title, double a, double b) {
    if (std::isnan(a) || std::isnan(b)) return fmt::print("{}  unknown: both surfaces must be closed\n", title);
    fmt::print("{}  {:.10g} and {:.10g} ({:+.4g} %)\n", title, a, b, 100 * (b - a) / a);
}

void print_words(const Compared& c) {
    print_distance("A to B      ", c.ab, c.diagonal);
    print_distance("B to A      ", c.ba, c.diagonal);
    if (c.displacement.rows() > 0) {
        const Eigen::Index v = largest_row(c.displacement);
        fmt::print("displacement  max {:.6g} at vertex {}, rms {:.6g}: same triangles\n", c.displacement.row(v).norm(),
                   v, std::sqrt(c.displacement.rowwise().squaredNorm().mean()));
    }
    print_change("volume      ", c.volume_a, c.volume_b);
    print_change("area        ", c.area_a, c.area_b);
    if (c.patches.empty()) return;
    fmt::print("{:<16} {:>12} {:>12} {:>10}\n", "patch", "max", "rms", "area");
    for (const PatchDifference& p : c.patches) {
        const std::string area =
            std::isnan(p.area_a + p.area_b) ? "" : fmt::format("{:+.3g} %", 100 * (p.area_b - p.area_a) / p.area_a);
        fmt::print("{:<16} {:>12.6g} {:>12.6g} {:>10}\n", p.name, p.distance.max, p.distance.rms, area);
    }
}

/// Displacement along area-weighted vertex normals.
Eigen::VectorXd along_normals(const TriMesh& mesh, const Points& displacement) {
    Points normal = Points::Zero(mesh.num_vertices(), 3);
    for (int t = 0; t < mesh.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k) normal.row(mesh.triangles(t, k)) += area_vector(mesh, t).transpose();
    Eigen::VectorXd out(mesh.num_vertices());
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        const double size = normal.row(v).norm();
        out[v] = size > 0 ? displacement.row(v).dot(normal.row(v)) / size : 0;
    }
    return out;
}

/// A with its distance from B; 0 at vertices without a triangle.
void write(const CompareArguments& args, const Shape& a, const Compared& c) {
    const Eigen::VectorXd distance = c.ab.at_vertices.array().isNaN().select(0, c.ab.at_vertices);
    std::vector<Field> fields{{"Distance", distance}};
    if (c.displacement.rows() > 0) {
        fields.push_back({"Displacement", c.displacement});
        fields.push_back({"NormalDisplacement", along_normals(a.mesh, c.displacement)});
    }
    write_vtp(args.vtp, a.mesh, fields);
}

void run(const CompareArguments& args) {
    check_outputs({args.vtp}, {args.a, args.b});
    if (args.b.empty() && !is_run_folder(args.a))
        throw InvalidInput(printable(args.a, 400) +
                           ": needs a second surface; give one, or a run folder (compares its start with its best "
                           "design)");
    const Shape a = read_shape(args.a, args.b.empty()), b = read_shape(args.b.empty() ? args.a : args.b);
    const Compared compared = compare(a, b);
    if (!args.vtp.empty()) write(args, a, compared);
    args.json ? print_json(compared) : print_words(compared);
}

}  // namespace

void add_compare(CLI::App& app) {
    auto args = std::make_shared<CompareArguments>();
    CLI::App* command = app.add_subcommand(
        "compare", "measure the distance between two surfaces, both ways, with volume, area and patches");
    command->add_option("A", args->a, "surface file, or run folder: its best design")->required();
    command->add_option("B", args->b,
                        "likewise; without it A must be a run, and its start is compared with its best design");
    command->add_option("--vtp", args->vtp, "write A with its distance from B, for ParaView");
    command->add_flag("--json", args->json, "print one JSON object instead of words");
    command->callback([args] { run(*args); });
}

}  // namespace strake::cli
