#include "casefile/load_case.hpp"
#include "cli/build_case.hpp"
#include "cli/commands.hpp"
#include "cli/session.hpp"
#include "core/error.hpp"

#include <memory>

namespace strake::cli {
namespace {

struct SampleArguments {
    SessionArguments session;
    int designs = 0, parallel = 0;  ///< 0: not given
    std::string method, table;
};

/// A text as YAML between quotes.
std::string quoted(const std::string& words) {
    std::string out = "\"";
    for (const char c : words) out += c == '"' || c == '\\' ? std::string{'\\', c} : std::string(1, c);
    return out + "\"";
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
    settings.push_back("sample.method=" + (args.method.empty() ? "sobol" : args.method));
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
                                           "lhs: a Latin hypercube")
                              ->check(CLI::IsMember({"sobol", "lhs"}));
    CLI::Option* parallel =
        command->add_option("--parallel", args->parallel, "maximum number of concurrent calls of each program")
            ->check(CLI::Range(1, 100'000));
    CLI::Option* table = command->add_option(
        "--read", args->table, "table (CSV) of designs that have been evaluated elsewhere, in place of new ones");
    table->excludes(designs)->excludes(method)->excludes(parallel);
    add_set_option(*command, args->session.settings);
    command->add_option("--out", args->session.out,
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
