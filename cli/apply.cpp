#include "casefile/yaml/diagnostics.hpp"
#include "cli/applied.hpp"
#include "cli/commands.hpp"
#include "cli/designs.hpp"
#include "cli/detail.hpp"
#include "cli/outputs.hpp"
#include "core/error.hpp"
#include "core/formats/io.hpp"
#include "core/formats/npy.hpp"
#include "core/formats/vtp.hpp"
#include "core/mesh/geometry.hpp"
#include "core/mesh/surface_unmap.hpp"
#include "core/text/file.hpp"
#include "core/volume/cell_check.hpp"
#include "core/volume/held_boundary.hpp"
#include "core/volume/volume_file.hpp"
#include "objectives/external/gradient.hpp"
#include "objectives/external/point_list.hpp"
#include "objectives/external/refused.hpp"

#include <fmt/core.h>
#include <algorithm>
#include <memory>

/// `strake apply`: moves other points the way the surface of a run moved.
namespace strake::cli {
namespace {

namespace fs = std::filesystem;

enum class Kind { surface, list, volume };

/// What to move.
struct Other {
    Kind kind = Kind::surface;
    TriMesh surface;                                   ///< for a surface
    SurfaceFormat format = SurfaceFormat::stl_binary;  ///< of the surface's file
    NumberedPoints list;                               ///< for a list
    VolumeFile volume;                                 ///< of the mesh of a volume
    const Points& points() const {
        return kind == Kind::surface ? surface.vertices : kind == Kind::list ? list.at : volume.mesh.points;
    }
};

/// A volume mesh stays one, except an .su2 when a surface is requested: then its surface is used.
Kind kind_of(const ApplyArguments& args) {
    if (is_point_list(args.other)) return Kind::list;
    const bool is_su2 = fs::path(args.other).extension() == ".su2";
    if (is_su2 && (fs::path(args.out).extension() != ".su2" || !args.sensitivities.empty())) return Kind::surface;
    return is_volume(args.other) ? Kind::volume : Kind::surface;
}

void check_hold(const ApplyArguments& args, Kind kind) {
    if (args.hold.empty()) return;
    const std::string other = printable(args.other, 400), name = printable(args.hold.front());
    if (kind == Kind::surface && fs::path(args.other).extension() == ".su2")
        throw InvalidInput(
            fmt::format("--hold {}: only the surface of {} moves when -o is not an .su2; write an .su2, or omit --hold",
                        name, other));
    if (kind != Kind::volume)
        throw InvalidInput(fmt::format(
            "--hold {}: it holds a boundary of a volume mesh, but {} is a {}; omit --hold, or give the mesh (a "
            "polyMesh folder, .su2)",
            name, other, kind == Kind::list ? "list of points" : "surface"));
    if (args.undo)
        throw InvalidInput(fmt::format(
            "--hold {}: --undo cannot restore a mesh that was moved with --hold; use the original mesh and omit both",
            name));
}

/// @throws InvalidInput for a name that no boundary has, listing the existing ones.
void check_held(const ApplyArguments& args, const VolumeFile& file) {
    std::vector<std::string> known;
    for (const BoundaryPart& part : file.mesh.boundary) known.push_back(part.name);
    for (const std::string& name : args.hold) {
        if (std::count(known.begin(), known.end(), name) > 0) continue;
        std::string there;
        for (const std::string& one : known) there += (there.empty() ? "" : ", ") + printable(one);
        const std::string like = nearest(name, known), what = "--hold " + printable(name) + ": ",
                          mesh = printable(args.other, 400);
        if (!known.empty())
            throw InvalidInput(what + mesh + " has no boundary of this name" +
                               (like.empty() ? "" : "; did you mean '" + printable(like) + "'?") +
                               " Boundaries: " + there);
        throw InvalidInput(
            what + mesh +
            (file.format == VolumeFormat::open_foam && file.folder.empty()
                 ? " has no boundary file beside it; give the polyMesh folder"
                 : " names no boundaries; omit --hold, and lower --reach to keep distant points in place"));
    }
}

void check_names(const ApplyArguments& args, Kind kind) {
    const std::string out = printable(args.out, 400), ending = fs::path(args.out).extension();
    check_hold(args, kind);
    if (!args.sensitivities.empty()) {
        if (args.undo) throw InvalidInput("--sensitivities belong to points at the start; omit --undo");
        if (kind == Kind::volume)
            throw InvalidInput("--sensitivities: give the points of the mesh as .csv or .npy instead of the mesh");
        if (ending != ".csv" && ending != ".npy" && ending != ".vtp")
            throw InvalidInput(out + ": sensitivities can be written as .csv, .npy or .vtp");
        return;
    }
    if (kind == Kind::volume) return check_volume_output(args.out, args.other);
    if (kind == Kind::list && !is_point_list(args.out))
        throw InvalidInput(fmt::format("{}: {} is a list of points, not a surface; write .csv or .npy", out,
                                       printable(args.other, 400)));
    if (!is_point_list(args.out)) format_of(args.out);
}

Other read_other(const ApplyArguments& args, Kind kind) {
    Other other;
    other.kind = kind;
    if (kind == Kind::list) other.list = read_points(args.other);
    if (kind == Kind::surface) {
        SurfaceFile file = read_logged(args.other);
        other.surface = std::move(file.mesh);
        other.format = file.format;
    }
    if (kind == Kind::volume) other.volume = read_volume(args.other);
    return other;
}

Deformation deformation_of(const ApplyArguments& args) {
    if (args.moved.empty()) return run_deformation(args.run, args.design, args.evaluation);
    return surface_deformation(args.run, args.moved);
}

void write_moved(const ApplyArguments& args, const Other& other, const Points& moved) {
    if (other.kind == Kind::volume) return write_volume(args.out, other.volume, moved);
    if (is_point_list(args.out)) return write_points(args.out, {moved, other.list.ids, other.list.text});
    write_output(args.out, with_vertices(other.surface, moved), other.format);
}

constexpr double column_tolerance = 1e-6;  ///< diagonals, as for the surface

bool is_extruded(const Deformation& d) { return d.kind && d.kind->type == ShapeKind::Type::extruded; }

/// A two-dimensional mesh stays one: what moves a column is the mean over its points.
Points in_columns(const Deformation& d, const Points& from, const Points& to) {
    if (!is_extruded(d) || !to.allFinite()) return to;
    return from + motion_of_columns(from, d.kind->axis, column_tolerance * box_diagonal(d.rest), to - from);
}

/// Gradients at the moved points become gradients at the run's vertices.
void carry_back(const ApplyArguments& args, const Deformation& d, const SurfaceMap& map, const Points& from,
                const Points& moved, const std::vector<std::int64_t>& ids) {
    GradientPlaces places;
    places.at = moved;
    places.ids = ids;
    places.tolerance = 1e-5 * box_diagonal(d.rest);
    places.whole = "OTHER";
    places.one = "point";
    places.many = "points";
    Points back;
    try {
        Points given = parse_gradient(read_bytes(args.sensitivities), args.sensitivities, places);
        if (is_extruded(d))
            given = motion_of_columns(from, d.kind->axis, column_tolerance * box_diagonal(d.rest), given);
        back = map.transpose(given);
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

Applied facts(const ApplyArguments& args, const Deformation& d, const Points& from, const Points& to,
              const Eigen::VectorXd& distances) {
    Applied applied;
    applied.points = static_cast<int>(from.rows());
    applied.evaluation = d.evaluation;
    applied.diagonal = box_diagonal(d.rest);
    const Eigen::VectorXd by = (to - from).rowwise().norm();
    if (by.size() > 0) applied.max_displacement = by.maxCoeff(), applied.max_distance = distances.maxCoeff();
    if (by.size() > 0) applied.min_distance = distances.minCoeff();
    applied.on_surface = static_cast<int>((distances.array() <= 1e-9 * applied.diagonal).count());
    applied.beyond_reach = static_cast<int>((distances.array() >= args.reach * applied.diagonal).count());
    applied.max_surface_displacement = (d.vertices - d.rest.vertices).rowwise().norm().maxCoeff();
    return applied;
}

/// A surface that hardly comes near the start surface is another body: moving it means nothing.
void check_is_of_run(const ApplyArguments& args, const Other& other, const Applied& applied,
                     const Eigen::VectorXd& distances) {
    constexpr double far = 1e-3;  // diagonals: another mesh of the same shape comes nearer
    constexpr double few = 0.01,
                     most = 0.5;  // shares of the vertices; a part that is attached has some beside the host
    if (other.kind != Kind::surface || args.undo || args.force || applied.points == 0) return;
    const auto near = static_cast<int>((distances.array() <= far * applied.diagonal).count());
    if (near > 0 && near >= few * applied.points) {
        if (near < most * applied.points)
            fmt::print(stderr,
                       "strake: warning: only {} of the {} vertices of {} lie on the start surface of {}: is it the "
                       "surface that belongs to this run?\n",
                       near, applied.points, printable(args.other, 400), printable(args.run, 400));
        return;
    }
    throw InvalidInput(
        fmt::format("{}: {} of its {} vertices lies on the start surface of {} (the nearest is {:.3g} away, {:.3g} "
                    "diagonals); give the surface that belongs to this run, or --force to move this one all the same",
                    printable(args.other, 400), near == 0 ? "none" : fmt::format("only {}", near), applied.points,
                    printable(args.run, 400), applied.min_distance, applied.min_distance / applied.diagonal));
}

Applied apply(const ApplyArguments& args) {
    const Kind kind = kind_of(args);
    check_names(args, kind);
    const Deformation d = deformation_of(args);
    const Other other = read_other(args, kind);
    if (!args.hold.empty()) check_held(args, other.volume);
    const Points& from = other.points();
    const SurfaceMapOptions options{args.reach, d.symmetry};
    const SurfaceMap map(args.undo ? with_vertices(d.rest, d.vertices) : d.rest, from, options);
    std::optional<Unmapped> undone;
    if (args.undo) undone = unmap(d.rest, d.vertices, from, options);
    Points to = args.undo ? undone->points : map.moved(d.vertices);
    if (!args.hold.empty())
        to = from + hold_factors(other.volume.mesh, args.hold, map.distances()).asDiagonal() * (to - from);
    if (!args.undo) to = in_columns(d, from, to);
    if (!to.allFinite()) throw SolverError("apply: a moved point is not finite");
    Applied applied = facts(args, d, from, to, map.distances());
    check_is_of_run(args, other, applied, map.distances());
    applied.undone = undone;
    if (is_npy(args.out) && args.sensitivities.empty()) applied.lost_columns = other_columns(other.list);
    if (kind == Kind::volume && other.volume.mesh.num_cells > 0)
        applied.cells = check_cells(other.volume.mesh, from, to);
    if (kind == Kind::volume) applied.unchecked_cells = other.volume.mesh.num_unchecked;
    applied.written = args.force || !applied.cells || applied.cells->newly_bad == 0;
    if (!args.sensitivities.empty())
        carry_back(args, d, map, from, to, other.list.ids);
    else if (applied.written)
        write_moved(args, other, to);
    return applied;
}

}  // namespace

void add_apply(CLI::App& app) {
    auto args = std::make_shared<ApplyArguments>();
    CLI::App* command =
        app.add_subcommand("apply", "move other points, surfaces and volume meshes the way a run moved its surface");
    command->add_option("RUN", args->run, "run folder; with --moved a surface file")->required();
    command
        ->add_option(
            "OTHER", args->other,
            "what to move, at its start: surface; points (.csv, .npy); volume mesh (polyMesh folder or its points, "
            ".su2, .vtu)")
        ->required();
    command
        ->add_option("-o,--out,--output", args->out,
                     "output: a surface, .csv or .npy; for a volume mesh the format of OTHER")
        ->required();
    CLI::Option* design =
        command->add_option("--design", args->design, "design file to use instead of levels/best.design");
    CLI::Option* evaluation = command
                                  ->add_option("--evaluation", args->evaluation,
                                               "evaluation to use instead of the best, from the ParaView series")
                                  ->check(CLI::Range(1, 1000000000))
                                  ->excludes(design);
    command->add_option("--moved", args->moved, "instead of a run: the moved surface of RUN, with the same triangles")
        ->excludes(design)
        ->excludes(evaluation);
    command->add_option("--sensitivities", args->sensitivities,
                        "gradients at the moved points of OTHER; writes the gradients at the run's vertices");
    command->add_option("--reach", args->reach, "distance beyond which nothing moves, in surface diagonals")
        ->capture_default_str();
    command->add_option("--hold", args->hold, "boundary of the volume mesh to hold: a patch or marker (repeatable)");
    command->add_flag("--undo", args->undo, "OTHER has been moved by the design: move it back to the start");
    command->add_flag(
        "--force", args->force,
        "write a volume mesh even if it has inverted cells; move a surface even if it is of another body");
    command->add_flag("--json", args->json, "print one JSON object instead of words");
    command->callback([args] {
        check_outputs({args->out}, {args->other, args->design, args->moved, args->sensitivities});
        const Applied applied = apply(*args);
        warn(*args, applied);
        args->json ? print_json(*args, applied) : print_words(applied);
        if (!applied.written) throw ExitStatus{run_failed};
    });
}

}  // namespace strake::cli
