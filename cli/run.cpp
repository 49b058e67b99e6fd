#include "cli/commands.hpp"
#include "cli/session.hpp"

#include <memory>

namespace strake::cli {

void add_run(CLI::App& app) {
    auto args = std::make_shared<SessionArguments>();
    CLI::App* command = app.add_subcommand("run", "the whole optimization of a case, coarse to fine");
    command->add_option("CASE", args->case_file, "case file (YAML)")->required();
    command->add_option("--out", args->out,
                        "run folder, new or empty (default: output.dir of the case, else runs/<case>)");
    command->add_flag("--json", args->json, "results as JSON on standard output");
    command->add_flag("-q,--quiet", args->quiet, "no progress");
    command->callback([args] { run_session(*args, false); });
}

}  // namespace strake::cli
