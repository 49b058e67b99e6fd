#include "cli/build_case.hpp"
#include "cli/commands.hpp"
#include "cli/session.hpp"
#include "cli/studio_session.hpp"

#include <memory>

namespace strake::cli {

void add_run(CLI::App& app) {
    auto args = std::make_shared<SessionArguments>();
    CLI::App* command = app.add_subcommand("run", "run the whole optimization of a case, coarse to fine");
    command->add_option("CASE", args->case_file, "case file (YAML)")->required();
    add_set_option(*command, args->settings);
    command->add_option("-o,--out,--output", args->out,
                        "run folder, new or empty (default: output.dir of the case, otherwise runs/<case>)");
    CLI::Option* json = command->add_flag("--json", args->json, "print the results as JSON");
    CLI::Option* quiet = command->add_flag("-q,--quiet", args->quiet, "do not print progress");
    auto shows = std::make_shared<bool>(false);
    command->add_flag("--studio", *shows, "show the run in the browser while it goes on, as strake studio does")
        ->excludes(json)
        ->excludes(quiet);
    command->callback([args, shows] {
        if (*shows)
            run_in_studio(*args);
        else
            run_session(*args, false);
    });
}

}  // namespace strake::cli
