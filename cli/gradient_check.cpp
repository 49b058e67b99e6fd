#include "optimize/check/gradient_check.hpp"

#include "casefile/load_case.hpp"
#include "cli/build_case.hpp"
#include "cli/commands.hpp"
#include "cli/work_folder.hpp"
#include "report/json_number.hpp"

#include <fmt/core.h>
#include <memory>
#include <nlohmann/json.hpp>

namespace strake::cli {
namespace {

struct GradientCheckArguments {
    std::string case_file, out, at = "random";
    std::vector<std::string> settings;
    GradientCheckOptions options;
    bool json = false, quiet = false;
};

nlohmann::ordered_json json_of(const TaylorTest& test) {
    nlohmann::ordered_json j;
    j["name"] = test.name;
    j["passed"] = test.passed;
    j["verdict"] = test.verdict;
    j["value"] = json_number(test.value);
    j["slope"] = json_number(test.slope);
    j["differences_slope"] = json_number(test.differences_slope);
    j["uncertainty"] = json_number(test.uncertainty);
    j["order"] = json_number(test.order);
    j["steps"] = nlohmann::ordered_json::array();
    for (const TaylorStep& s : test.steps)
        j["steps"].push_back({{"h", s.h},
                              {"value", json_number(s.value)},
                              {"remainder", json_number(s.remainder)},
                              {"order", json_number(s.order)}});
    return j;
}

void print_json(const GradientCheck& check) {
    nlohmann::ordered_json j;
    j["status"] = check.passed() ? "passed" : "failed";
    j["level"] = check.level;
    j["variables"] = check.variables;
    j["point_size"] = json_number(check.size);
    j["evaluations"] = check.evaluations;
    j["tests"] = nlohmann::ordered_json::array();
    for (const TaylorTest& test : check.tests) j["tests"].push_back(json_of(test));
    fmt::print("{}\n", j.dump(2));
}

void print_table(const TaylorTest& test) {
    fmt::print("\n{}: value {:.10g}, slope {:.10g}\n", test.name, test.value, test.slope);
    fmt::print("  {:>9}  {:>12}  {:>6}\n", "h", "remainder", "order");
    for (const TaylorStep& s : test.steps) {
        if (!std::isfinite(s.value))
            fmt::print("  {:9.0e}  {:>12}\n", s.h, "no value");
        else if (std::isfinite(s.order))
            fmt::print("  {:9.0e}  {:12.3e}  {:6.2f}\n", s.h, s.remainder, s.order);
        else
            fmt::print("  {:9.0e}  {:12.3e}\n", s.h, s.remainder);
    }
    fmt::print("  {}: {}\n", test.passed ? "PASS" : "FAIL", test.verdict);
}

void check_case(const GradientCheckArguments& args) {
    Case the_case = load_case(args.case_file, Purpose::any, args.settings);
    const WorkFolder folder(args.out, "gradient-check");
    the_case.output.dir = folder.path();
    const BuiltProblem built = build_case(the_case);
    GradientCheckOptions options = args.options;
    options.at_start = args.at == "start";
    for (const std::string& warning : built.warnings) fmt::print(stderr, "warning: {}\n", warning);
    if (!args.quiet)
        fmt::print(stderr, "strake: gradient-check: {} evaluations, the first with gradients\n", options.h.size() + 1);
    const GradientCheck check = check_gradients(built.problem, options);
    for (const std::string& note : check.notes) fmt::print(stderr, "note: {}\n", note);
    if (args.json) {
        print_json(check);
    } else {
        fmt::print("level {}, {} variables, at {} (size {:.3g}), seed {}\n", check.level, check.variables, args.at,
                   check.size, options.seed);
        for (const TaylorTest& test : check.tests) print_table(test);
    }
    if (!check.passed()) throw ExitStatus{run_failed};
}

}  // namespace

void add_gradient_check(CLI::App& app) {
    auto args = std::make_shared<GradientCheckArguments>();
    CLI::App* command = app.add_subcommand(
        "gradient-check",
        "run a Taylor test on the gradients of the objective, constraints and fitted values of a case");
    command->add_option("CASE", args->case_file, "case file (YAML)")->required();
    add_set_option(*command, args->settings);
    command
        ->add_option("--at", args->at,
                     "test point: random (default; near the start) or start (of the case, or of start_from)")
        ->check(CLI::IsMember({"random", "start"}));
    command->add_option("--seed", args->options.seed, "seed of the random point and direction (default: 1)");
    command->add_option("--level", args->options.level, "level of the patches (default: the finest)")
        ->check(CLI::Range(1, 1000));
    command
        ->add_option("--accept", args->options.accept,
                     "also pass if the slopes differ by at most this fraction of the expected one (default: 0)")
        ->check(CLI::Range(0.0, 0.5));
    command->add_option("-o,--out,--output", args->out, "keep the folders of external evaluations here");
    command->add_flag("--json", args->json, "print the results as JSON");
    command->add_flag("-q,--quiet", args->quiet, "do not print progress");
    command->callback([args] { check_case(*args); });
}

}  // namespace strake::cli
