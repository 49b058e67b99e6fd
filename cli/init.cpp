#include "casefile/build/build_problem.hpp"
#include "casefile/load_case.hpp"
#include "casefile/propose/propose.hpp"
#include "cli/check_picture.hpp"
#include "cli/commands.hpp"
#include "cli/detail.hpp"
#include "cli/held_check.hpp"
#include "cli/outputs.hpp"
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
    bool json = false, quiet = false;
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
    std::vector<int> label = patches.label;
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
        cells.push_back({text("level_", l), problem.tree.levels[l].label});
    std::vector<int> held(static_cast<std::size_t>(problem.surface.num_triangles()), 0);
    for (const int t : problem.fixed) held[static_cast<std::size_t>(t)] = 1;
    cells.push_back({"held", held});
    write_vtp(file, problem.surface, {}, cells);
}

/// The proposal as a problem. A few large triangles cannot be told apart by regions: the user never sees that case.
BuiltProblem tried(const Case& the_case, const InitArguments& args) {
    constexpr int few = 100;
    try {
        return build_problem(the_case, Purpose::run);
    } catch (const CaseError& error) {
        const int triangles = read_surface(the_case.surface).mesh.num_triangles();
        if (triangles > few || error.diagnostics.empty()) throw;
        throw InvalidInput(text("init: ", printable(args.surface, 400), ": its ", triangles,
                                " triangles are too large for regions (", error.diagnostics.front().message,
                                "); refine it first, for example strake remesh ", typed_path(args.surface),
                                " -o fine.stl --edge-length 5%"));
    }
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
    log_step("examining " + printable(args.surface, 400));
    const ProposedCase proposal = propose_case(args.surface, case_file, {args.evaluations});
    NewFile written(case_file, proposal.yaml);
    log_step("trying " + printable(case_file.string(), 400));
    const Case the_case = load_case(case_file, Purpose::run);
    const BuiltProblem built = tried(the_case, args);
    const std::vector<std::string> notes = check_shell(the_case, built.problem);
    write_atomically(svg, picture(built.problem, proposal, axes_facts(the_case, built.problem.surface)));
    write_patches(vtp, built.problem);
    written.keep();
    if (args.json) {
        nlohmann::ordered_json j{{"case", case_file.string()},
                                 {"picture", svg.string()},
                                 {"paraview", vtp.string()},
                                 {"found", proposal.found}};
        j["warnings"] = built.warnings;
        fmt::print("{}\n", j.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
        return;
    }
    if (args.quiet) return;
    for (const std::string& line : proposal.found) fmt::print("{}\n", line);
    for (const std::string& line : notes) fmt::print(stderr, "warning: {}\n", line);
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
    command->add_flag("--json", args->json, "print one JSON object instead of words");
    command->add_flag("-q,--quiet", args->quiet, "print nothing");
    command->callback([args] { init(*args); });
}

}  // namespace strake::cli
