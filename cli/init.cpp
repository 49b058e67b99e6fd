#include "casefile/build/build_problem.hpp"
#include "casefile/load_case.hpp"
#include "casefile/propose/propose.hpp"
#include "casefile/propose/trial.hpp"
#include "cli/check_picture.hpp"
#include "cli/commands.hpp"
#include "cli/detail.hpp"
#include "cli/held_check.hpp"
#include "cli/outputs.hpp"
#include "cli/say.hpp"
#include "core/error.hpp"
#include "core/formats/io.hpp"
#include "core/formats/vtp.hpp"
#include "core/mesh/geometry.hpp"
#include "core/text/file.hpp"
#include "core/text/shell_word.hpp"
#include "report/drawing.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <unistd.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>
#include <nlohmann/json.hpp>

/// `strake init`: proposes a case that runs for a bare surface, with a picture of its patches.
namespace strake::cli {
namespace {

namespace fs = std::filesystem;

struct InitArguments {
    std::string surface, out = "case.yaml";
    int evaluations = 60;
    std::string hold = "band";
    bool joints = false, json = false, quiet = false;
};

/// The case file while it is being tried; removed again unless it is kept.
class NewFile {
public:
    NewFile(const fs::path& file, const std::string& words) : file_(file) {
        const int handle = ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (handle < 0 && errno == EEXIST)
            throw InvalidInput(text("init: ", printable(file.string(), 400),
                                    " already exists and is never overwritten; choose another name with -o"));
        if (handle < 0) fail();
        is_ours_ = true;
        const bool written = ::write(handle, words.data(), words.size()) == static_cast<ssize_t>(words.size());
        if (!written || ::fsync(handle) != 0 || ::close(handle) != 0) fail();
    }
    ~NewFile() {
        if (is_ours_) ::unlink(file_.c_str());
    }
    void keep() { is_ours_ = false; }

private:
    [[noreturn]] void fail() {
        const std::string why = std::strerror(errno);
        if (is_ours_) ::unlink(file_.c_str());
        throw OutputError(text(printable(file_.string(), 400), ": cannot write: ", why));
    }
    fs::path file_;
    bool is_ours_ = false;
};

/// Six test deformations of some 40 000 triangles, or one of 300 000: a quarter of a minute of CPU.
constexpr double max_trial_work = 1.5e6;
constexpr int max_shell_triangles = 300000;  ///< the work of one test deformation; wrap and fields do without
constexpr int max_examined_triangles = 4 * max_shell_triangles;  ///< so many are not left out by any repair
constexpr int many_triangles = 50000;                            ///< each step takes seconds, and is told

std::string way_words(ProposedWay way) {
    switch (way) {
        case ProposedWay::shell:
            return "an elastic shell on the surface";
        case ProposedWay::remeshed_shell:
            return "an elastic shell on new triangles";
        case ProposedWay::wrap:
            return "patches of a wrap around it, and displacement fields";
        case ProposedWay::fields:
            return "displacement fields alone";
    }
    return "";
}

std::string head_of(const std::string& words) {
    const std::string line = words.substr(0, words.find('\n'));
    return line.size() < words.size() && line.ends_with(':') ? line.substr(0, line.size() - 1) : line;
}

/// The finest level whose patches are still distinguishable.
int shown_level(const PatchHierarchy& tree) {
    int level = 1;
    while (level + 1 < static_cast<int>(tree.levels.size()) && tree.levels[level + 1].patches.size() <= 24) ++level;
    return level;
}

/// Up: the thinner direction of a body with a plane of symmetry; away from what the body stands on; otherwise z.
Eigen::Vector3d up_of(const Problem& problem, const ProposedCase& proposal) {
    const Box box = bounding_box(problem.surface);
    const Eigen::Vector3d size = box.max - box.min;
    if (!proposal.plane) return proposal.down.isZero() ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d(-proposal.down);
    int side = 1;
    proposal.plane->normal.cwiseAbs().maxCoeff(&side);
    int up = side == 2 ? 1 : 2;
    const int other = 3 - side - up;
    if (size[other] < size[up]) up = other;
    return Eigen::Vector3d::Unit(up);
}

std::string picture(const Problem& problem, const ProposedCase& proposal, const std::optional<AxesFacts>& axes) {
    const int level = shown_level(problem.tree);
    const PatchLevel& patches = problem.tree.levels[level];
    std::vector<int> label = labels_on_surface(problem, patches);
    std::vector<Colour> colour;
    for (const int k : label) colour.push_back(patch_colour(k));
    const int held = static_cast<int>(patches.patches.size());
    const Colour grey{150, 150, 150};
    for (const int t : problem.fixed) label[t] = held, colour[t] = grey;
    std::vector<std::string> names;
    std::vector<LegendRow> legend;
    for (const Patch& patch : patches.patches) {
        const Colour drawn = patch_colour(static_cast<int>(names.size()));  // by the place on the level, as above
        names.push_back(patch.name);
        legend.push_back({drawn, fmt::format("{} ({} triangles)", patch.name, patch.triangles.size())});
    }
    names.push_back("held");
    legend.push_back({grey, fmt::format("held ({} triangles)", problem.fixed.size())});
    const Eigen::Vector3d up = up_of(problem, proposal);
    const Eigen::Vector3d side = proposal.plane ? proposal.plane->normal : up.unitOrthogonal(), ahead = side.cross(up);
    std::vector<Panel> panels;  // two of them and their margins fit a window of 1000 pixels
    for (const double sign : {1.0, -1.0}) {
        const Eigen::Vector3d from = sign * (-0.7 * ahead - 0.7 * side + 0.6 * up);
        Panel panel{draw_surface(problem.surface, colour, label, {from, up, axes ? 0.16 : 0.04}, 460, 345)};
        panel.title = sign > 0 ? "from above" : "from below, the other side";
        panel.names = names_in(panel.drawing, label, names, 150);
        if (axes) add_axes_arrows(panel, *axes, box_diagonal(problem.surface));
        panels.push_back(std::move(panel));
    }
    return svg_picture(fmt::format("{}: the {} patches of level {}", problem.name, held, level), panels, legend);
}

void write_patches(const fs::path& file, const Problem& problem) {
    std::vector<Field> cells;
    for (std::size_t l = 1; l < problem.tree.levels.size(); ++l)
        cells.push_back({text("level_", l), labels_on_surface(problem, problem.tree.levels[l])});
    std::vector<int> held(static_cast<std::size_t>(problem.surface.num_triangles()), 0);
    for (const int t : problem.fixed) held[static_cast<std::size_t>(t)] = 1;
    cells.push_back({"held", held});
    write_vtp(file, problem.surface, {}, cells);
}

/// Too few triangles for whatever way.
struct TooCoarse : InvalidInput {
    using InvalidInput::InvalidInput;
};

/// The proposal as a problem. A few large triangles cannot be told apart by regions: the user never sees that case.
BuiltProblem tried_problem(const Case& the_case, const InitArguments& args) {
    constexpr int few = 100;
    try {
        return build_problem(the_case, Purpose::run);
    } catch (const CaseError& error) {
        const int triangles = read_surface(the_case.surface).mesh.num_triangles();
        if (triangles > few || error.diagnostics.empty()) throw;
        throw TooCoarse(text("init: ", printable(args.surface, 400), ": its ", triangles,
                             " triangles are too large for regions (", error.diagnostics.front().message,
                             "); refine it first, for example strake remesh ", typed_path(args.surface),
                             " -o fine.stl --edge-length 5%"));
    }
}

ProposedHold hold_of(const std::string& word) {
    if (word == "point") return ProposedHold::point;
    return word == "none" ? ProposedHold::none : ProposedHold::band;
}

/// A way to move the surface, built and tried; not `built`: it cannot be, for the reason in `trial`.
struct Attempt {
    ProposedCase proposal;
    std::optional<BuiltProblem> built;
    std::vector<std::string> notes;  ///< of the shell
    Trial trial;
    std::exception_ptr refused;
};

Attempt attempt(const InitArguments& args, const fs::path& case_file, ProposedWay way, const std::string& reason,
                bool joints) {
    Attempt made;
    try {
        made.proposal =
            propose_case(args.surface, case_file,
                         {args.evaluations, hold_of(args.hold), way, reason, max_examined_triangles, joints});
        const NewFile written(case_file, made.proposal.yaml);
        if (!args.quiet && !args.json && (made.proposal.num_triangles > many_triangles || ::isatty(STDERR_FILENO) == 1))
            say("trying       {}\n", way_words(way));
        const bool is_shell = way == ProposedWay::shell || way == ProposedWay::remeshed_shell;
        if (is_shell && made.proposal.num_triangles > max_shell_triangles)
            throw InvalidInput(
                text(made.proposal.num_triangles, " triangles, the limit of a trial is ", max_shell_triangles));
        log_step("trying " + printable(case_file.string(), 400) + ": " + way_words(way));
        const Case the_case = load_case(case_file, Purpose::run);
        made.built = tried_problem(the_case, args);
        made.notes = check_shell(the_case, made.built->problem);
        made.trial = try_deformations(made.built->problem, max_trial_work);
        log_step(fmt::format("{}: {} of {} test deformations fail, {:.1f} s of CPU", way_words(way), made.trial.failed,
                             made.trial.tried, made.trial.cpu_seconds));
    } catch (const OutputError&) {
        throw;
    } catch (const TooCoarse&) {
        throw;
    } catch (const std::exception& error) {
        made.refused = std::current_exception();
        made.built.reset();
        made.trial.reason = error.what();
    }
    return made;
}

std::string words_of(ProposedWay way, const Attempt& made) {
    const std::string shown =
        way_words(way) + (made.proposal.has_new_vertices ? ", with new vertices at joints: " : ": ");
    if (!made.built) return shown + "refused, " + head_of(made.trial.reason);
    if (made.trial.tried == 0) return shown + "too large for a test deformation";
    std::string words = fmt::format("{}{} of {} test deformations fail", shown, made.trial.failed, made.trial.tried);
    if (made.trial.failed > 0) words += ", " + head_of(made.trial.reason);
    return made.proposal.ties_parts ? words + "; but it does not move parts together that lie beside each other"
                                    : words;
}

constexpr int enough_tries = 3;  ///< of test deformations, for a surface with defects

/// What is cut short on a surface without defects is too large for six, no fault of the way. With
/// defects one or two test deformations say too little.
bool is_sound(const Attempt& made) {
    if (!made.built) return false;
    if (made.trial.is_cut_short && made.proposal.is_dirty && made.trial.tried < enough_tries) return false;
    if (made.trial.is_cut_short && made.trial.tried == 0) return true;
    return made.trial.is_sound();
}

struct Chosen {
    ProposedCase proposal;
    std::optional<BuiltProblem> built;
    std::vector<std::string> notes, tried;
};

double failing(const Attempt& made) {
    return !made.built ? 2.0 : made.trial.tried == 0 ? 1.0 : static_cast<double>(made.trial.failed) / made.trial.tried;
}

/// Whether a way that is sound ends the search: a shell of parts that would move apart only where no other way is
/// sound.
bool is_enough(const Attempt& made) { return is_sound(made) && !made.proposal.ties_parts; }

/// The first of a shell, a shell on new triangles (of surfaces with slivers), a wrap and displacement fields alone that
/// test deformations find sound, else the one that fails least. @throws what the first refuses where none can be built.
Chosen choose(const InitArguments& args, const fs::path& case_file) {
    log_step("examining " + printable(args.surface, 400));
    Attempt best;
    std::vector<std::string> tried;
    bool may_remesh = false;
    std::exception_ptr refused;
    for (const ProposedWay way :
         {ProposedWay::shell, ProposedWay::remeshed_shell, ProposedWay::wrap, ProposedWay::fields}) {
        if (way == ProposedWay::remeshed_shell && !may_remesh) continue;
        const std::string reason = tried.empty() ? "" : text("Chosen by trial, in place of ", tried.front());
        Attempt made = attempt(args, case_file, way, reason, args.joints);
        if (made.proposal.has_new_vertices && !is_enough(made)) {  // then at least as the file has it
            tried.push_back(words_of(way, made));
            made = attempt(args, case_file, way, text("Chosen by trial, in place of ", tried.front()), false);
        }
        if (way == ProposedWay::shell) may_remesh = made.proposal.may_remesh, refused = made.refused;
        tried.push_back(words_of(way, made));
        const bool is_first = tried.size() == 1, ends = is_enough(made);
        if (is_first || ends || failing(made) < failing(best)) best = std::move(made);
        if (ends) break;
    }
    if (!best.built) std::rethrow_exception(refused);
    return {std::move(best.proposal), std::move(best.built), std::move(best.notes), std::move(tried)};
}

void init(const InitArguments& args) {
    const fs::path case_file = args.out;
    if (case_file.extension() != ".yaml" && case_file.extension() != ".yml")
        throw InvalidInput(text("init: -o ", printable(args.out, 400), ": must end in .yaml"));
    const fs::path stem = case_file.parent_path() / case_file.stem();
    const fs::path svg = stem.string() + "-patches.svg", vtp = stem.string() + "-patches.vtp";
    std::error_code ignored;
    for (const fs::path& file : {case_file, svg, vtp})
        if (fs::symlink_status(file, ignored).type() != fs::file_type::not_found &&
            fs::exists(fs::symlink_status(file, ignored)))
            throw InvalidInput(text("init: ", printable(file.string(), 400),
                                    " already exists and is never overwritten; choose another name with -o"));
    Chosen chosen = choose(args, case_file);
    const ProposedCase& proposal = chosen.proposal;
    const BuiltProblem& built = *chosen.built;
    NewFile written(case_file, proposal.yaml);
    const Case the_case = load_case(case_file, Purpose::run);
    write_atomically(svg, picture(built.problem, proposal, axes_facts(the_case, built.problem.surface)));
    write_patches(vtp, built.problem);
    written.keep();
    if (args.json) {
        nlohmann::ordered_json j{{"case", case_file.string()},
                                 {"picture", svg.string()},
                                 {"paraview", vtp.string()},
                                 {"found", proposal.found}};
        j["tried"] = chosen.tried;
        j["warnings"] = built.warnings;
        fmt::print("{}\n", j.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
        return;
    }
    if (args.quiet) return;
    for (const std::string& line : proposal.found) fmt::print("{}\n", line);
    for (const std::string& line : chosen.tried) fmt::print("tried        {}\n", line);
    for (const std::string& line : chosen.notes) fmt::print(stderr, "warning: {}\n", line);
    fmt::print("wrote        {}, {} (open in a browser), {} (ParaView)\n", printable(case_file.string(), 400),
               printable(svg.string(), 400), printable(vtp.string(), 400));
    fmt::print("next         strake check {0}; strake run {0}\n", typed_path(case_file.string()));
}

}  // namespace

void add_init(CLI::App& app) {
    auto args = std::make_shared<InitArguments>();
    CLI::App* command =
        app.add_subcommand("init", "propose a case that runs for a bare surface, with a picture of its patches");
    command->add_option("SURFACE", args->surface, "surface file, any format that info reads")->required();
    command->add_option("-o,--out,--output", args->out, "case file to write; never overwritten (default: case.yaml)");
    command->add_option("--evaluations", args->evaluations, "budget of the case (default: 60)")
        ->check(CLI::Range(1, 1000000));
    command
        ->add_option(
            "--hold", args->hold,
            "what keeps the body in its place: a band (default; twist and thickness at the root stay), one point "
            "(everything but the place and attitude there is free), or none (fields alone)")
        ->check(CLI::IsMember({"band", "point", "none"}));
    command->add_flag("--joints", args->joints,
                      "add vertices where parts pass through each other with long edges (repair: joints), if these "
                      "keep the joints closed in a test bend");
    command->add_flag("--json", args->json, "print one JSON object instead of words");
    command->add_flag("-q,--quiet", args->quiet, "print nothing");
    command->callback([args] { init(*args); });
}

}  // namespace strake::cli
