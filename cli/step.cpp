#include "casefile/load_case.hpp"
#include "cli/build_case.hpp"
#include "cli/commands.hpp"
#include "cli/continuation.hpp"
#include "cli/say.hpp"
#include "cli/session.hpp"
#include "core/error.hpp"

#include <memory>

namespace strake::cli {
namespace {

/// Starts the run or continues it; no programs are run.
void step(const SessionArguments& args) {
    outlive_readers();
    RunRequest request;
    request.is_step = true;
    request.json = args.json;
    request.quiet = args.quiet;
    Case& the_case = request.the_case;
    const auto place = [&] {
        the_case.output.by_hand = true;
        set_output_folder(the_case, args.out);
    };
    the_case = load_case(args.case_file, Purpose::run, args.settings);
    place();
    const std::filesystem::path dir = the_case.output.dir;
    std::error_code ignored;
    if (!std::filesystem::exists(dir / "journal.sqlite", ignored)) {
        check_run_folder(dir);
        carry_out(std::move(request));
        return;
    }
    request.folder = std::make_unique<RunFolder>(dir, true);
    request.journal = Journal::open(dir / "journal.sqlite");
    the_case = load_case(args.case_file, Purpose::run, args.settings, request.journal->facts().case_yaml);
    place();
    the_case.output.is_resumed = true;
    if (request.journal->facts().is_fit)
        throw InvalidInput(text(dir.string(), ": is the folder of a fit; `strake step` needs a run"));
    const Continuation now = continuation(the_case, request.journal->facts(), dir);
    keep_meaning(the_case, request.journal->facts().meaning);
    const RunLimits before = request.journal->limits();
    begin_again(
        request, now,
        now.has_new_budget ? RunLimits{0, the_case.optimize.max_evaluations, the_case.optimize.max_seconds} : before);
    carry_out(std::move(request));
}

}  // namespace

void add_step(CLI::App& app) {
    auto args = std::make_shared<SessionArguments>();
    CLI::App* command =
        app.add_subcommand("step", "hand out the evaluations needed next, and continue with those already answered");
    command->add_option("CASE", args->case_file, "case file (YAML)")->required();
    add_set_option(*command, args->settings);
    command->add_option("-o,--out,--output", args->out,
                        "run folder: new, or that of the previous steps (default: output.dir of the case)");
    command->add_flag("--json", args->json, "print the results as JSON");
    command->add_flag("-q,--quiet", args->quiet, "do not print progress");
    command->callback([args] { step(*args); });
}

}  // namespace strake::cli
