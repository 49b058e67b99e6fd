#include "casefile/load_case.hpp"
#include "core/error.hpp"
#include "core/text/file.hpp"
#include "studio/case_edit.hpp"
#include "studio/case_form.hpp"
#include "studio/choice_json.hpp"
#include "studio/studio_impl.hpp"

#include <algorithm>

/// The case in the editor: its errors, its regions, and what is being chosen.
namespace strake {

namespace fs = std::filesystem;

namespace {

using Json = nlohmann::ordered_json;

Json errors_json(const CaseError& error) {
    Json list = Json::array();
    for (const Diagnostic& d : error.diagnostics)
        list.push_back({{"line", d.place.line}, {"column", d.place.column}, {"message", d.message}});
    return list;
}

/// The regions that the editor's text declares, where it can be read; they may be part of what is chosen.
std::optional<Case> readable_case(const std::string& yaml, const fs::path& file) {
    try {
        return load_case_text(yaml, file, Purpose::deform);
    } catch (const InvalidInput&) {
        return {};
    }
}

ChoiceGround ground_for(const Subject& subject, const std::optional<Case>& the_case) {
    static const std::vector<Region> none;
    if (!the_case) return {.ground = subject.ground, .declared = none, .found_wing = subject.wing_places.get()};
    return {subject.ground,     the_case->regions,        the_case->planform, the_case->aero.axes.value_or(BodyAxes{}),
            the_case->symmetry, subject.wing_places.get()};
}

std::string direction_word(const Eigen::Vector3d& direction) {
    for (int c = 0; c < 3; ++c)
        if (std::abs(direction[c]) > 1 - 1e-9) return std::string(direction[c] < 0 ? "-" : "+") + "xyz"[c];
    return text("[", exact_words(direction[0]), ", ", exact_words(direction[1]), ", ", exact_words(direction[2]), "]");
}

bool uses_found_wing(const std::vector<ChoiceStep>& steps) {
    return std::any_of(steps.begin(), steps.end(), [](const ChoiceStep& step) {
        const auto* box = std::get_if<WingBox>(&step.what);
        return box && box->wing.empty();
    });
}

/// A case of which the objective is still to be chosen.
std::string first_case(const std::string& surface) {
    return "surface: {file: \"" + surface +
           "\"}\n\n# REPLACE THIS by your objective: a built-in quantity (docs/objectives.md) or your own program "
           "(docs/external.md).\nobjective: {maximize: volume}\nconstraints:\n  area: {max: 1.01, relative: true}\n"
           "optimize:\n  budget: {evaluations: 60}\n";
}

std::string numbers_text(const std::vector<int>& numbers) {
    std::string bytes;
    for (const int number : numbers) bytes += std::to_string(number) + "\n";
    return bytes;
}

}  // namespace

std::shared_ptr<const Subject> Studio::Impl::need_subject() {
    const std::lock_guard lock(busy);
    if (!subject) throw Declined("no surface is open");
    return subject;
}

fs::path Studio::Impl::case_path() {
    const std::lock_guard lock(busy);
    return case_file.empty() ? folder / "case.yaml" : case_file;
}

/// {errors: [{line, column, message}], regions, ground_changed}. Nothing that the case names is executed.
Studio::Impl::Json Studio::Impl::check(const Asked& asked) {
    const std::string yaml = text_in(asked, "text");
    const fs::path file = case_path();
    std::shared_ptr<const Subject> shown;
    {
        const std::lock_guard lock(busy);
        shown = subject;
    }
    Json answer{{"errors", Json::array()}, {"regions", Json::array()}, {"ground_changed", false}};
    try {
        const Case the_case = load_case_text(yaml, file);
        answer["ground_changed"] = !shown || shown->blocks != ground_blocks(yaml);
        if (!shown) return answer;
        answer["regions"] = regions_json(*shown, the_case);
        for (const Json& region : answer["regions"])
            if (region.contains("error"))
                answer["errors"].push_back(
                    {{"line", region["error_line"]}, {"column", 1}, {"message", region["error"]}});
    } catch (const CaseError& error) {
        answer["errors"] = errors_json(error);
    }
    return answer;
}

/// {marks, triangles, area, kind, lines: how the case would say it}.
Studio::Impl::Json Studio::Impl::choose(const Asked& asked) {
    const auto shown = need_subject();
    const auto the_case = readable_case(text_in(asked, "text"), case_path());
    const ChoiceGround ground = ground_for(*shown, the_case);
    if (!asked.contains("steps")) throw InvalidInput("'steps' is missing");
    const auto steps = choice_steps(asked["steps"], shown->ground.start.mesh);
    const std::vector<char> marks = chosen(ground, steps);
    double area = 0;
    int count = 0;
    for (std::size_t t = 0; t < marks.size(); ++t)
        if (marks[t]) {
            area += shown->ground.start.area[static_cast<Eigen::Index>(t)];
            ++count;
        }
    Json answer{
        {"marks", packed_marks(marks)}, {"triangles", count}, {"area", area}, {"kind", ""}, {"lines", Json::array()}};
    if (count == 0) return answer;
    try {
        const std::string name = asked.contains("name") ? text_in(asked, "name") : "chosen";
        if (steps.size() == 1 && uses_found_wing(steps)) {
            WingBox box = std::get<WingBox>(steps[0].what);
            box.wing = "wing";
            answer["kind"] = "part of a wing, which the case will declare";
            answer["lines"].push_back(region_line({name, wing_box_words(box)}));
            return answer;
        }
        const Description words = described(ground, steps, marks, name, name + "-triangles.txt");
        answer["kind"] = words.kind;
        for (const RegionText& region : words.regions) answer["lines"].push_back(region_line(region));
    } catch (const InvalidInput& refused) {
        answer["kind"] = refused.what();
    }
    return answer;
}

/// Declares the wing that the page shows, and makes the steps mean that. @return the text with it
std::string Studio::Impl::with_found_wing(std::string yaml, const Subject& shown, std::vector<ChoiceStep>& steps) {
    if (!shown.wing) throw Declined("no wing is found on this surface; declare one under planform");
    const WingDeclaration& found = shown.wing->declaration;
    const std::string name = "wing";
    if (entry_span(yaml, "planform." + name))
        throw Declined("the case declares a wing already: choose parts of that one");
    const auto is_other = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return (a - b).norm() > 1e-9; };
    const auto the_case = readable_case(yaml, case_path());
    const BodyAxes axes = the_case ? the_case->aero.axes.value_or(BodyAxes{}) : BodyAxes{};
    if (is_other(axes.downstream, found.downstream) || is_other(axes.up, found.up))
        yaml =
            with_value(yaml, "axes",
                       "{downstream: " + direction_word(found.downstream) + ", up: " + direction_word(found.up) + "}");
    std::string on;
    if (!found.triangles.empty()) {
        const std::string surface = "wing-surface", list_file = surface + "-triangles.txt";
        std::vector<char> marks(static_cast<std::size_t>(shown.ground.start.mesh.num_triangles()), 0);
        for (const int t : found.triangles) marks[static_cast<std::size_t>(t)] = 1;
        const auto ground = ground_for(shown, the_case);
        const Description words =
            described(ground, {{Combine::add, PickedTriangles{found.triangles}}}, marks, surface, list_file);
        for (const RegionText& region : words.regions) yaml = with_region(yaml, region);
        write_list(list_file, words.numbers, yaml);
        on = "on: " + surface + ", ";
    }
    yaml = with_value(yaml, "planform." + name, "{" + on + "span: " + direction_word(found.span) + "}");
    for (ChoiceStep& step : steps)
        if (auto* box = std::get_if<WingBox>(&step.what); box && box->wing.empty()) box->wing = name;
    return yaml;
}

/// Beside the case, where no other file is in the way.
void Studio::Impl::write_list(const std::string& name, const std::vector<int>& numbers, const std::string& known_from) {
    if (numbers.empty()) return;
    need_write();
    const fs::path file = case_path().parent_path() / name;
    std::error_code ignored;
    if (fs::exists(fs::symlink_status(file, ignored)) && known_from.find(name) == std::string::npos)
        throw InvalidInput(
            text(name, " exists already, and this case does not name it: choose another name for the region"));
    write_atomically(file, numbers_text(numbers));
}

/// {text}: the editor's text with the chosen region, under `fixed`, too, if asked. A list of triangles is written
/// beside the case.
Studio::Impl::Json Studio::Impl::put_region(const Asked& asked) {
    const auto shown = need_subject();
    const std::string asked_text = text_in(asked, "text");
    std::string yaml = asked_text;
    if (yaml.find_first_not_of(" \t\r\n") == std::string::npos) yaml = first_case(shown->surface.filename().string());
    const std::string name = text_in(asked, "name"), list_file = name + "-triangles.txt";
    if (!asked.contains("steps")) throw InvalidInput("'steps' is missing");
    auto steps = choice_steps(asked["steps"], shown->ground.start.mesh);
    if (uses_found_wing(steps)) yaml = with_found_wing(yaml, *shown, steps);
    auto the_case = readable_case(yaml, case_path());
    // A region is not described by its own former self.
    if (the_case) std::erase_if(the_case->regions, [&](const Region& region) { return region.name == name; });
    const ChoiceGround ground = ground_for(*shown, the_case);
    const Description words = described(ground, steps, chosen(ground, steps), name, list_file);
    for (const RegionText& region : words.regions) yaml = with_region(yaml, region);
    std::string taken_out;
    if (asked.value("fix", false)) {
        yaml = with_fixed(yaml, name);
        // Of a proposal for a body without a held part; the two exclude each other.
        if (const auto hold = entry_span(yaml, "hold")) {
            taken_out = "hold: " + hold->words;
            yaml = with_value(yaml, "hold", "");
        }
    }
    write_list(list_file, words.numbers, asked_text);
    return {{"text", yaml}, {"kind", words.kind}, {"taken_out", taken_out}};
}

Studio::Impl::Json Studio::Impl::form(const Asked& asked) { return case_form(text_in(asked, "text")); }

/// {text}: with these values at these paths of keys.
Studio::Impl::Json Studio::Impl::set_values(const Asked& asked) {
    std::string yaml = text_in(asked, "text");
    if (!asked.contains("values") || !asked["values"].is_array()) throw InvalidInput("'values' must be a list");
    if (asked["values"].size() > 50) throw InvalidInput("at most 50 values at a time");
    for (const Asked& one : asked["values"]) {
        if (!one.is_array() || one.size() != 2 || !one[0].is_string() || !one[1].is_string())
            throw InvalidInput("a value is [path, words]");
        yaml = with_value(yaml, one[0].get<std::string>(), one[1].get<std::string>());
    }
    return {{"text", yaml}};
}

}  // namespace strake
