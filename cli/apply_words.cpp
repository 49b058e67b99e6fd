#include "cases/diagnostics.hpp"
#include "cli/applied.hpp"
#include "report/json_number.hpp"

#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace strake::cli {
namespace {

constexpr double gentle = 0.2;  // displacement by reach up to which the map outside is far from folding

std::string place_of(const CellCheck& c) {
    return fmt::format("cell {} at ({:.6g}, {:.6g}, {:.6g})", c.worst, c.worst_at[0], c.worst_at[1], c.worst_at[2]);
}

/// Why nothing moves, where nothing does.
void warn_of_stillness(const ApplyArguments& args, const Applied& told) {
    constexpr double still = 1e-9;  // by the surface's displacement: what is left of the map far out
    if (told.points == 0 || told.max_displacement > still * told.max_surface_displacement) return;
    const std::string other = printable(args.other, 400);
    if (told.max_surface_displacement == 0)
        fmt::print(stderr, "warning: nothing of {} moves: this design is the start shape itself{}\n", other,
                   told.evaluation > 0 ? "; choose another by --evaluation or --design" : "");
    else if (told.still == told.points)
        fmt::print(
            stderr,
            "warning: nothing of {} moves: it is {:.3g} away from the surface at least, and nothing moves beyond "
            "{:.3g} (--reach {:g} times the diagonal); is it in the unit and place of the run's surface?\n",
            other, told.min_distance, args.reach * told.diagonal, args.reach);
    else
        fmt::print(
            stderr,
            "warning: nothing of {} moves: the design moves other parts of the surface, by up to {:.3g}, and these "
            "are too far away\n",
            other, told.max_surface_displacement);
}

}  // namespace

void warn(const ApplyArguments& args, const Applied& told) {
    warn_of_stillness(args, told);
    if (!told.left_out.empty())
        fmt::print(stderr,
                   "warning: an .npy holds coordinates only: left out are the columns {}; write a .csv to keep "
                   "them\n",
                   printable(joined(told.left_out), 400));
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

}  // namespace strake::cli
