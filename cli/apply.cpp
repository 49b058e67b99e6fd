#include "cli/commands.hpp"
#include "cli/designs.hpp"
#include "cli/detail.hpp"
#include "cli/outputs.hpp"
#include "core/error.hpp"
#include "core/mesh/file.hpp"
#include "core/mesh/geometry.hpp"
#include "core/mesh/io.hpp"
#include "core/mesh/npy.hpp"
#include "core/mesh/surface_unmap.hpp"
#include "core/mesh/vtp.hpp"
#include "core/volume/cell_check.hpp"
#include "core/volume/held_boundary.hpp"
#include "core/volume/volume_file.hpp"
#include "objectives/external/gradient.hpp"
#include "objectives/external/refused.hpp"
#include "objectives/point_list.hpp"
#include "report/json_number.hpp"

#include <fmt/core.h>
#include <memory>
#include <nlohmann/json.hpp>

/// `strake apply`: other points move as the surface of a run did.
namespace strake::cli {
namespace {

namespace fs = std::filesystem;

struct ApplyArguments {
    std::string run, other, out, design, moved, sensitivities;
    std::vector<std::string> hold;
    int evaluation = 0;
    double reach = SurfaceMapOptions{}.reach;
    bool undo = false, force = false, json = false;
};

constexpr double gentle = 0.2;  // displacement by reach up to which the map outside is far from folding

enum class Kind { surface, list, volume };

/// What is to move.
struct Other {
    Kind kind = Kind::surface;
    TriMesh surface;      ///< of a surface
    NumberedPoints list;  ///< of a list
    VolumeFile volume;    ///< of the mesh of a volume
    const Points& points() const {
        return kind == Kind::surface ? surface.vertices : kind == Kind::list ? list.at : volume.mesh.points;
    }
};

struct Applied {
    int points = 0, evaluation = 0, on_surface = 0, still = 0;
    double diagonal = 0, max_displacement = 0, max_distance = 0, max_surface_displacement = 0;
    std::optional<Unmapped> undone;
    std::optional<CellCheck> cells;
    int unchecked_cells = 0;
    bool written = true;
};

/// The mesh of a volume stays one; of an .su2 the surface is taken where a surface is asked for.
Kind kind_of(const ApplyArguments& args) {
    if (is_point_list(args.other)) return Kind::list;
    const bool is_su2 = fs::path(args.other).extension() == ".su2";
    if (is_su2 && (fs::path(args.out).extension() != ".su2" || !args.sensitivities.empty())) return Kind::surface;
    return is_volume(args.other) ? Kind::volume : Kind::surface;
}

void check_names(const ApplyArguments& args, Kind kind) {
    const std::string out = printable(args.out, 400), ending = fs::path(args.out).extension();
    if (!args.sensitivities.empty()) {
        if (args.undo) throw InvalidInput("--sensitivities belong to points at the start: leave out --undo");
        if (kind == Kind::volume)
            throw InvalidInput("--sensitivities: give the points of the mesh as .csv or .npy in place of the mesh");
        if (ending != ".csv" && ending != ".npy" && ending != ".vtp")
            throw InvalidInput(out + ": sensitivities are written as .csv, .npy or .vtp");
        return;
    }
    if (!args.hold.empty() && (kind != Kind::volume || args.undo))
        throw InvalidInput("--hold: only for the mesh of a volume, and not with --undo");
    if (kind == Kind::volume) return check_volume_output(args.out, args.other);
    if (kind == Kind::list && !is_point_list(args.out))
        throw InvalidInput(fmt::format("{}: {} is a list of points, not a surface: write .csv or .npy", out,
                                       printable(args.other, 400)));
    if (!is_point_list(args.out)) format_of(args.out);
}

Other read_other(const ApplyArguments& args, Kind kind) {
    Other other;
    other.kind = kind;
    if (kind == Kind::list) other.list = read_points(args.other);
    if (kind == Kind::surface) other.surface = read_told(args.other).mesh;
    if (kind == Kind::volume) other.volume = read_volume(args.other);
    return other;
}

Deformation deformation_of(const ApplyArguments& args) {
    if (args.moved.empty()) return run_deformation(args.run, args.design, args.evaluation);
    return surface_deformation(args.run, args.moved);
}

void write_moved(const ApplyArguments& args, const Other& other, const Points& moved) {
    if (other.kind == Kind::volume) return write_volume(args.out, other.volume, moved);
    if (is_point_list(args.out)) return write_points(args.out, {moved, other.list.ids});
    write_surface(args.out, with_vertices(other.surface, moved), format_of(args.out));
}

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

Applied facts(const ApplyArguments& args, const Deformation& d, const Points& from, const Points& to,
              const Eigen::VectorXd& distances) {
    Applied told;
    told.points = static_cast<int>(from.rows());
    told.evaluation = d.evaluation;
    told.diagonal = box_diagonal(d.rest);
    const Eigen::VectorXd by = (to - from).rowwise().norm();
    if (by.size() > 0) told.max_displacement = by.maxCoeff(), told.max_distance = distances.maxCoeff();
    told.on_surface = static_cast<int>((distances.array() <= 1e-9 * told.diagonal).count());
    told.still = static_cast<int>((distances.array() >= args.reach * told.diagonal).count());
    told.max_surface_displacement = (d.vertices - d.rest.vertices).rowwise().norm().maxCoeff();
    return told;
}

Applied apply(const ApplyArguments& args) {
    const Kind kind = kind_of(args);
    check_names(args, kind);
    const Deformation d = deformation_of(args);
    const Other other = read_other(args, kind);
    const Points& from = other.points();
    const SurfaceMapOptions options{args.reach, d.symmetry};
    const SurfaceMap map(args.undo ? with_vertices(d.rest, d.vertices) : d.rest, from, options);
    std::optional<Unmapped> undone;
    if (args.undo) undone = unmap(d.rest, d.vertices, from, options);
    Points to = args.undo ? undone->points : map.moved(d.vertices);
    if (!args.hold.empty())
        to = from + hold_factors(other.volume.mesh, args.hold, map.distances()).asDiagonal() * (to - from);
    if (!to.allFinite()) throw SolverError("apply: a moved point is not finite");
    Applied told = facts(args, d, from, to, map.distances());
    told.undone = undone;
    if (kind == Kind::volume && other.volume.mesh.num_cells > 0) told.cells = check_cells(other.volume.mesh, from, to);
    if (kind == Kind::volume) told.unchecked_cells = other.volume.mesh.num_unchecked;
    told.written = args.force || !told.cells || told.cells->newly_bad == 0;
    if (!args.sensitivities.empty())
        carry_back(args, d, map, to, other.list.ids);
    else if (told.written)
        write_moved(args, other, to);
    return told;
}

std::string place_of(const CellCheck& c) {
    return fmt::format("cell {} at ({:.6g}, {:.6g}, {:.6g})", c.worst, c.worst_at[0], c.worst_at[1], c.worst_at[2]);
}

void warn(const ApplyArguments& args, const Applied& told) {
    if (told.max_surface_displacement > gentle * args.reach * told.diagonal)
        fmt::print(stderr,
                   "warning: the surface moves by {:.3g}, more than a fifth of the reach of {:.3g}: cells between may "
                   "fold; raise --reach\n",
                   told.max_surface_displacement, args.reach * told.diagonal);
    if (told.undone && told.undone->num_unsolved > 0)
        fmt::print(
            stderr,
            "warning: {} of {} points have no place from which they came (the worst, point {}, misses by {:.3g}): "
            "were they moved by this design, with this --reach?\n",
            told.undone->num_unsolved, told.points, told.undone->worst, told.undone->residual);
    if (told.unchecked_cells > 0)
        fmt::print(stderr, "warning: {} cells of other kinds were not checked\n", told.unchecked_cells);
    if (!told.cells) return;
    const CellCheck& c = *told.cells;
    if (c.inverted_before + c.folded_before > 0)
        fmt::print(stderr, "warning: {} cells were inverted or folded before anything moved\n",
                   c.inverted_before + c.folded_before);
    if (c.newly_bad > 0)
        fmt::print(stderr,
                   "{}: {} of {} cells are inverted or folded by the motion; the worst is {}: volume {:.3g} becomes "
                   "{:.3g}; {}\n",
                   told.written ? "warning" : "strake: apply", c.newly_bad, c.cells, place_of(c), c.worst_before,
                   c.worst_after,
                   told.written ? "written all the same (--force)"
                                : "nothing was written; apply an earlier design (--evaluation), raise --reach, or "
                                  "write it all the same by --force");
}

nlohmann::ordered_json json_of(const CellCheck& c, int unchecked) {
    nlohmann::ordered_json j;
    j["checked"] = c.cells;
    j["unchecked"] = unchecked;
    j["inverted_before"] = c.inverted_before;
    j["folded_before"] = c.folded_before;
    j["inverted"] = c.inverted;
    j["folded"] = c.folded;
    j["newly_bad"] = c.newly_bad;
    j["smallest_ratio"] = json_number(c.smallest_ratio);
    j["largest_ratio"] = json_number(c.largest_ratio);
    if (c.worst >= 0)
        j["worst"] = {{"cell", c.worst},
                      {"at", {c.worst_at[0], c.worst_at[1], c.worst_at[2]}},
                      {"before", json_number(c.worst_before)},
                      {"after", json_number(c.worst_after)}};
    return j;
}

void print_json(const ApplyArguments& args, const Applied& told) {
    nlohmann::ordered_json j;
    j["status"] = told.written ? "ok" : "inverted";
    j["evaluation"] = told.evaluation;
    j["points"] = told.points;
    j["on_surface"] = told.on_surface;
    j["beyond_reach"] = told.still;
    j["max_displacement"] = json_number(told.max_displacement);
    j["max_distance"] = json_number(told.max_distance);
    if (told.cells) j["cells"] = json_of(*told.cells, told.unchecked_cells);
    if (told.undone)
        j["undo"] = {{"residual", json_number(told.undone->residual)}, {"unsolved", told.undone->num_unsolved}};
    j["file"] = told.written ? nlohmann::ordered_json(args.out) : nlohmann::ordered_json(nullptr);
    fmt::print("{}\n", j.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
}

void print_words(const Applied& told) {
    if (told.evaluation > 0) fmt::print("design            evaluation {}\n", told.evaluation);
    fmt::print("points            {}: {} on the surface, {} beyond the reach\n", told.points, told.on_surface,
               told.still);
    fmt::print("max displacement  {:.6g} ({:.3g} % of the diagonal)\n", told.max_displacement,
               100 * told.max_displacement / told.diagonal);
    fmt::print("max distance      {:.6g} from the surface\n", told.max_distance);
    if (told.undone) fmt::print("undone to         {:.3g}\n", told.undone->residual);
    if (!told.cells) return;
    fmt::print("cells             {}: {} inverted, {} folded ({} and {} before)\n", told.cells->cells,
               told.cells->inverted, told.cells->folded, told.cells->inverted_before, told.cells->folded_before);
    fmt::print("cell volumes      change by factors of {:.3g} to {:.3g}; the smallest in {}\n",
               told.cells->smallest_ratio, told.cells->largest_ratio, place_of(*told.cells));
}

}  // namespace

void add_apply(CLI::App& app) {
    auto args = std::make_shared<ApplyArguments>();
    CLI::App* command =
        app.add_subcommand("apply", "moves other points, surfaces and volume meshes as a run's surface");
    command->add_option("RUN", args->run, "folder of the run; with --moved a surface file")->required();
    command
        ->add_option("OTHER", args->other,
                     "where it was at the start: surface; points (.csv, .npy); volume mesh (folder polyMesh or its "
                     "points, .su2, .vtu)")
        ->required();
    command->add_option("-o,--out", args->out, "where it goes: a surface, .csv or .npy; a volume mesh as OTHER")
        ->required();
    CLI::Option* design = command->add_option("--design", args->design, "another design than levels/best.design");
    CLI::Option* evaluation =
        command->add_option("--evaluation", args->evaluation, "another one than the best, from the ParaView series")
            ->check(CLI::Range(1, 1000000000))
            ->excludes(design);
    command
        ->add_option("--moved", args->moved,
                     "instead of a run: where the surface RUN has gone, with the same triangles")
        ->excludes(design)
        ->excludes(evaluation);
    command->add_option("--sensitivities", args->sensitivities,
                        "gradients at the points of OTHER (moved): written are those at the run's vertices");
    command->add_option("--reach", args->reach, "distance beyond which nothing moves, in diagonals of the surface")
        ->capture_default_str();
    command->add_option("--hold", args->hold, "boundary of the volume mesh that stays: a patch, a marker (repeatable)");
    command->add_flag("--undo", args->undo, "OTHER is where the design has moved it: back to the start");
    command->add_flag("--force", args->force, "write a volume mesh with inverted cells, too");
    command->add_flag("--json", args->json, "one JSON object instead of words");
    command->callback([args] {
        check_outputs({args->out}, {args->other, args->design, args->moved, args->sensitivities});
        const Applied told = apply(*args);
        warn(*args, told);
        args->json ? print_json(*args, told) : print_words(told);
        if (!told.written) throw ExitStatus{run_failed};
    });
}

}  // namespace strake::cli
