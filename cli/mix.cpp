#include "casefile/build/build_problem.hpp"
#include "casefile/load_case.hpp"
#include "cli/commands.hpp"
#include "cli/continuation.hpp"
#include "cli/designs.hpp"
#include "cli/detail.hpp"
#include "cli/outputs.hpp"
#include "core/error.hpp"
#include "core/formats/io.hpp"
#include "core/mesh/geometry.hpp"
#include "core/mesh/topology.hpp"
#include "core/text/file.hpp"
#include "optimize/run/mixed_design.hpp"
#include "report/json_number.hpp"

#include <fmt/core.h>
#include <memory>
#include <nlohmann/json.hpp>

/// `strake mix`: blends two shapes.
namespace strake::cli {
namespace {

namespace fs = std::filesystem;

constexpr double max_weight = 10;

struct MixArguments {
    std::string a, b, out;
    double weight = 0.5;
    bool linear = false, json = false;
};

struct Mixed {
    TriMesh surface;
    std::string kind;  ///< equilibrium | linear
    double from_a = 0, from_b = 0, diagonal = 0;
    int new_intersections = 0;
    bool has_limit = false;  ///< that of A's case is known
    std::string beyond;      ///< it, in words; empty: within
};

DesignOfRun design_of(const fs::path& run) {
    Case the_case = load_case(run / "case.yaml");
    keep_meaning(the_case, std::max(1, written_meaning(run)));
    return {build_problem(the_case).problem,
            std::make_shared<const StoredDesign>(read_design(run / "levels/best.design"))};
}

/// A run's best design, or a surface.
TriMesh shape_of(const std::string& path) {
    if (!is_run_folder(path)) return read_logged(path).mesh;
    const Deformation d = run_deformation(path);
    return with_vertices(d.rest, d.vertices);
}

/// Between two runs.
MixedDesign equilibrium(const MixArguments& args) {
    MixedDesign mixed = mixed_design(design_of(args.a), design_of(args.b), args.weight);
    const std::string why = mixed.end.status != SolveStatus::converged ? mixed.end.reason : mixed.defect;
    if (why.empty()) return mixed;
    fmt::print(stderr, "strake: mix: {}; nothing was written; --linear blends the vertex positions instead\n", why);
    throw ExitStatus{run_failed};
}

Mixed mix(const MixArguments& args) {
    if (!(std::abs(args.weight) <= max_weight))
        throw InvalidInput(fmt::format("--weight {} must be within -10 and 10; 0 is A, 1 is B", args.weight));
    const SurfaceFormat format = format_of(args.out);
    const TriMesh a = shape_of(args.a), b = shape_of(args.b);
    if (!same_triangles(a, b))
        throw InvalidInput(
            fmt::format("{} and {} have different triangles ({} and {}, with {} and {} vertices); first map one onto "
                        "the other with "
                        "`strake apply` or `strake fit`",
                        printable(args.a, 400), printable(args.b, 400), a.num_triangles(), b.num_triangles(),
                        a.num_vertices(), b.num_vertices()));
    Mixed out{a, "linear", 0, 0, box_diagonal(a), 0, false, ""};
    const bool between_designs = !args.linear && is_run_folder(args.a) && is_run_folder(args.b);
    if (args.weight == 0)
        out.surface.vertices = a.vertices;
    else if (args.weight == 1)
        out.surface.vertices = b.vertices;
    else if (between_designs) {
        MixedDesign mixed = equilibrium(args);
        out.surface.vertices = std::move(mixed.vertices);
        out.has_limit = true;
        out.beyond = std::move(mixed.beyond);
    } else
        out.surface.vertices = (1 - args.weight) * a.vertices + args.weight * b.vertices;
    if (between_designs) out.kind = "equilibrium";
    if (!out.surface.vertices.allFinite()) throw SolverError("mix: a vertex is not finite");
    if (!between_designs) {
        const auto count = [](const TriMesh& m) { return static_cast<int>(self_intersections(m).size()); };
        out.new_intersections = std::max(0, count(out.surface) - std::max(count(a), count(b)));
    }
    out.from_a = (out.surface.vertices - a.vertices).rowwise().norm().maxCoeff();
    out.from_b = (out.surface.vertices - b.vertices).rowwise().norm().maxCoeff();
    write_output(args.out, out.surface, format);
    return out;
}

void report(const MixArguments& args, const Mixed& mixed) {
    if (mixed.new_intersections > 0)
        fmt::print(stderr, "warning: {} more pairs of triangles intersect than in A or B\n", mixed.new_intersections);
    if (!mixed.beyond.empty()) fmt::print(stderr, "warning: beyond max_displacement of A's case: {}\n", mixed.beyond);
    if (!args.json) {
        fmt::print("mixed             {} of A, {} of B, {}\n", 1 - args.weight, args.weight,
                   mixed.kind == "linear" ? "vertices along straight lines" : "by their variables, in equilibrium");
        fmt::print("distance          {:.6g} from A, {:.6g} from B ({:.3g} and {:.3g} % of the diagonal)\n",
                   mixed.from_a, mixed.from_b, 100 * mixed.from_a / mixed.diagonal,
                   100 * mixed.from_b / mixed.diagonal);
        return;
    }
    nlohmann::ordered_json j;
    j["status"] = "ok";
    j["kind"] = mixed.kind;
    j["weight"] = args.weight;
    j["max_from_a"] = json_number(mixed.from_a);
    j["max_from_b"] = json_number(mixed.from_b);
    j["new_intersections"] = mixed.new_intersections;
    if (mixed.has_limit) j["beyond_motion_limit"] = !mixed.beyond.empty();
    j["file"] = args.out;
    fmt::print("{}\n", j.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
}

}  // namespace

void add_mix(CLI::App& app) {
    auto args = std::make_shared<MixArguments>();
    CLI::App* command = app.add_subcommand("mix", "blend two designs or surfaces with the same triangles");
    command->add_option("A", args->a, "run folder (its best design), or a surface file")->required();
    command->add_option("B", args->b, "likewise")->required();
    command->add_option("-o,--out,--output", args->out, "surface file; the extension selects the format")->required();
    command->add_option("--weight", args->weight,
                        "weight of B: 0 is A, 1 is B, values outside extrapolate (default: 0.5)");
    command->add_flag("--linear", args->linear,
                      "blend vertex positions along straight lines, also for two runs, without an equilibrium");
    command->add_flag("--json", args->json, "print one JSON object instead of words");
    command->callback([args] {
        check_outputs({args->out}, {args->a, args->b});
        report(*args, mix(*args));
    });
}

}  // namespace strake::cli
