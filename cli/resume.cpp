#include "cases/scalars.hpp"
#include "cli/commands.hpp"
#include "cli/continuation.hpp"
#include "cli/session.hpp"
#include "core/error.hpp"
#include "core/mesh/file.hpp"

#include <fmt/core.h>
#include <cmath>

namespace strake::cli {
namespace {

struct ResumeArguments {
    std::string folder;
    std::string evaluations, time;  ///< "100", "2h": in all; "+50", "+30min": more than before; empty: as before
    bool json = false, quiet = false;
};

std::string read_duration(const std::string& words, double& seconds) {
    Value value;
    value.text = words;
    const Key key{.path = "time", .type = Type::duration};
    const std::string why = convert_scalar(value, Type::duration, key, {});
    seconds = value.number;
    return why;
}

/// A limit as `resume` takes it: in all, or with '+' more than before.
double raised(const std::string& option, const std::string& words, double before, const std::string& hint,
              std::string (*read)(const std::string&, double&)) {
    const bool is_more = words.starts_with('+');
    double value = 0;
    const std::string why = read(words.substr(is_more ? 1 : 0), value);
    if (!why.empty() || !(value > 0))
        throw InvalidInput(text(option, " = ", printable(words), " ", why.empty() ? "must be > 0" : why, "; ", hint));
    return is_more ? before + value : value;
}

RunLimits new_limits(const ResumeArguments& args, const RunLimits& before, const Case& the_case, bool case_is_newer) {
    RunLimits now =
        case_is_newer ? RunLimits{0, the_case.optimize.max_evaluations, the_case.optimize.max_seconds} : before;
    if (!args.evaluations.empty()) {
        const double n =
            raised("--evaluations", args.evaluations, before.evaluations, "as 100 (in all) or +50 (more)", read_number);
        if (n != std::floor(n) || n > 1e9)
            throw InvalidInput(text("--evaluations = ", args.evaluations, " must be a whole number"));
        now.evaluations = static_cast<int>(n);
    }
    if (!args.time.empty())
        now.seconds = raised("--time", args.time, before.seconds, "as 2h (in all) or +30min (more)", read_duration);
    return now;
}

void resume(const ResumeArguments& args) {
    const std::filesystem::path dir = args.folder;
    std::error_code ignored;
    if (!std::filesystem::exists(dir / "journal.sqlite", ignored))
        throw InvalidInput(
            text(printable(args.folder, 400), !std::filesystem::exists(dir, ignored)
                                                  ? ": there is no such folder"
                                                  : ": holds no run that could go on (there is no journal.sqlite)"));
    RunRequest request;
    request.folder = std::make_unique<RunFolder>(dir, true);
    request.journal = Journal::open(dir / "journal.sqlite");
    request.json = args.json;
    request.quiet = args.quiet;
    Journal& journal = *request.journal;
    const JournalFacts& facts = journal.facts();
    request.is_fit = facts.is_fit;
    if (!std::filesystem::exists(dir / "case.yaml", ignored)) request.folder->write_case(facts.case_yaml);
    Case& the_case = request.the_case;
    the_case = load_case(dir / "case.yaml", facts.is_fit ? Purpose::fit : Purpose::run, facts.case_dir);
    the_case.output.dir = dir;
    the_case.output.goes_on = true;
    const Continuation now = continuation(the_case, facts, dir);
    const RunLimits limits = new_limits(args, journal.limits(), the_case, now.has_new_budget);
    begin_again(request, now, limits);
    if (!args.quiet)
        fmt::print(stderr, "strake: goes on after {} of {} evaluations\n", journal.evaluations().size(),
                   limits.evaluations);
    if (facts.host != host_name())
        fmt::print(stderr,
                   "note: the run began on {}; where this machine computes other bits, it will say so and stop\n",
                   printable(facts.host));
    carry_out(std::move(request));
}

}  // namespace

void add_resume(CLI::App& app) {
    auto args = std::make_shared<ResumeArguments>();
    CLI::App* command = app.add_subcommand("resume", "goes on with a run that was interrupted, killed, or has ended");
    command->add_option("RUN", args->folder, "folder of the run")->required();
    command->add_option("--evaluations", args->evaluations, "budget of the whole run, as 100; or +50 for more");
    command->add_option("--time", args->time, "time of the whole run, as 2h; or +30min for more");
    command->add_flag("--json", args->json, "results as JSON on standard output");
    command->add_flag("-q,--quiet", args->quiet, "no progress");
    command->callback([args] { resume(*args); });
}

}  // namespace strake::cli
