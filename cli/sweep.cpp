#include "optimize/check/sweep.hpp"
#include "core/text/file.hpp"

#include "casefile/load_case.hpp"
#include "casefile/schema/scalars.hpp"
#include "cli/build_case.hpp"
#include "cli/commands.hpp"
#include "cli/outputs.hpp"
#include "cli/work_folder.hpp"
#include "report/json_number.hpp"

#include <fmt/core.h>
#include <memory>
#include <nlohmann/json.hpp>

/// `strake sweep`: tabulates all values along design variables.
namespace strake::cli {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

struct SweepArguments {
    std::string case_file, out, keep;
    std::vector<std::string> settings, variables;
    std::vector<std::string> from, to;
    std::vector<int> steps;
    int level = 1;
    bool json = false, quiet = false;
};

/// The i-th value of an option that is given once for all variables or once for each.
template <class T>
T of_axis(const std::vector<T>& given, std::size_t i, std::size_t axes, const char* option) {
    if (given.size() != 1 && given.size() != axes)
        throw InvalidInput(text("sweep: ", option, " is given ", given.size(), " times for ", axes,
                                " variables; give it once for all, or once for each"));
    return given[given.size() == 1 ? 0 : i];
}

/// A scaled value, or the value of a parameter of the case, with its unit if that is an angle.
double end_of_range(const std::string& given, const std::string& variable, const Problem& problem, const char* option) {
    const auto is_named = [&](const ProgramParameter& parameter) { return parameter.name == variable; };
    const auto parameter = std::find_if(problem.program_parameters.begin(), problem.program_parameters.end(), is_named);
    const bool is_angle = parameter != problem.program_parameters.end() && parameter->is_angle;
    Value value;
    value.text = given;
    const std::string refused = convert_scalar(value, is_angle ? Type::angle : Type::number, Key{}, {});
    if (!refused.empty()) throw InvalidInput(text("sweep: ", option, " of ", variable, " = ", given, " ", refused));
    return value.number;
}

SweepOptions options_of(const SweepArguments& args, const Problem& problem) {
    SweepOptions options;
    options.level = args.level;
    const std::size_t n = args.variables.size();
    for (std::size_t i = 0; i < n; ++i)
        options.axes.push_back({args.variables[i],
                                end_of_range(of_axis(args.from, i, n, "--from"), args.variables[i], problem, "--from"),
                                end_of_range(of_axis(args.to, i, n, "--to"), args.variables[i], problem, "--to"),
                                of_axis(args.steps, i, n, "--steps")});
    return options;
}

bool has_objective(const Problem& problem) { return !problem.objective.empty() || !problem.fit.empty(); }

std::vector<double> numbers(const SweepPoint& point, std::size_t num_values, bool with_objective) {
    std::vector<double> out;
    if (with_objective) out.push_back(point.objective);
    for (std::size_t i = 0; i < num_values; ++i)
        out.push_back(point.values.empty() ? std::numeric_limits<double>::quiet_NaN() : point.values[i]);
    return out;
}

void print_table(const SweepOptions& options, const Sweep& sweep, bool with_objective) {
    std::string head;
    for (const SweepAxis& axis : options.axes) head += fmt::format("{:>9}  {:>22}  ", "x", axis.variable);
    head += fmt::format("{:<15}", "status");
    if (with_objective) head += fmt::format("  {:>17}", "objective");
    for (const std::string& name : sweep.names) head += fmt::format("  {:>17}", name);
    fmt::print("{}\n", head);
    for (const SweepPoint& point : sweep.points) {
        for (std::size_t i = 0; i < point.x.size(); ++i)
            fmt::print("{:9.4g}  {:22.9g}  ", point.x[i], point.physical[i]);
        fmt::print("{:<15}", point.status);
        for (const double value : numbers(point, sweep.names.size(), with_objective))
            fmt::print("  {:>17}", std::isfinite(value) ? fmt::format("{:.10g}", value) : "-");
        fmt::print("\n");
    }
}

std::string quoted(const std::string& cell) {
    if (cell.find_first_of(",\"\r\n") == std::string::npos) return cell;
    std::string out = "\"";
    for (const char c : cell) out += c == '"' ? std::string("\"\"") : std::string(1, c);
    return out + "\"";
}

std::string csv_of(const SweepOptions& options, const Sweep& sweep, bool with_objective) {
    std::string out;
    for (const SweepAxis& axis : options.axes)
        out += quoted("x " + axis.variable) + "," + quoted("physical " + axis.variable) + ",";
    out += with_objective ? "status,objective" : "status";
    for (const std::string& name : sweep.names) out += "," + quoted(name);
    out += ",reason\n";
    for (const SweepPoint& point : sweep.points) {
        for (std::size_t i = 0; i < point.x.size(); ++i)
            out += fmt::format("{:.17g},{:.17g},", point.x[i], point.physical[i]);
        out += point.status;
        for (const double value : numbers(point, sweep.names.size(), with_objective))
            out += std::isfinite(value) ? fmt::format(",{:.17g}", value) : ",";
        out += "," + quoted(point.reason) + "\n";
    }
    return out;
}

void print_json(const SweepOptions& options, const Sweep& sweep, bool with_objective) {
    Json j;
    j["level"] = options.level;
    j["variables"] = Json::array();
    for (const SweepAxis& axis : options.axes) j["variables"].push_back(axis.variable);
    j["names"] = sweep.names;
    j["points"] = Json::array();
    for (const SweepPoint& point : sweep.points) {
        Json row{{"x", point.x}, {"physical", point.physical}, {"status", point.status}};
        if (!point.reason.empty()) row["reason"] = point.reason;
        if (with_objective) row["objective"] = json_number(point.objective);
        row["values"] = point.values;
        j["points"].push_back(std::move(row));
    }
    fmt::print("{}\n", j.dump(2, ' ', false, Json::error_handler_t::replace));
}

void sweep_case(const SweepArguments& args) {
    Case the_case = load_case(args.case_file, Purpose::any, args.settings);
    check_outputs({args.out}, {args.case_file, the_case.surface});
    std::error_code unknown;
    if (!args.keep.empty() && fs::exists(args.keep, unknown) && !fs::is_empty(args.keep, unknown))
        throw InvalidInput(text("sweep: --keep ", args.keep, " is not empty; give a new or empty folder"));
    const WorkFolder folder(args.keep, "sweep");
    the_case.output.dir = folder.path();
    const BuiltProblem built = build_case(the_case);
    const SweepOptions options = options_of(args, built.problem);
    for (const std::string& warning : built.warnings) fmt::print(stderr, "warning: {}\n", warning);
    int done_points = 0;
    const Sweep result = sweep(built.problem, options, [&](const SweepPoint& point) {
        ++done_points;
        if (point.reason.empty() || args.quiet) return;
        fmt::print(stderr, "strake: sweep: point {}: {}\n", done_points, printable(point.reason, 1000));
    });
    const bool with_objective = has_objective(built.problem);
    if (!args.out.empty()) write_atomically(args.out, csv_of(options, result, with_objective));
    if (args.json)
        print_json(options, result, with_objective);
    else
        print_table(options, result, with_objective);
}

}  // namespace

void add_sweep(CLI::App& app) {
    auto args = std::make_shared<SweepArguments>();
    CLI::App* command = app.add_subcommand(
        "sweep", "tabulate the objective and all quantities along one or more design variables of a case");
    command->add_option("CASE", args->case_file, "case file (YAML)")->required();
    add_set_option(*command, args->settings);
    // One argument each: "--from -1" must not swallow what follows.
    command->add_option("--variable", args->variables, "design variable; several make a grid")
        ->required()
        ->expected(1)
        ->take_all();
    command
        ->add_option(
            "--from", args->from,
            "first value, scaled: 1 moves by max_displacement; for one of the case's `variables`, its physical value")
        ->required()
        ->expected(1)
        ->take_all();
    command->add_option("--to", args->to, "last value")->required()->expected(1)->take_all();
    command->add_option("--steps", args->steps, "number of points, including both ends")
        ->required()
        ->expected(1)
        ->take_all();
    command->add_option("--level", args->level, "level of the patches (default: 1); 0 is that of displacement fields")
        ->check(CLI::Range(0, 1000));
    command->add_option("-o,--out,--output", args->out, "also write the table to this file (CSV)");
    command->add_option("--keep", args->keep,
                        "new or empty folder to keep the files of the case's programs, one subfolder for each point");
    command->add_flag("--json", args->json, "print one JSON object instead of the table");
    command->add_flag("-q,--quiet", args->quiet, "do not report points without values");
    command->callback([args] { sweep_case(*args); });
}

}  // namespace strake::cli
