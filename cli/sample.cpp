#include "casefile/load_case.hpp"
#include "casefile/yaml/value.hpp"
#include "cli/build_case.hpp"
#include "cli/commands.hpp"
#include "cli/session.hpp"
#include "core/error.hpp"

#include <memory>
#include <optional>

namespace strake::cli {
namespace {

struct SampleArguments {
    SessionArguments session;
    int designs = 0, parallel = 0;  ///< 0: not given
    std::optional<unsigned> seed;
    std::string method, table;
};

/// A text as YAML between quotes.
std::string quoted(const std::string& words) {
    std::string out = "\"";
    for (const char c : words) out += c == '"' || c == '\\' ? std::string{'\\', c} : std::string(1, c);
    return out + "\"";
}

std::string method_in(const Value& sample) {
    for (const Entry& entry : sample.entries)
        if (entry.key == "method") return entry.value.text;
    return "";
}

/// The method that the command line or the case says, the last word first; empty: neither does. A case is only complete
/// with it, so it cannot be loaded to ask.
std::string method_of(const SampleArguments& args) {
    if (!args.method.empty()) return args.method;
    const std::vector<std::string>& settings = args.session.settings;
    for (auto setting = settings.rbegin(); setting != settings.rend(); ++setting)
        for (const std::string key : {"sample.method=", "sample="})
            if (setting->starts_with(key)) {
                const Value value = parse_yaml(setting->substr(key.size()), "--set");
                const std::string method = key == "sample=" ? method_in(value) : value.text;
                if (!method.empty() || key == "sample=") return method;
            }
    const Value root = parse_yaml(read_case_file(args.session.case_file), args.session.case_file);
    for (const Entry& entry : root.entries)
        if (entry.key == "sample") return method_in(entry.value);
    return "";
}

/// Everything that was asked for stands in the case.yaml of the folder, so that `resume` knows it.
void sample(SampleArguments& args) {
    std::vector<std::string>& settings = args.session.settings;
    if (!args.table.empty()) {
        const std::filesystem::path table = std::filesystem::absolute(args.table).lexically_normal();
        std::error_code ignored;
        if (!std::filesystem::exists(table, ignored))
            throw InputError(printable(args.table, 400) + ": no such file; give a table (CSV) of designs and values");
        settings.push_back("sample.table=" + quoted(table.string()));
    }
    const std::string method = method_of(args);
    settings.push_back("sample.method=" + (method.empty() ? "sobol" : method));
    if (args.seed && method != "lhs")
        throw InvalidInput("--seed is for --method lhs: the other methods give the same designs each time");
    if (args.seed) settings.push_back(text("optimize.seed=", *args.seed));
    if (args.designs > 0) settings.push_back(text("optimize.budget.evaluations=", args.designs));
    if (args.parallel > 0)
        for (const QuantityEntry& quantity : load_case(args.session.case_file, Purpose::run, settings).quantities)
            if (std::holds_alternative<ExternalEntry>(quantity.what))
                settings.push_back(text("quantities.", quoted(quantity.name), ".parallel=", args.parallel));
    run_session(args.session, false);
}

}  // namespace

void add_sample(CLI::App& app) {
    auto args = std::make_shared<SampleArguments>();
    CLI::App* command = app.add_subcommand(
        "sample", "evaluate designs spread over the space of a case, and say which variables matter");
    command->add_option("CASE", args->session.case_file, "case file (YAML)")->required();
    CLI::Option* designs =
        command->add_option("-n,--designs", args->designs, "number of designs, the start included, for example 64")
            ->check(CLI::Range(2, 1'000'000));
    CLI::Option* method = command
                              ->add_option("--method", args->method,
                                           "sobol (default): a sequence that `resume --evaluations +32` goes on with; "
                                           "lhs: a Latin hypercube; levels: all combinations of equidistant levels of "
                                           "each variable, as many as there are designs for")
                              ->check(CLI::IsMember({"sobol", "lhs", "levels"}));
    CLI::Option* seed = command->add_option("--seed", args->seed, "of the Latin hypercube (default: optimize.seed)");
    CLI::Option* parallel =
        command->add_option("--parallel", args->parallel, "maximum number of concurrent calls of each program")
            ->check(CLI::Range(1, 100'000));
    CLI::Option* table = command->add_option(
        "--read", args->table, "table (CSV) of designs that have been evaluated elsewhere, in place of new ones");
    table->excludes(designs)->excludes(method)->excludes(parallel)->excludes(seed);
    add_set_option(*command, args->session.settings);
    command->add_option("-o,--out,--output", args->session.out,
                        "run folder, new or empty (default: output.dir of the case, otherwise runs/<case>)");
    command->add_flag("--json", args->session.json, "print the results as JSON");
    command->add_flag("-q,--quiet", args->session.quiet, "do not print progress");
    command->callback([args, table, designs] {
        if (table->count() + designs->count() == 0)
            throw InvalidInput("say how many designs: strake sample CASE -n 64, or --read TABLE");
        sample(*args);
    });
}

}  // namespace strake::cli
