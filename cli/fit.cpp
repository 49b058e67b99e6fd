#include "cli/build_case.hpp"
#include "cli/commands.hpp"
#include "cli/session.hpp"

#include <memory>

namespace strake::cli {

void add_fit(CLI::App& app) {
    auto args = std::make_shared<SessionArguments>();
    CLI::App* command = app.add_subcommand("fit", "fit the design variables to a target shape, coarse to fine");
    command->add_option("CASE", args->case_file, "case file (YAML)")->required();
    add_set_option(*command, args->settings);
    command->add_option("-o,--out,--output", args->out,
                        "run folder, new or empty (default: output.dir of the case, otherwise runs/<case>)");
    command->add_flag("--json", args->json, "print the results as JSON");
    command->add_flag("-q,--quiet", args->quiet, "do not print progress");
    command->callback([args] { run_session(*args, true); });
}

}  // namespace strake::cli
