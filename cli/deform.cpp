#include "casefile/load_case.hpp"
#include "casefile/schema/scalars.hpp"
#include "cli/build_case.hpp"
#include "cli/commands.hpp"
#include "cli/outputs.hpp"
#include "core/error.hpp"
#include "core/fields/displacement_fields.hpp"
#include "core/formats/io.hpp"
#include "core/formats/vtp.hpp"
#include "core/mesh/geometry.hpp"
#include "core/planform/planform_motion.hpp"
#include "core/wrap/wrap_map.hpp"
#include "optimize/evaluate/shape_solver.hpp"
#include "optimize/evaluate/validity.hpp"
#include "optimize/problem/sliding_parts.hpp"
#include "optimize/space/design_space.hpp"
#include "report/json_number.hpp"

#include <fmt/core.h>
#include <charconv>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <utility>

namespace strake::cli {
namespace {

struct DeformArguments {
    std::string case_file, out, prisms;
    std::vector<std::string> settings, fields;
    bool linear = false, json = false, quiet = false;
};

double largest_displacement(const Points& from, const Points& to) { return (to - from).rowwise().norm().maxCoeff(); }

nlohmann::ordered_json summary(const Equilibrium& end, const std::string& status, double moved) {
    nlohmann::ordered_json j;
    j["status"] = status;
    j["reason"] = end.reason;
    const bool is_solved = end.iterations > 0;  // a linear response is not an equilibrium
    j["energy"] = json_number(end.energy);
    j["gradient_norm"] = is_solved ? json_number(end.gradient_norm) : nullptr;
    j["relative_gradient"] = is_solved ? json_number(end.relative_gradient) : nullptr;
    j["iterations"] = end.iterations;
    j["last_step"] = json_number(end.last_step);
    j["max_displacement"] = json_number(moved);
    j["stable"] = end.stable;
    j["solver"] = nlohmann::ordered_json::array({to_string(end.first_solver)});
    if (end.solver != end.first_solver) j["solver"].push_back(to_string(end.solver));
    j["factorizations"] = end.factorizations;
    j["substitutions"] = end.substitutions;
    j["load_steps"] = end.load_steps;
    j["seconds"] = {{"assembly", end.seconds.assembly},
                    {"ordering", end.seconds.ordering},
                    {"factorization", end.seconds.factorization},
                    {"substitution", end.seconds.substitution}};
    return j;
}

void write_prisms(const DeformArguments& args, const PrimoShell& shell) {
    const TriMesh prisms = shell.prism_surface();
    std::vector<int> triangle(prisms.num_triangles());
    for (int s = 0; s < prisms.num_triangles(); ++s) triangle[s] = s / 8;
    write_vtp(args.prisms, prisms, {}, {{"triangle", triangle}});
}

void report(const DeformArguments& args, const Equilibrium& end, const std::string& status, double moved,
            double diagonal) {
    if (args.json) {
        fmt::print("{}\n", summary(end, status, moved).dump(2));
        return;
    }
    fmt::print("status            {}: {}\n", status, end.reason);
    if (std::isfinite(end.energy)) fmt::print("energy            {:.10g}\n", end.energy);
    if (end.iterations > 0)
        fmt::print("relative gradient {:.2e}\nlast step         {:.2e} of the diagonal\n", end.relative_gradient,
                   end.last_step);
    if (std::isfinite(moved))
        fmt::print("max displacement  {:.6g} ({:.3g} % of the diagonal)\n", moved, 100 * moved / diagonal);
}

/// Reports why there is no surface and ends the program with status 1.
[[noreturn]] void refuse(const DeformArguments& args, const Equilibrium& end, const std::string& status,
                         double diagonal) {
    report(args, end, status, std::numeric_limits<double>::quiet_NaN(), diagonal);
    fmt::print(stderr, "strake: deform: {}; nothing was written\n", end.reason);
    throw ExitStatus{run_failed};
}

ValidityGuard guard_of(const Problem& problem) {
    return {problem.surface,
            adjacency(problem.surface),
            {problem.fixed, problem.symmetry, sliding_triangles(problem), !problem.has_shell}};
}

/// Of displacement fields and changes of wings.
std::string names_of(const Problem& problem) {
    std::string all;
    const std::vector<UserVariable>& user = problem.parameters.user_variables;
    for (std::size_t g = 0; g < user.size() && g < 12; ++g) all += (g > 0 ? ", " : "") + user[g].name;
    return user.size() > 12 ? all + ", ... (strake check --json lists all)" : all;
}

/// A change of a wing, "3deg", "0.05rad", "-2%".
double change_value(const PlanformMotion::Variable& change, const std::string& written, const std::string& words) {
    Value value;
    value.text = written;
    const bool angle = is_angle(change.change);
    const std::string error = convert_scalar(value, angle ? Type::angle : Type::fraction, Key{}, {});
    if (!error.empty() || (!angle && value.number != 0 && !written.ends_with('%')))
        throw InvalidInput(text("--field ", printable(words, 400), ": must be ", change.name,
                                angle ? "=ANGLE with deg or rad" : "=CHANGE in percent, for example 2%"));
    return value.number;
}

void check_in_range(const PlanformMotion::Variable& change, double value, const std::string& words) {
    const bool angle = is_angle(change.change);
    const double unit = angle ? 180 / std::numbers::pi : 100;
    if (value < change.lower || value > change.upper)
        throw InvalidInput(text("--field ", printable(words, 400), ": ", change.name, " = ", unit * value,
                                angle ? " deg" : " %", " is outside of its range [", unit * change.lower, ", ",
                                unit * change.upper, "] in parameters.planform"));
}

/// How far a field moves the surface at most. @param words all that was written
double field_value(const std::string& value, const std::string& words, double diagonal) {
    const bool is_share = !value.empty() && value.back() == '%';
    const char* end = value.data() + value.size() - (is_share ? 1 : 0);
    double length = 0;
    const auto [stop, error] = std::from_chars(value.data(), end, length);
    if (error != std::errc{} || stop != end || !std::isfinite(length))
        throw InvalidInput(text("--field ", printable(words, 400),
                                ": must be NAME=LENGTH, in the unit of the surface or like 2% of its diagonal"));
    return is_share ? length / 100 * diagonal : length;
}

/// "NAME=VALUE" into the demand: a length, which a field moves the surface by at most, or a change of a wing.
void take_field(const Problem& problem, const std::string& words, ShellDemand& demand) {
    const double diagonal = box_diagonal(problem.surface);
    const std::size_t at = words.find('=');
    const std::string name = words.substr(0, at), value = at == std::string::npos ? "" : words.substr(at + 1);
    for (const UserVariable& v : problem.parameters.user_variables) {
        if (v.name != name) continue;
        if (v.planform >= 0) {
            const auto& change = problem.parameters.planform->variables()[static_cast<std::size_t>(v.planform)];
            demand.planform[v.planform] += change_value(change, value, words);
            return check_in_range(change, demand.planform[v.planform], words);
        }
        demand.fields[v.field] += field_value(value, words, diagonal);
        return;
    }
    throw InvalidInput(
        text("--field ", printable(words, 400), ": there is no field of that name; fields: ", names_of(problem)));
}

/// The surface moved by displacement fields and changes of wings alone.
Points moved_by_fields(const DeformArguments& args, const Problem& problem, Equilibrium& end) {
    const double diagonal = box_diagonal(problem.surface);
    if (args.fields.empty())
        throw InvalidInput(
            text("deform: the case has shell: none, where displacement fields and changes of wings alone move the "
                 "surface; name at least one with --field NAME=VALUE. Fields: ",
                 names_of(problem)));
    if (args.linear || !args.prisms.empty())
        throw InvalidInput("deform: --linear and --prisms need an elastic shell, and the case has shell: none");
    const std::shared_ptr<const RestFacts> rest = rest_facts(problem);
    ShellDemand demand;
    if (problem.parameters.fields) demand.fields = Eigen::VectorXd::Zero(problem.parameters.fields->size());
    if (problem.parameters.planform) demand.planform = Eigen::VectorXd::Zero(problem.parameters.planform->size());
    for (const std::string& words : args.fields) take_field(problem, words, demand);
    const Points vertices = with_fields(*rest, demand, problem.surface.vertices);
    end.status = SolveStatus::converged;
    end.reason = "moved by displacement fields and changes of wings";
    const std::string defect = guard_of(problem).defect(vertices, local_maps(*rest, demand));
    if (defect.empty()) return vertices;
    end.reason = defect + "; reduce the values of the fields";
    refuse(args, end, "invalid", diagonal);
}

/// The surface by the shell's vertices: in a wrap it is carried along; what of its displacement keeps the kind of
/// shape that the case states.
Points of_kind(const Problem& problem, const Points& vertices) {
    if (problem.wrap)
        return problem.wrap->displacement(vertices - problem.wrap->mesh().vertices) + problem.surface.vertices;
    const auto& invariance = problem.parameters.invariance;
    if (!invariance) return vertices;
    return problem.surface.vertices + invariance->projected(vertices - problem.surface.vertices);
}

/// @param vertices of the surface, with the shell where it is
std::string defect_of_solved(const Problem& problem, const PrimoShell& shell, const Points& vertices) {
    if (!problem.wrap) return guard_of(problem).defect(vertices, shell.poses());
    const std::shared_ptr<const RestFacts> rest = rest_facts(problem);
    return strake::defect_of(strake::guard_of(problem, rest), *rest, {}, vertices, &shell);
}

/// The equilibrium, which must be a valid surface.
Points solved(const DeformArguments& args, const Problem& problem, const ShellSetup& setup, PrimoShell& shell,
              Equilibrium& end) {
    const double diagonal = box_diagonal(problem.surface);
    const auto progress = [&](const SolveRecord& r) {
        if (r.iteration > 0 && !args.quiet && !args.json)
            fmt::print(stderr, "iteration {:3}  energy {: .10e}  step {:.1e}  gradient {:.1e}  {:.1f} s\n", r.iteration,
                       r.energy, r.step, r.relative_gradient, r.seconds);
        return true;
    };
    end = shell.solve(setup.loads, setup.motions, {}, progress);
    if (end.status != SolveStatus::converged) refuse(args, end, to_string(end.status), diagonal);
    const Points vertices = of_kind(problem, shell.vertices());
    const std::string defect = defect_of_solved(problem, shell, vertices);
    if (defect.empty()) return vertices;
    end.reason = defect + "; reduce the loads and strains, or use a thicker shell";
    refuse(args, end, "invalid", diagonal);
}

/// The paper's single linear solve, valid or not.
Points linear(const Problem& problem, const ShellSetup& setup, PrimoShell& shell, Equilibrium& end) {
    const Points vertices = of_kind(problem, shell.linear_response(setup.loads, setup.motions));
    end.reason = "one linear solve at rest";
    if (problem.wrap) return vertices;  // the shell itself has not moved
    const std::string defect = guard_of(problem).defect(vertices, shell.poses());
    if (!defect.empty()) fmt::print(stderr, "warning: the linear response is not a valid surface: {}\n", defect);
    return vertices;
}

void deform_case(const DeformArguments& args) {
    const Case the_case = load_case(args.case_file, Purpose::deform, args.settings);
    check_outputs({args.out, args.prisms}, {args.case_file, the_case.surface});
    const BuiltProblem built = build_case(the_case, Purpose::deform);
    const TriMesh& mesh = built.problem.surface;
    ShellSetup setup = shell_setup(built.problem);
    setup.options.expected_solves = 1;
    for (const std::vector<std::string>* list : {&built.warnings, &std::as_const(setup).warnings})
        for (const std::string& warning : *list) fmt::print(stderr, "warning: {}\n", warning);
    if (built.problem.has_shell && the_case.loads.empty() && the_case.strains.empty())
        fmt::print(stderr,
                   "warning: {}: nothing moves: the case has neither loads nor strains (strake explain loads)\n",
                   printable(args.case_file, 400));

    Equilibrium end;
    if (!built.problem.has_shell) {
        const Points vertices = moved_by_fields(args, built.problem, end);
        write_output(args.out, with_vertices(mesh, vertices), built.format);
        report(args, end, "converged", largest_displacement(mesh.vertices, vertices), box_diagonal(mesh));
        return;
    }
    if (!args.fields.empty())
        throw InvalidInput("deform: --field needs shell: none in the case; a shell is deformed by loads and strains");
    PrimoShell shell(elastic_surface(built.problem), setup.options);
    const Points vertices =
        args.linear ? linear(built.problem, setup, shell, end) : solved(args, built.problem, setup, shell, end);
    write_output(args.out, with_vertices(mesh, vertices), built.format);
    if (!args.prisms.empty()) write_prisms(args, shell);
    report(args, end, args.linear ? "linear" : "converged", largest_displacement(mesh.vertices, vertices),
           box_diagonal(mesh));
}

void deform(const DeformArguments& args) {
    format_of(args.out);  // a wrong extension is reported before the work
    try {
        deform_case(args);
    } catch (const UnheldPart& loose) {
        Equilibrium end;
        end.reason = loose.what();
        report(args, end, "unheld", std::numeric_limits<double>::quiet_NaN(), 1);
        throw;
    }
}

}  // namespace

void add_deform(CLI::App& app) {
    auto args = std::make_shared<DeformArguments>();
    CLI::App* command =
        app.add_subcommand("deform", "compute one deformation from the fixed regions, loads and strains of a case");
    command->add_option("CASE", args->case_file, "case file (YAML)")->required();
    add_set_option(*command, args->settings);
    command->add_option("-o,--out,--output", args->out, "deformed surface; the extension selects the format")
        ->required();
    command
        ->add_option("--field", args->fields,
                     "with shell: none: NAME=VALUE moves the surface by this displacement field, at most by this "
                     "length or percentage of the diagonal, or changes a wing by this angle or percentage; repeatable")
        ->expected(1)
        ->take_all();
    command->add_flag("--linear", args->linear, "a single linear solve at rest instead of the equilibrium");
    command->add_option("--prisms", args->prisms, "write the deformed prisms for ParaView (.vtp)");
    command->add_flag("--json", args->json, "print the results as JSON");
    command->add_flag("-q,--quiet", args->quiet, "do not print progress");
    command->callback([args] { deform(*args); });
}

}  // namespace strake::cli
