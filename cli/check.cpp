#include "casefile/load_case.hpp"
#include "casefile/model/case_source.hpp"
#include "casefile/read/resolved_case.hpp"
#include "casefile/schema/scalars.hpp"
#include "cli/build_case.hpp"
#include "cli/check_axes.hpp"
#include "cli/check_facts.hpp"
#include "cli/check_picture.hpp"
#include "cli/check_start.hpp"
#include "cli/commands.hpp"
#include "cli/held_check.hpp"
#include "cli/outputs.hpp"
#include "core/fields/invariance.hpp"
#include "core/mesh/geometry.hpp"
#include "core/mesh/triangle_box.hpp"
#include "core/planform/planform_motion.hpp"
#include "core/text/file.hpp"
#include "core/wrap/wrap_map.hpp"
#include "optimize/nlp/program/methods.hpp"
#include "optimize/problem/shell_setup.hpp"
#include "optimize/run/method_choice.hpp"

#include <fmt/core.h>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>

/// `strake check`: everything that can be found out about a case without running it.
namespace strake::cli {
namespace {

const char* name_of(AttachHow how) { return how == AttachHow::rigid ? "rigid" : "follow"; }

using Json = nlohmann::ordered_json;

struct CheckArguments {
    std::string case_file, out, picture;
    std::vector<std::string> settings;
    bool json = false, print_resolved = false, evaluate = false;
    CheckWishes wishes;
};

bool has(const Problem& problem, VariableKind kind) {
    const auto& kinds = problem.parameters.kinds;
    return std::find(kinds.begin(), kinds.end(), kind) != kinds.end();
}

/// Maximum number of variables of a level: the run drops those that turn out to move nothing.
int max_variables(const Problem& problem, const PatchLevel& level, const std::vector<int>& pin) {
    const Parameters& p = problem.parameters;
    const int directions = p.load_directions.empty() ? 3 : static_cast<int>(p.load_directions.size());
    int count = static_cast<int>(p.user_variables.size());
    for (const Patch& patch : level.patches) {
        bool is_free = false, is_on = p.variables_on.empty(), is_frozen = false;
        for (const int t : patch.triangles) {
            is_free |= pin[t] == free_prism;
            is_on |= !p.variables_on.empty() && p.variables_on[t];
            is_frozen |= !p.frozen.empty() && p.frozen[t];
        }
        if (!is_free || !is_on || is_frozen) continue;
        count += directions * has(problem, VariableKind::load) + has(problem, VariableKind::normal_load) +
                 3 * (p.strain_rotates + p.strain_translates) * has(problem, VariableKind::strain) +
                 has(problem, VariableKind::stiffness);
    }
    return count + static_cast<int>(problem.program_parameters.size());
}

std::string limits_text(const Constraint& c) {
    const char* unit = c.relative ? " x start" : "";
    if (c.equals) return fmt::format("{} = {:.10g}{}", c.quantity, *c.equals, unit);
    std::string out = c.min ? fmt::format("{:.10g}{} <= ", *c.min, unit) : "";
    out += c.quantity;
    return c.max ? out + fmt::format(" <= {:.10g}{}", *c.max, unit) : out;
}

/// What `method: auto` chooses; nothing where the case names a method, or all values have gradients.
MethodChoice chosen_by_gradients(const Problem& problem) {
    if (!problem.optimize.chooses_method || problem.objective.empty()) return {};
    return choose_method(problem, problem.optimize.max_evaluations);
}

/// Says in advance that this method cannot make use of `parallel`.
void add_serial_warning(const Problem& problem, std::vector<std::string>& warnings) {
    int programs = 0, parallel = 1;
    bool all_give_gradients = true;
    for (const Quantity& quantity : problem.quantities) {
        if (quantity.program.empty()) continue;
        ++programs;
        parallel = std::max(parallel, quantity.parallel);
        all_give_gradients &= quantity.has_sensitivities;
    }
    if (parallel < 2 || problem.objective.empty()) return;
    const MethodFacts& method = method_facts(problem.optimize.method);
    const bool by_differences = problem.optimize.finite_differences || chosen_by_gradients(problem).by_differences;
    const bool has_batches =
        method.method == Method::model ||
        (method.needs_gradients && by_differences && (!all_give_gradients || !problem.program_parameters.empty()));
    if (has_batches) return;
    warnings.push_back(
        fmt::format("parallel: {}: {} runs one evaluation at a time{}; only finite_differences and method: model run "
                    "several at once",
                    parallel, method.name,
                    programs > 1 ? fmt::format(", in which the {} programs run side by side", programs) : ""));
}

/// Where triangles are and how much of the surface.
struct Extent {
    double area = 0;
    Box box{};
};

Extent extent_of(const TriMesh& mesh, const std::vector<int>& triangles) {
    Extent found{0, triangle_box(mesh, triangles)};
    for (const int t : triangles) found.area += area_vector(mesh, t).norm();
    return found;
}

Json extent_json(std::size_t triangles, double area, const Box& box) {
    Json j{{"triangles", triangles}, {"area", area}, {"box", nullptr}};
    if (triangles > 0) j["box"] = {{box.min[0], box.min[1], box.min[2]}, {box.max[0], box.max[1], box.max[2]}};
    return j;
}

Json extent_json(const TriMesh& mesh, const std::vector<int>& triangles) {
    const Extent extent = extent_of(mesh, triangles);
    return extent_json(triangles.size(), extent.area, extent.box);
}

std::string extent_words(double area, const Box& box) {
    return fmt::format("area {:.6g}, box [{:.6g}, {:.6g}, {:.6g}] to [{:.6g}, {:.6g}, {:.6g}]", area, box.min[0],
                       box.min[1], box.min[2], box.max[0], box.max[1], box.max[2]);
}

Json as_json(const BuiltProblem& built, const std::vector<std::string>& warnings, const std::vector<int>& pin) {
    const Problem& problem = built.problem;
    Json j;
    j["status"] = "ok";
    j["case"] = problem.name;
    j["surface"] = {{"vertices", problem.surface.num_vertices()},
                    {"triangles", problem.surface.num_triangles()},
                    {"diagonal", box_diagonal(problem.surface)}};
    j["wrap"] = nullptr;
    if (problem.wrap)
        j["wrap"] = {{"vertices", problem.wrap->mesh().num_vertices()},
                     {"triangles", problem.wrap->mesh().num_triangles()},
                     {"held_triangles", problem.supports.size()},
                     {"farthest", problem.wrap->binding().largest_depth()},
                     {"options", built.wrap}};
    j["regions"] = Json::array();
    for (const RegionTriangles& region : built.regions) {
        j["regions"].push_back({{"name", region.name}});
        j["regions"].back().update(extent_json(region.triangles.size(), region.area, region.box));
    }
    j["fixed_triangles"] = problem.fixed.size();
    j["fixed"] = extent_json(problem.surface, problem.fixed);
    j["supports"] = problem.supports;
    j["kind"] = problem.parameters.invariance ? Json(to_string(problem.parameters.invariance->kind())) : Json(nullptr);
    j["attached"] = Json::array();
    for (const AttachedPart& part : problem.attached)
        j["attached"].push_back(
            {{"part", part.name}, {"triangles", part.triangles.size()}, {"how", name_of(part.how)}});
    j["levels"] = Json::array();
    for (std::size_t k = 1; k < problem.tree.levels.size(); ++k) {
        const PatchLevel& level = problem.tree.levels[k];
        j["levels"].push_back({{"level", k},
                               {"angle_deg", level.angle_deg},
                               {"patches", level.patches.size()},
                               {"max_variables", max_variables(problem, level, pin)},
                               {"each", Json::array()}});
        for (const Patch& patch : level.patches) {
            j["levels"].back()["each"].push_back({{"name", patch.name}});
            j["levels"].back()["each"].back().update(extent_json(elastic_surface(problem), patch.triangles));
        }
    }
    j["given"] = Json::array();
    for (const UserVariable& variable : problem.parameters.user_variables)
        if (variable.field < 0 && variable.planform < 0) j["given"].push_back(variable.name);
    j["fields"] = Json::array();
    for (const UserVariable& variable : problem.parameters.user_variables)
        if (variable.field >= 0) j["fields"].push_back(variable.name);
    if (const auto& planform = problem.parameters.planform) {
        j["planform"] = Json::array();
        for (const PlanformMotion::Variable& v : planform->variables()) {
            j["planform"].push_back({{"name", v.name}, {"min", v.lower}, {"max", v.upper}});
            if (is_angle(v.change)) j["planform"].back()["unit"] = "rad";
        }
    }
    j["variables"] = Json::array();
    for (const ProgramParameter& parameter : problem.program_parameters) {
        j["variables"].push_back(
            {{"name", parameter.name}, {"start", parameter.start}, {"min", parameter.min}, {"max", parameter.max}});
        if (parameter.is_angle) j["variables"].back()["unit"] = "rad";
    }
    j["objective"] = problem.objective.empty() ? Json(nullptr) : Json(problem.objective);
    j["fit"] = problem.fit;
    j["constraints"] = Json::array();
    for (const Constraint& c : problem.constraints) j["constraints"].push_back(limits_text(c));
    j["notes"] = built.notes;
    j["warnings"] = warnings;
    return j;
}

void print_region(const RegionTriangles& region) {
    fmt::print("region      {}: {} triangles, {}\n", region.name, region.triangles.size(),
               extent_words(region.area, region.box));
}

/// What keeps the body where it is, and what kind of shape.
void print_held(const Case& the_case, const Problem& problem) {
    if (the_case.hold.by == HoldEntry::By::fixed) {
        fmt::print("held        {} triangles fixed, {} given strains\n", problem.fixed.size(), problem.strains.size());
        const Extent extent = extent_of(problem.surface, problem.fixed);
        if (!problem.fixed.empty()) fmt::print("            fixed: {}\n", extent_words(extent.area, extent.box));
    } else if (the_case.hold.by == HoldEntry::By::none)
        fmt::print("held        nothing: the fields neither move nor turn the body in the mean\n");
    else
        for (const int t : problem.supports) {
            const Eigen::Vector3d x = area_centroid(elastic_surface(problem), {t});
            fmt::print(
                "held        triangle {} at ({:.6g}, {:.6g}, {:.6g}): the shell there, and the fields' place and "
                "attitude\n",
                t, x[0], x[1], x[2]);
        }
    if (const auto& invariance = problem.parameters.invariance)
        fmt::print("kind        {}: {} vertices in {} classes that move alike\n", to_string(invariance->kind()),
                   invariance->num_vertices(), invariance->num_classes());
}

void print_written(const CheckArguments& args) {
    for (const std::string& file : {args.picture, args.wishes.modes, args.wishes.wrap})
        if (!file.empty()) fmt::print("wrote       {}\n", printable(file, 400));
}

void print_planform(const Problem& problem) {
    if (const auto& planform = problem.parameters.planform)
        for (const PlanformMotion::Variable& v : planform->variables()) {
            const double unit = is_angle(v.change) ? 180 / std::numbers::pi : 100;
            fmt::print("planform    {} in [{:.6g}, {:.6g}] {}\n", v.name, unit * v.lower, unit * v.upper,
                       is_angle(v.change) ? "deg" : "%");
        }
}

/// What the case has because it says nothing of its variables.
std::string chosen_by_default(const Case& the_case) {
    const Value* parameters = the_case.source->root.find("parameters");
    const auto by_default = [&](const char* key) -> const Value* {
        const Value* value = parameters ? parameters->find(key) : nullptr;
        return value && value->from_default ? value : nullptr;
    };
    const Value* fields = by_default("fields");
    if (!fields || fields->text == "none") return "";
    const Value *split = by_default("split"), *kinds = by_default("variables");
    std::string words = "fields: " + fields->text;
    if (split && split->text != "all") words += ", split: " + split->text;
    if (kinds && kinds->entries.size() == 1 && kinds->entries[0].value.text == "normal")
        words += ", variables: [normal]";
    return words;
}

void print_fields(const Problem& problem, const Case& the_case, int number) {
    const std::vector<int>& steps = problem.parameters.field_steps;
    const int first = steps.empty() ? number : std::min(steps.front(), number);
    const bool by_gradient = problem.parameters.split == SplitRule::sensitivity;
    fmt::print("level 0     {} displacement fields{}\n", first,
               first == number ? ""
               : by_gradient   ? text(", then those of ", number, " that the gradient asks for")
                               : text(", up to ", number, " on later ones"));
    if (const std::string words = chosen_by_default(the_case); problem.has_shell && !words.empty())
        fmt::print(
            "by default  {}: the case says nothing of its variables (parameters: {{fields: none}} has patches "
            "alone)\n",
            words);
}

void print_given(const Problem& problem, const Case& the_case) {
    std::vector<std::string> user_variables;
    int fields = 0;
    for (const UserVariable& variable : problem.parameters.user_variables)
        if (variable.field >= 0)
            ++fields;
        else if (variable.planform < 0)
            user_variables.push_back(variable.name);
    if (fields > 0) print_fields(problem, the_case, fields);
    if (!user_variables.empty()) fmt::print("given       {}\n", joined(user_variables));
}

void print_level(const Problem& problem, std::size_t number, const std::vector<int>& pin) {
    const PatchLevel& level = problem.tree.levels[number];
    std::vector<double> areas;
    for (const Patch& patch : level.patches) areas.push_back(extent_of(elastic_surface(problem), patch.triangles).area);
    fmt::print("level {}     {} patches at {:.4g} degrees, at most {} variables", number, level.patches.size(),
               level.angle_deg, max_variables(problem, level, pin));
    if (!areas.empty())
        fmt::print("; areas {:.3g} to {:.3g} (--json, --picture)", *std::ranges::min_element(areas),
                   *std::ranges::max_element(areas));
    fmt::print("\n");
}

void print_words(const CheckArguments& args, const Case& the_case, const BuiltProblem& built,
                 const std::vector<int>& pin, const CheckFacts& facts, const std::optional<AxesFacts>& axes) {
    const Problem& problem = built.problem;
    fmt::print("case        {} ({})\n", problem.name, printable(args.case_file, 400));
    fmt::print("surface     {}: {} vertices, {} triangles, diagonal {:.6g}{}{}\n",
               printable(the_case.surface.string(), 400), problem.surface.num_vertices(),
               problem.surface.num_triangles(), box_diagonal(problem.surface), the_case.units.empty() ? "" : " ",
               the_case.units);
    constexpr std::size_t shown = 12;
    for (std::size_t k = 0; k < std::min(shown, built.regions.size()); ++k) print_region(built.regions[k]);
    if (built.regions.size() > shown)
        fmt::print("            and {} more regions (all with --json)\n", built.regions.size() - shown);
    if (problem.wrap)
        fmt::print("wrap        {} triangles, {} of them held; {}\n", problem.wrap->mesh().num_triangles(),
                   problem.supports.size(), built.wrap);
    print_held(the_case, problem);
    for (const AttachedPart& part : problem.attached)
        fmt::print("attached    {}: {} triangles, {}\n", part.name, part.triangles.size(), name_of(part.how));
    if (axes) print_axes(*axes);
    const bool is_search = !problem.objective.empty() || !problem.fit.empty();
    if (is_search) print_given(problem, the_case);
    for (std::size_t k = 1; is_search && problem.has_shell && k < problem.tree.levels.size(); ++k)
        print_level(problem, k, pin);
    print_planform(problem);
    for (const ProgramParameter& parameter : problem.program_parameters)
        fmt::print("variable    {}: {} in [{}, {}]\n", parameter.name, shown_value(parameter.start, parameter.is_angle),
                   shown_value(parameter.min, parameter.is_angle), shown_value(parameter.max, parameter.is_angle));
    if (!problem.objective.empty())
        fmt::print("objective   {} {}\n", problem.maximize ? "maximize" : "minimize", problem.objective);
    if (const MethodChoice choice = chosen_by_gradients(problem); !choice.words.empty())
        fmt::print("method      {}\n", choice.words);
    if (!problem.fit.empty()) fmt::print("fit         {}\n", joined(problem.fit));
    for (const Constraint& c : problem.constraints) fmt::print("constraint  {}\n", limits_text(c));
    print_facts(facts);
    print_written(args);
    if (!facts.start || facts.start->status == "ok") fmt::print("no errors\n");
}

/// A run would end at its first evaluation.
std::string start_error(const StartAnswer& start) {
    return fmt::format("the start design fails: {}: {}", start.status, start.reason);
}

void check(const CheckArguments& args) {
    const Case the_case = load_case(args.case_file, Purpose::any, args.settings);
    if (args.evaluate) return check_start_of(the_case, args.out, args.json);
    if (!args.picture.empty() && std::filesystem::path(args.picture).extension() != ".svg")
        throw InvalidInput(text("--picture ", printable(args.picture, 400), ": must end in .svg"));
    check_outputs({args.wishes.modes, args.wishes.wrap, args.picture}, {args.case_file, the_case.surface});
    const BuiltProblem built = build_case(the_case);
    std::vector<std::string> warnings = built.warnings;
    for (const std::string& warning : check_shell(the_case, built.problem)) warnings.push_back(warning);
    add_serial_warning(built.problem, warnings);
    const std::optional<AxesFacts> axes = axes_facts(the_case, built.problem.surface);
    if (axes && !axes->warning.empty()) warnings.push_back(axes->warning);
    if (!args.picture.empty()) write_atomically(args.picture, check_picture(the_case, built, axes));
    const std::vector<int> pin = shell_setup(built.problem).options.pin;
    const std::string resolved = args.print_resolved ? resolved_case(the_case, the_case.dir()) : "";
    const CheckFacts facts = args.print_resolved && !args.json ? CheckFacts{} : check_facts(built, args.wishes);
    const bool fails = facts.start && facts.start->status != "ok";
    if (args.json) {
        Json j = as_json(built, warnings, pin);
        if (fails) {
            j["status"] = "error";
            j["errors"] = {{{"line", 0}, {"column", 0}, {"message", start_error(*facts.start)}}};
        }
        j["axes"] = axes_json(axes);
        if (!args.picture.empty()) j["picture"] = args.picture;
        add_facts(j, facts);
        if (args.print_resolved) j["resolved"] = resolved;
        fmt::print("{}\n", j.dump(2, ' ', false, Json::error_handler_t::replace));
        if (fails) throw ExitStatus{run_failed};
        return;
    }
    for (const std::string& note : built.notes) fmt::print(stderr, "note: {}\n", note);
    for (const std::string& warning : warnings) fmt::print(stderr, "warning: {}\n", warning);
    if (args.print_resolved)
        fmt::print("{}", resolved);
    else
        print_words(args, the_case, built, pin, facts, axes);
    if (!fails) return;
    fmt::print(stderr, "strake: check: {}\n", start_error(*facts.start));
    throw ExitStatus{run_failed};
}

void print_errors(const CaseError& error) {
    Json j;
    j["status"] = "error";
    j["errors"] = Json::array();
    for (const Diagnostic& d : error.diagnostics)
        if (d.setting.empty())
            j["errors"].push_back({{"line", d.place.line}, {"column", d.place.column}, {"message", d.message}});
        else
            j["errors"].push_back({{"line", 0}, {"column", 0}, {"message", d.message}, {"setting", d.setting}});
    fmt::print("{}\n", j.dump(2, ' ', false, Json::error_handler_t::replace));
}

}  // namespace

void add_check(CLI::App& app) {
    auto args = std::make_shared<CheckArguments>();
    CLI::App* command = app.add_subcommand("check", "report everything wrong with a case, without running it");
    command->add_option("CASE", args->case_file, "case file (YAML)")->required();
    add_set_option(*command, args->settings);
    command->add_flag("--json", args->json, "print one JSON object instead of words");
    CLI::Option* evaluate = command->add_flag("--evaluate", args->evaluate,
                                              "run one evaluation at the start design and show what was read back");
    command->add_option("-o,--out,--output", args->out, "keep the folders of that evaluation here")->needs(evaluate);
    command->add_flag("--print-resolved", args->print_resolved, "print the case with every default filled in")
        ->excludes(evaluate);
    command->add_flag("--quick", args->wishes.quick, "skip what needs a factorization: variables, start, cost");
    command->add_option("--level", args->wishes.level, "level whose variables are examined (default: 1)");
    command
        ->add_option("--modes", args->wishes.modes,
                     "write the displacement by each variable at x = 1, for ParaView (.vtp)")
        ->excludes("--quick");
    command->add_option("--wrap", args->wishes.wrap,
                        "write the wrap around the body, its patches and what of it is held, for ParaView (.vtp)");
    command
        ->add_option("--picture", args->picture,
                     "draw the body with its axes as arrows, what is held, regions and patches (.svg, for a browser)")
        ->excludes(evaluate);
    command->callback([args] {
        try {
            check(*args);
        } catch (const CaseError& error) {
            if (args->json) print_errors(error);
            throw;
        }
    });
}

}  // namespace strake::cli
