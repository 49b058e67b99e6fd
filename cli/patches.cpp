#include "cli/commands.hpp"
#include "cli/detail.hpp"
#include "cli/outputs.hpp"
#include "core/error.hpp"
#include "core/formats/io.hpp"
#include "core/formats/vtp.hpp"
#include "core/mesh/geometry.hpp"
#include "core/patches/automatic.hpp"
#include "core/patches/segmentation.hpp"
#include "core/text/file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>

/// `strake patches`: the patch tree of a surface, at given thresholds or with automatic ones.
namespace strake::cli {
namespace {

struct PatchesArguments {
    std::string surface, min_size = "0%", split = "all", vtp, labels;
    std::vector<std::string> angles;
    std::vector<std::string> patches_per_level;
    bool json = false;
};

template <class Number>
std::optional<Number> whole_number_text(const std::string& words) {
    Number value{};
    const auto [end, error] = std::from_chars(words.data(), words.data() + words.size(), value);
    if (error != std::errc{} || end != words.data() + words.size()) return std::nullopt;
    return value;
}

std::vector<std::string> pieces(const std::string& words, char separator) {
    std::vector<std::string> list(1);
    for (const char c : words) {
        if (c == separator)
            list.emplace_back();
        else
            list.back() += c;
    }
    return list;
}

/// Degrees of every --angle, strictly decreasing; empty for `auto`.
std::vector<double> angles_of(const PatchesArguments& options) {
    if (options.angles == std::vector<std::string>{"auto"}) return {};
    std::vector<double> angles;
    for (const std::string& words : options.angles) {
        const auto angle = whole_number_text<double>(words);
        if (words == "auto")
            throw InvalidInput(
                "--angle auto cannot be combined with other angles: it chooses all thresholds from the surface");
        if (!angle || !(*angle > 0 && *angle <= 90))
            throw InvalidInput(text("--angle ", words, ": must be a number of degrees in (0, 90], or auto"));
        if (!angles.empty() && !(*angle < angles.back()))
            throw InvalidInput(
                text("--angle ", words, ": must be less than the previous angle, ", angles.back(), " degrees"));
        angles.push_back(*angle);
    }
    return angles;
}

double min_percent_of(const PatchesArguments& options) {
    std::string words = options.min_size;
    if (!words.empty() && words.back() == '%') words.pop_back();
    const auto percent = whole_number_text<double>(words);
    if (!percent || !(*percent >= 0 && *percent < 100))
        throw InvalidInput(text("--min-size ", options.min_size, ": must be a percentage in [0, 100), like 1%"));
    return *percent;
}

Split split_of(const PatchesArguments& options) {
    const std::string& words = options.split;
    if (words == "all") return SplitAll{};
    const auto colon = words.find(':');
    const std::string kind = words.substr(0, colon), rest = colon == std::string::npos ? "" : words.substr(colon + 1);
    if (kind == "largest") {
        const auto count = whole_number_text<int>(rest);
        if (!count || *count < 1) throw InvalidInput(text("--split ", words, ": largest:N needs a number N >= 1"));
        return SplitLargest{*count};
    }
    if (kind == "containing") {
        SplitContaining containing;
        for (const std::string& item : pieces(rest, ',')) {
            const auto triangle = whole_number_text<int>(item);
            if (!triangle || *triangle < 0)
                throw InvalidInput(text("--split ", words, ": containing:T[,T...] needs triangle numbers >= 0"));
            containing.triangles.push_back(*triangle);
        }
        return containing;
    }
    throw InvalidInput(text("--split ", words, ": must be all, largest:N or containing:T[,T...]"));
}

std::vector<int> per_level_of(const PatchesArguments& options) {
    std::vector<int> wanted;
    for (const std::string& words : options.patches_per_level)
        for (const std::string& item : pieces(words, ',')) {
            const auto count = whole_number_text<int>(item);
            if (!count || *count < 1 || (!wanted.empty() && *count < wanted.back()))
                throw InvalidInput(text("--patches-per-level ", item, ": must be whole numbers >= 1, not falling"));
            wanted.push_back(*count);
        }
    return wanted;
}

/// Checks that the triangles exist before anything is computed.
void check_triangles(const Split& split, const TriMesh& mesh) {
    if (const auto* containing = std::get_if<SplitContaining>(&split))
        for (const int t : containing->triangles)
            if (t >= mesh.num_triangles())
                throw InvalidInput(
                    text("--split containing:", t, ": the surface has triangles 0 to ", mesh.num_triangles() - 1));
}

std::string csv_of_labels(const PatchHierarchy& tree) {
    std::string csv;
    const std::size_t levels = tree.levels.size();
    for (std::size_t l = 1; l < levels; ++l) csv += text("level_", l, l + 1 < levels ? "," : "\n");
    for (std::size_t t = 0; t < tree.levels[0].label.size(); ++t)
        for (std::size_t l = 1; l < levels; ++l) {
            csv += std::to_string(tree.levels[l].label[t]);
            csv += l + 1 < levels ? ',' : '\n';
        }
    return csv;
}

/// Labels on the triangles; crease angle and class (0 smooth, 1 ridge, 2 corner, at the last level) on the vertices.
void write_tree(const std::string& file, const TriMesh& mesh, const Adjacency& adjacent, const PatchHierarchy& tree) {
    constexpr double degrees = 180 / std::numbers::pi;
    const auto features = quadric_metric_tensor(mesh, adjacent);
    Eigen::VectorXd theta_deg(mesh.num_vertices());
    std::vector<int> vertex_class;
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        theta_deg[v] = features[v].theta * degrees;
        vertex_class.push_back(static_cast<int>(classify(features[v], tree.levels.back().angle_deg / degrees)));
    }
    std::vector<Field> cells;
    for (std::size_t l = 1; l < tree.levels.size(); ++l) cells.push_back({text("level_", l), tree.levels[l].label});
    write_vtp(file, mesh, {{"theta_deg", theta_deg}, {"class", vertex_class}}, cells);
}

const char* name_of(PatchClass c) { return c == PatchClass::smooth ? "smooth" : "nonsmooth"; }

std::string as_json(const PatchHierarchy& tree) {
    nlohmann::ordered_json levels = nlohmann::ordered_json::array();
    for (std::size_t l = 1; l < tree.levels.size(); ++l) {
        nlohmann::ordered_json patches = nlohmann::ordered_json::array();
        for (const Patch& p : tree.levels[l].patches)
            patches.push_back({{"id", p.id},
                               {"name", p.name},
                               {"parent", p.parent},
                               {"class", name_of(p.patch_class)},
                               {"triangles", p.triangles.size()},
                               {"area", p.area}});
        levels.push_back({{"angle_deg", tree.levels[l].angle_deg}, {"patches", patches}});
    }
    return nlohmann::ordered_json{{"levels", levels}}.dump(2) + "\n";
}

/// One row for each patch, at most the forty largest of a level.
std::string as_words(const PatchHierarchy& tree) {
    constexpr std::size_t rows = 40;
    const double area = tree.levels[0].patches[0].area;
    std::string out;
    for (std::size_t l = 1; l < tree.levels.size(); ++l) {
        const PatchLevel& level = tree.levels[l];
        out += fmt::format("level {}: {} patch{} at {:g} degrees\n", l, level.patches.size(),
                           level.patches.size() == 1 ? "" : "es", level.angle_deg);
        out += fmt::format("  {:>6}  {:<14} {:<14} {:<9} {:>9} {:>13} {:>7}\n", "id", "name", "parent", "class",
                           "triangles", "area", "share");
        std::vector<const Patch*> order;
        for (const Patch& p : level.patches) order.push_back(&p);
        std::stable_sort(order.begin(), order.end(), [](auto* a, auto* b) { return a->area > b->area; });
        for (std::size_t i = 0; i < std::min(rows, order.size()); ++i) {
            const Patch& p = *order[i];
            out += fmt::format("  {:>6}  {:<14} {:<14} {:<9} {:>9} {:>13.6g} {:>6.2f}%\n", p.id, p.name,
                               tree.levels[l - 1].patches[p.parent].name, name_of(p.patch_class), p.triangles.size(),
                               p.area, area > 0 ? 100 * p.area / area : 0);
        }
        if (order.size() > rows)
            out += fmt::format("  and {} smaller patches (--json lists all)\n", order.size() - rows);
    }
    return out;
}

void print_patches(const std::string& words) {
    std::fputs(words.c_str(), stdout);  // main reports output that cannot be written
}

void patches(const PatchesArguments& options) {
    const std::vector<double> angles = angles_of(options);
    const double min_percent = min_percent_of(options);
    const Split split = split_of(options);
    const std::vector<int> per_level = per_level_of(options);
    if (!per_level.empty() && !angles.empty())
        throw InvalidInput("--patches-per-level needs --angle auto; explicit angles determine the number of patches");
    if (!options.vtp.empty() && std::filesystem::path(options.vtp).extension() != ".vtp")
        throw InvalidInput(text("-o ", options.vtp, ": patches can only be written as .vtp; use --labels for a table"));

    check_outputs({options.vtp, options.labels}, {options.surface});
    const TriMesh mesh = read_logged(options.surface).mesh;
    check_triangles(split, mesh);
    const Adjacency adjacent = adjacency(mesh);
    if (angles.empty()) check_area(options.surface, mesh);
    PatchHierarchy tree;
    if (angles.empty()) {
        AutomaticLevels automatic;
        if (!per_level.empty()) automatic.patches_per_level = per_level;
        automatic.min_patch_percent = min_percent;
        automatic.split = split;
        tree = segment_automatically(mesh, adjacent, automatic);
    } else {
        tree = segment(mesh, adjacent, angles, {.min_patch_percent = min_percent, .split = split});
    }
    if (!options.labels.empty()) write_atomically(options.labels, csv_of_labels(tree));
    if (!options.vtp.empty()) write_tree(options.vtp, mesh, adjacent, tree);
    print_patches(options.json ? as_json(tree) : as_words(tree));
}

}  // namespace

void add_patches(CLI::App& app) {
    auto options = std::make_shared<PatchesArguments>();
    CLI::App* command = app.add_subcommand("patches", "segment a surface into nested patches");
    command->add_option("SURFACE", options->surface, "surface file, any format that info reads")->required();
    command
        ->add_option(
            "--angle", options->angles,
            "threshold of a level in degrees, decreasing, repeat for each level; or auto: chosen from the surface")
        ->required()
        ->allow_extra_args(false);
    command
        ->add_option("--patches-per-level", options->patches_per_level, "target for --angle auto, for example 4,16,64")
        ->allow_extra_args(false);
    command->add_option("--min-size", options->min_size,
                        "merge patches below this percentage of the triangles (auto: of the area) (default: 0%)");
    command->add_option("--split", options->split,
                        "patches to split at each level: all, largest:N, containing:T[,T...] (default: all)");
    command->add_option("-o,--out,--output", options->vtp,
                        "write labels, crease angles and classes for ParaView (.vtp)");
    command->add_option("--labels", options->labels, "write labels as CSV, one row per triangle in file order");
    command->add_flag("--json", options->json, "print one JSON object instead of a table");
    command->callback([options] { patches(*options); });
}

}  // namespace strake::cli
