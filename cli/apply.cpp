#include "cases/case.hpp"
#include "cases/prepare_surface.hpp"
#include "cli/commands.hpp"
#include "cli/outputs.hpp"
#include "core/error.hpp"
#include "core/mesh/file.hpp"
#include "core/mesh/geometry.hpp"
#include "core/mesh/io.hpp"
#include "core/mesh/npy.hpp"
#include "core/mesh/surface_map.hpp"
#include "core/mesh/vtp.hpp"
#include "objectives/external/gradient.hpp"
#include "objectives/external/refused.hpp"
#include "objectives/point_list.hpp"
#include "optimize/stored_design.hpp"
#include "report/json_number.hpp"

#include <fmt/core.h>
#include <memory>
#include <nlohmann/json.hpp>

/// `strake apply`: other points move as the surface of a run did.
namespace strake::cli {
namespace {

namespace fs = std::filesystem;

struct ApplyArguments {
    std::string run, other, out, design, sensitivities;
    int evaluation = 0;
    double reach = SurfaceMapOptions{}.reach;
    bool json = false;
};

constexpr double gentle = 0.2;  // displacement by reach up to which the map outside is far from folding

struct Deformation {
    TriMesh rest;
    Points vertices;
    int evaluation = 0;
    std::optional<SymmetryPlane> symmetry;
};

/// The vertices of an evaluation from the ParaView series.
Points shape_of(const ApplyArguments& args, const TriMesh& rest) {
    const fs::path file = fs::path(args.run) / fmt::format("series/design_{:06d}.vtp", args.evaluation);
    std::error_code ignored;
    if (!fs::exists(file, ignored))
        throw InvalidInput(
            fmt::format("{}: the shape of evaluation {} was not kept (there is no {}); kept are those "
                        "that output.paraview says",
                        printable(args.run, 400), args.evaluation, file.filename().string()));
    const TriMesh shape = read_surface(file).mesh;
    if (shape.num_vertices() != rest.num_vertices() || shape.triangles != rest.triangles)
        throw InputError(fmt::format("{}: is of another surface than the case's", printable(file.string(), 400)));
    return shape.vertices;
}

Deformation deformation_of(const ApplyArguments& args) {
    const fs::path run = args.run;
    std::error_code ignored;
    if (!fs::exists(run / "case.yaml", ignored))
        throw InvalidInput(fmt::format("{}: holds no run (there is no case.yaml)", printable(args.run, 400)));
    const fs::path file = args.design.empty() ? run / "levels/best.design" : fs::path(args.design);
    if (args.design.empty() && !fs::exists(file, ignored))
        throw InvalidInput(fmt::format("{}: the run has no design yet (there is no {})", printable(args.run, 400),
                                       "levels/best.design"));
    const Case the_case = load_case(run / "case.yaml");
    if (args.evaluation > 0) {
        Deformation d{prepare_surface(the_case).mesh, {}, args.evaluation, the_case.symmetry};
        d.vertices = shape_of(args, d.rest);
        return d;
    }
    const StoredDesign design = read_design(file);
    Deformation d{prepare_surface(the_case).mesh, design.vertices, design.evaluation, the_case.symmetry};
    check_surface(design, d.rest);
    return d;
}

struct Applied {
    int points = 0, evaluation = 0, on_surface = 0, still = 0;
    double diagonal = 0, max_displacement = 0, max_distance = 0, max_surface_displacement = 0;
};

/// Gradients at the moved points become gradients at the run's vertices.
void carry_back(const ApplyArguments& args, const Deformation& d, const SurfaceMap& map, const Points& moved,
                const std::vector<std::int64_t>& ids) {
    GradientPlaces places;
    places.at = moved;
    places.ids = ids;
    places.tolerance = 1e-5 * box_diagonal(d.rest);
    places.whole = "OTHER";
    places.one = "point";
    places.many = "points";
    Points back;
    try {
        back = map.transpose(parse_gradient(read_bytes(args.sensitivities), args.sensitivities, places));
    } catch (const Refused& refused) {
        throw InputError(refused.failure.message);
    }
    if (fs::path(args.out).extension() == ".vtp")
        return write_vtp(args.out, with_vertices(d.rest, d.vertices), {{"Sensitivity", back}});
    if (is_npy(args.out)) return write_atomically(args.out, npy_bytes(back));
    std::string rows = "index,dJ/dx,dJ/dy,dJ/dz\n";
    for (Eigen::Index v = 0; v < back.rows(); ++v)
        rows += fmt::format("{},{},{},{}\n", v, back(v, 0), back(v, 1), back(v, 2));
    write_atomically(args.out, rows);
}

Applied apply(const ApplyArguments& args) {
    const bool is_list = is_point_list(args.other), goes_back = !args.sensitivities.empty();
    const std::string kind = fs::path(args.out).extension();
    if (goes_back && kind != ".csv" && kind != ".npy" && kind != ".vtp")
        throw InvalidInput(
            fmt::format("{}: sensitivities are written as .csv, .npy or .vtp", printable(args.out, 400)));
    if (is_list && !goes_back && !is_point_list(args.out))
        throw InvalidInput(fmt::format("{}: {} is a list of points, not a surface: write .csv or .npy",
                                       printable(args.out, 400), printable(args.other, 400)));
    const SurfaceFormat format = goes_back || is_point_list(args.out) ? SurfaceFormat::obj : format_of(args.out);
    const Deformation d = deformation_of(args);
    TriMesh other;
    NumberedPoints list;
    if (is_list)
        other.vertices = (list = read_points(args.other)).at;
    else
        other = read_surface(args.other).mesh;
    const SurfaceMap map(d.rest, other.vertices, {args.reach, d.symmetry});
    const Points moved = map.moved(d.vertices);
    if (!moved.allFinite()) throw SolverError("apply: a moved point is not finite");
    if (goes_back)
        carry_back(args, d, map, moved, list.ids);
    else if (is_point_list(args.out))
        write_points(args.out, {moved, list.ids});
    else
        write_surface(args.out, with_vertices(other, moved), format);
    Applied told;
    told.points = map.num_points();
    told.evaluation = d.evaluation;
    told.diagonal = box_diagonal(d.rest);
    const Eigen::VectorXd by = (moved - other.vertices).rowwise().norm();
    if (by.size() > 0) told.max_displacement = by.maxCoeff(), told.max_distance = map.distances().maxCoeff();
    told.on_surface = static_cast<int>((map.distances().array() <= 1e-9 * told.diagonal).count());
    told.still = static_cast<int>((map.distances().array() >= args.reach * told.diagonal).count());
    told.max_surface_displacement = (d.vertices - d.rest.vertices).rowwise().norm().maxCoeff();
    return told;
}

void report(const ApplyArguments& args, const Applied& told) {
    if (told.max_surface_displacement > gentle * args.reach * told.diagonal)
        fmt::print(stderr,
                   "warning: the surface moves by {:.3g}, more than a fifth of the reach of {:.3g}: cells between may "
                   "fold; raise --reach\n",
                   told.max_surface_displacement, args.reach * told.diagonal);
    if (args.json) {
        nlohmann::ordered_json j;
        j["status"] = "ok";
        j["evaluation"] = told.evaluation;
        j["points"] = told.points;
        j["on_surface"] = told.on_surface;
        j["beyond_reach"] = told.still;
        j["max_displacement"] = json_number(told.max_displacement);
        j["max_distance"] = json_number(told.max_distance);
        j["file"] = args.out;
        fmt::print("{}\n", j.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
        return;
    }
    fmt::print("design            evaluation {}\n", told.evaluation);
    fmt::print("points            {}: {} on the surface, {} beyond the reach\n", told.points, told.on_surface,
               told.still);
    fmt::print("max displacement  {:.6g} ({:.3g} % of the diagonal)\n", told.max_displacement,
               100 * told.max_displacement / told.diagonal);
    fmt::print("max distance      {:.6g} from the surface\n", told.max_distance);
}

}  // namespace

void add_apply(CLI::App& app) {
    auto args = std::make_shared<ApplyArguments>();
    CLI::App* command = app.add_subcommand("apply", "moves other points as the surface of a run did");
    command->add_option("RUN", args->run, "folder of the run")->required();
    command->add_option("OTHER", args->other, "surface file, or points as .csv or .npy, where they were at the start")
        ->required();
    command->add_option("-o,--out", args->out, "where they go: a surface, .csv or .npy")->required();
    command->add_option("--design", args->design, "another design of the run than levels/best.design");
    command->add_option("--evaluation", args->evaluation, "another one than the best, from the ParaView series")
        ->check(CLI::Range(1, 1000000000))
        ->excludes("--design");
    command->add_option("--sensitivities", args->sensitivities,
                        "gradients at the points of OTHER (moved): written are those at the run's vertices");
    command->add_option("--reach", args->reach, "distance beyond which nothing moves, in diagonals of the surface")
        ->capture_default_str();
    command->add_flag("--json", args->json, "one JSON object instead of words");
    command->callback([args] {
        check_outputs({args->out}, {args->other, args->design, args->sensitivities});
        report(*args, apply(*args));
    });
}

}  // namespace strake::cli
