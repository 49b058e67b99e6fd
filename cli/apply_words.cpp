#include "casefile/yaml/diagnostics.hpp"
#include "cli/applied.hpp"
#include "report/json_number.hpp"

#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace strake::cli {
namespace {

constexpr double gentle = 0.2;  // ratio of displacement to reach below which the map outside cannot fold

std::string place_of(const CellCheck& c) {
    return fmt::format("cell {} at ({:.6g}, {:.6g}, {:.6g})", c.worst, c.worst_at[0], c.worst_at[1], c.worst_at[2]);
}

/// Says why nothing moves.
void warn_if_nothing_moves(const ApplyArguments& args, const Applied& applied) {
    constexpr double still = 1e-9;  // relative to the surface's displacement: the tail of the map far away
    if (applied.points == 0 || applied.max_displacement > still * applied.max_surface_displacement) return;
    const std::string other = printable(args.other, 400);
    if (applied.max_surface_displacement == 0)
        fmt::print(stderr, "warning: nothing of {} moves: this design is the start shape itself{}\n", other,
                   applied.evaluation > 0 ? "; choose another with --evaluation or --design" : "");
    else if (applied.beyond_reach == applied.points)
        fmt::print(stderr,
                   "warning: nothing of {} moves: it is at least {:.3g} away from the surface, and nothing moves "
                   "beyond {:.3g} "
                   "(--reach {:g} times the diagonal); check that unit and position are those of the run's surface\n",
                   other, applied.min_distance, args.reach * applied.diagonal, args.reach);
    else
        fmt::print(
            stderr,
            "warning: nothing of {} moves: the design moves only parts of the surface that are too far away, by up to "
            "{:.3g}\n",
            other, applied.max_surface_displacement);
}

}  // namespace

void warn(const ApplyArguments& args, const Applied& applied) {
    warn_if_nothing_moves(args, applied);
    if (!applied.lost_columns.empty())
        fmt::print(stderr,
                   "warning: an .npy holds only coordinates: the columns {} are lost; write a .csv to keep them\n",
                   printable(joined(applied.lost_columns), 400));
    if (applied.max_surface_displacement > gentle * args.reach * applied.diagonal)
        fmt::print(stderr,
                   "warning: the surface moves by {:.3g}, more than a fifth of the reach of {:.3g}: cells may fold; "
                   "raise --reach\n",
                   applied.max_surface_displacement, args.reach * applied.diagonal);
    if (applied.undone && applied.undone->num_unsolved > 0)
        fmt::print(
            stderr,
            "warning: {} of {} points cannot be traced back (the worst, point {}, misses by {:.3g}): check that this "
            "design moved them, with this --reach\n",
            applied.undone->num_unsolved, applied.points, applied.undone->worst, applied.undone->residual);
    if (applied.unchecked_cells > 0)
        fmt::print(stderr, "warning: {} cells of other types were not checked\n", applied.unchecked_cells);
    if (!applied.cells) return;
    const CellCheck& c = *applied.cells;
    if (c.inverted_before + c.folded_before > 0)
        fmt::print(stderr, "warning: {} cells were inverted or folded before anything moved\n",
                   c.inverted_before + c.folded_before);
    if (c.newly_bad > 0)
        fmt::print(stderr,
                   "{}: {} of {} cells are inverted or folded by the motion; the worst is {}: its volume changes from "
                   "{:.3g} to {:.3g}; {}\n",
                   applied.written ? "warning" : "strake: apply", c.newly_bad, c.cells, place_of(c), c.worst_before,
                   c.worst_after,
                   applied.written ? "written anyway (--force)"
                                   : "nothing was written; apply an earlier design (--evaluation), raise --reach, or "
                                     "write it anyway with --force");
}

namespace {

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

}  // namespace

void print_json(const ApplyArguments& args, const Applied& applied) {
    nlohmann::ordered_json j;
    j["status"] = applied.written ? "ok" : "inverted";
    j["evaluation"] = applied.evaluation;
    j["points"] = applied.points;
    j["on_surface"] = applied.on_surface;
    j["beyond_reach"] = applied.beyond_reach;
    j["max_displacement"] = json_number(applied.max_displacement);
    j["max_distance"] = json_number(applied.max_distance);
    if (applied.cells) j["cells"] = json_of(*applied.cells, applied.unchecked_cells);
    if (applied.undone)
        j["undo"] = {{"residual", json_number(applied.undone->residual)}, {"unsolved", applied.undone->num_unsolved}};
    j["file"] = applied.written ? nlohmann::ordered_json(args.out) : nlohmann::ordered_json(nullptr);
    fmt::print("{}\n", j.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
}

void print_words(const Applied& applied) {
    if (applied.evaluation > 0) fmt::print("design            evaluation {}\n", applied.evaluation);
    fmt::print("points            {}: {} on the surface, {} beyond the reach\n", applied.points, applied.on_surface,
               applied.beyond_reach);
    fmt::print("max displacement  {:.6g} ({:.3g} % of the diagonal)\n", applied.max_displacement,
               100 * applied.max_displacement / applied.diagonal);
    fmt::print("max distance      {:.6g} from the surface\n", applied.max_distance);
    if (applied.undone) fmt::print("undo residual     {:.3g}\n", applied.undone->residual);
    if (!applied.cells) return;
    fmt::print("cells             {}: {} inverted, {} folded ({} and {} before)\n", applied.cells->cells,
               applied.cells->inverted, applied.cells->folded, applied.cells->inverted_before,
               applied.cells->folded_before);
    fmt::print("cell volumes      change by factors of {:.3g} to {:.3g}; the smallest in {}\n",
               applied.cells->smallest_ratio, applied.cells->largest_ratio, place_of(*applied.cells));
}

}  // namespace strake::cli
