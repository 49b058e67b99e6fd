#include "core/repair/repair.hpp"

#include "cli/commands.hpp"
#include "cli/detail.hpp"
#include "cli/outputs.hpp"
#include "cli/signals.hpp"
#include "core/error.hpp"
#include "core/formats/io.hpp"
#include "core/text/file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

/// `strake repair`: repairs what is requested, and reports what it did and what remains.
namespace strake::cli {
namespace {

struct RepairArguments {
    std::string surface, out, list;
    std::string weld, cracks, holes, joints, fill = "planar", components;
    RepairOptions repair;
    bool all = false, json = false, quiet = false;
};

double number_of(std::string_view digits, const std::string& shown, const char* expected) {
    double value = 0;
    const auto [stop, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error != std::errc{} || stop != digits.data() + digits.size() || !std::isfinite(value) || value < 0)
        throw InvalidInput(text(shown, ": must be ", expected));
    return value;
}

/// A length, or with % a fraction of the diagonal.
double length_of(const std::string& words, const char* option, double diagonal) {
    const bool is_share = words.ends_with('%');
    const double value = number_of(std::string_view(words).substr(0, words.size() - is_share), text(option, " ", words),
                                   "a length or a percentage of the diagonal like 0.1%");
    return is_share ? value / 100 * diagonal : value;
}

/// largest=N, min_area=1%, min_triangles=N, separated by commas.
void read_components(const std::string& words, RepairOptions& repair) {
    constexpr const char* expected = "largest=N, min_area=P% or min_triangles=N, separated by commas";
    const std::string shown = "--components " + words;
    for (std::size_t from = 0; from <= words.size();) {
        const std::size_t comma = std::min(words.find(',', from), words.size());
        const std::string_view rule = std::string_view(words).substr(from, comma - from);
        from = comma + 1;
        const std::size_t equals = std::min(rule.find('='), rule.size());
        const std::string_view key = rule.substr(0, equals), value = rule.substr(std::min(equals + 1, rule.size()));
        if (key == "min_area" && value.ends_with('%')) {
            repair.min_area_share = number_of(value.substr(0, value.size() - 1), shown, expected) / 100;
            continue;
        }
        if (key != "largest" && key != "min_triangles") throw InvalidInput(text(shown, ": must be ", expected));
        const double number = number_of(value, shown, expected);
        if (number < 1 || number > 2e9 || number != std::floor(number))
            throw InvalidInput(text(shown, ": must be ", expected, ", N a whole number >= 1"));
        (key == "largest" ? repair.keep_largest : repair.min_triangles) = static_cast<int>(number);
    }
}

/// The options with lengths resolved for a surface of this diagonal.
RepairOptions resolved(const RepairArguments& options, double diagonal) {
    RepairOptions repair = options.repair;
    if (options.all) {
        const RepairOptions all = all_repairs(diagonal);
        const RepairOptions given = repair;
        repair = all;
        repair.fill = given.fill;
    }
    if (!options.weld.empty()) repair.weld = length_of(options.weld, "--weld", diagonal);
    if (!options.cracks.empty()) repair.cracks = length_of(options.cracks, "--cracks", diagonal);
    if (!options.joints.empty()) repair.joints = length_of(options.joints, "--joints", diagonal);
    if (options.holes == "all")
        repair.holes = std::numeric_limits<double>::infinity();
    else if (!options.holes.empty())
        repair.holes = length_of(options.holes, "--holes", diagonal);
    if (!options.holes.empty()) repair.keep_symmetry_loops = false;
    if (options.fill != "planar" && options.fill != "smooth")
        throw InvalidInput(text("--fill ", options.fill, ": must be planar or smooth"));
    repair.fill = options.fill == "smooth" ? HoleFill::smooth : HoleFill::planar;
    if (!options.components.empty()) read_components(options.components, repair);
    validate(repair);
    return repair;
}

bool is_any_requested(const RepairOptions& r) {
    return r.weld || r.cracks || r.holes || r.duplicates || r.degenerate || r.orient || r.split || r.isolated ||
           r.joints || r.keep_largest > 0 || r.min_area_share > 0 || r.min_triangles > 0;
}

constexpr RepairKind kinds[] = {RepairKind::weld,   RepairKind::duplicate, RepairKind::degenerate, RepairKind::crack,
                                RepairKind::orient, RepairKind::split,     RepairKind::component,  RepairKind::hole,
                                RepairKind::joint,  RepairKind::isolated};

/// Names and numbers of defects, the same as in `info --json`.
std::vector<std::pair<const char*, long>> counts(const Checkup& c) {
    const TopologyFacts& f = c.facts;
    const auto n = [](const auto& list) { return static_cast<long>(list.size()); };
    return {{"vertices", c.vertices},
            {"triangles", c.triangles},
            {"components", f.components},
            {"boundary_loops", n(f.boundary_loops)},
            {"crack_vertices", n(c.crack_vertices)},
            {"nonmanifold_edges", n(f.nonmanifold_edges)},
            {"nonmanifold_vertices", n(f.nonmanifold_vertices)},
            {"misoriented_edges", n(f.misoriented_edges)},
            {"duplicate_triangles", n(f.duplicate_triangles)},
            {"degenerate_triangles", n(f.degenerate_triangles)},
            {"inverted_triangles", n(c.inverted_triangles)},
            {"isolated_vertices", n(f.isolated_vertices)},
            {"duplicate_vertices", n(f.duplicate_vertices)},
            {"self_intersections", c.pairs ? n(c.pairs->apart) + n(c.pairs->adjacent) : -1}};
}

nlohmann::ordered_json or_null(long number) {
    return number < 0 ? nlohmann::ordered_json() : nlohmann::ordered_json(number);
}

nlohmann::ordered_json counts_json(const Checkup& c) {
    nlohmann::ordered_json json;
    for (const auto& [name, count] : counts(c)) json[name] = or_null(count);
    json["closed"] = c.facts.closed;
    json["orientable"] = c.facts.orientable;
    return json;
}

std::string as_json(const RepairResult& result, const std::string& out) {
    nlohmann::ordered_json json, repairs = nlohmann::ordered_json::object(), items = nlohmann::ordered_json::array();
    for (const RepairKind kind : kinds) repairs[name_of(kind)] = result.count(kind);
    for (const RepairItem& item : result.items)
        items.push_back({{"kind", name_of(item.kind)},
                         {"vertex", or_null(item.vertex)},
                         {"triangle", or_null(item.triangle)},
                         {"at", {item.at.x(), item.at.y(), item.at.z()}},
                         {"size", item.size},
                         {"triangles", item.triangles},
                         {"words", item.words}});
    json["repairs"] = std::move(repairs);
    json["before"] = counts_json(result.before);
    json["after"] = counts_json(result.after);
    json["remaining"] = result.remaining;
    json["items"] = std::move(items);
    json["file"] = out;
    return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

std::string as_words(const RepairResult& result, const std::string& out) {
    std::string words;
    constexpr int shown = 3;
    for (const RepairKind kind : kinds) {
        const int count = result.count(kind);
        if (count == 0) continue;
        words += fmt::format("{}: {}\n", name_of(kind), count);
        int listed = 0;
        for (const RepairItem& item : result.items)
            if (item.kind == kind && listed++ < shown)
                words +=
                    fmt::format("  {}, at ({:g}, {:g}, {:g})\n", item.words, item.at.x(), item.at.y(), item.at.z());
        if (count > shown) words += fmt::format("  and {} more (--list FILE or --json lists all)\n", count - shown);
    }
    if (words.empty()) words = "none of the requested repairs was needed: the surface is written unchanged\n";
    const auto before = counts(result.before), after = counts(result.after);
    for (std::size_t i = 0; i < before.size(); ++i)
        if (i < 2 || before[i].second != after[i].second)
            words += fmt::format("{:<22}{:>10} -> {}\n", before[i].first, before[i].second, after[i].second);
    for (const std::string& line : result.remaining) words += "remaining: " + line + "\n";
    return words + fmt::format("{}: {}\n", out, result.after.facts.closed ? "closed" : "open");
}

void print_repaired(const std::string& words) {
    std::fputs(words.c_str(), stdout);  // main reports output that cannot be written
}

void repair_file(const RepairArguments& options) {
    format_of(options.out);  // a wrong extension is reported before the work
    check_outputs({options.out, options.list}, {options.surface});
    if (!is_any_requested(resolved(options, 1)))
        throw InvalidInput(
            "repair: no repair is requested; give --all, or some of --weld, --duplicates, --degenerate, --cracks, "
            "--orient, --split, --holes, --joints, --components, --isolated");
    end_on_signals("strake: repair: interrupted; nothing was written\n");
    const SurfaceFile file = read_logged(options.surface);
    const TriMesh& mesh = file.mesh;
    const RepairResult result = repair(mesh, resolved(options, box_diagonal(mesh)));
    watch_signals();  // from here on the output is completed
    write_output(options.out, result.mesh, file.format);
    if (!options.list.empty()) write_atomically(options.list, repair_csv(result));
    if (options.json)
        print_repaired(as_json(result, options.out));
    else if (!options.quiet)
        print_repaired(as_words(result, options.out));
}

}  // namespace

void add_repair(CLI::App& app) {
    auto options = std::make_shared<RepairArguments>();
    CLI::App* command = app.add_subcommand("repair", "repair a surface: only the defects you ask for");
    command->add_option("SURFACE", options->surface, "surface file, any format that info reads")->required();
    command->add_option("-o,--out,--output", options->out, "surface file; the extension selects the format")
        ->required();
    command->add_flag("--all", options->all,
                      "everything except dropping components and joints: weld 1e-7%, cracks 1e-3%, holes up to 10% "
                      "across that do not "
                      "lie in a symmetry plane; other options override these");
    command->add_option("--weld", options->weld,
                        "merge vertices at most this far apart: a length, or a percentage of the diagonal like 1e-6%");
    command->add_flag("--duplicates", options->repair.duplicates,
                      "remove triangles that have the same vertices as another");
    command->add_flag("--degenerate", options->repair.degenerate,
                      "remove triangles without area, without opening the surface");
    command->add_option("--cracks", options->cracks, "join open edges at most this far apart");
    command->add_flag("--orient", options->repair.orient, "orient all triangles consistently; closed parts outward");
    command->add_flag("--split", options->repair.split, "separate parts that meet only in a vertex or an edge");
    command->add_option("--holes", options->holes,
                        "close boundary loops at most this far across: a length, a percentage, or all");
    command->add_option("--joints", options->joints,
                        "halve edges where parts pass through each other until they are at most this long");
    command->add_option("--fill", options->fill, "planar: no new vertices (default); smooth: refined and curved")
        ->type_name("planar|smooth");
    command->add_option(
        "--components", options->components,
        "components to keep: largest=N, min_area=1% (of the area), min_triangles=N, separated by commas");
    command->add_flag("--isolated", options->repair.isolated, "remove vertices that no triangle uses");
    command->add_option("--list", options->list, "write every single repair as CSV");
    command->add_flag("-q,--quiet", options->quiet, "do not print the summary");
    command->add_flag("--json", options->json, "print one JSON object instead of words");
    command->callback([options, command] {
        if (command->count("--fill") > 0 && options->holes.empty() && !options->all)
            throw InvalidInput(text("--fill ", options->fill, ": needs --holes or --all"));
        repair_file(*options);
    });
}

}  // namespace strake::cli
