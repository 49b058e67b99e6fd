#include "cases/scalars.hpp"
#include "cli/commands.hpp"
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
    RunLimits now = before;
    if (case_is_newer) {
        now.evaluations = the_case.optimize.max_evaluations;
        now.seconds = the_case.optimize.max_seconds;
    }
    if (!args.evaluations.empty()) {
        const double n =
            raised("--evaluations", args.evaluations, before.evaluations, "as 100 (in all) or +50 (more)", read_number);
        if (n != std::floor(n) || n > 1e9)
            throw InvalidInput(text("--evaluations = ", args.evaluations, " must be a whole number"));
        now.evaluations = static_cast<int>(n);
    }
    if (!args.time.empty())
        now.seconds = raised("--time", args.time, before.seconds, "as 2h (in all) or +30min (more)", read_duration);
    const auto unlimited = [](double seconds) {
        return seconds > 0 ? seconds : std::numeric_limits<double>::infinity();
    };
    if (now.evaluations < before.evaluations || unlimited(now.seconds) < unlimited(before.seconds))
        throw InvalidInput(text("the budget of a run can only be raised: it is ", before.evaluations, " evaluations",
                                before.seconds > 0 ? text(" and ", before.seconds, " s") : "",
                                "; to end it sooner, interrupt it"));
    return now;
}

/// What is not the case that the run began with is named, and ends the attempt.
void check_same_case(const Case& the_case, const JournalFacts& facts, const std::string& yaml) {
    std::vector<std::string> changed;
    for (const std::string& key : changed_keys(facts.case_yaml, yaml))
        if (!may_change(key)) changed.push_back(key);
    if (!changed.empty())
        throw InvalidInput(text(the_case.file.string(), ": ", joined(changed), changed.size() > 1 ? " are" : " is",
                                " not what the run began with; only budget, output and timeout may change. Undo it, or "
                                "start another run (optimize.start_from begins at a design of this one)"));
    for (const auto& [key, hash] : file_hashes(the_case))
        if (const auto then = facts.files.find(key); then != facts.files.end() && then->second != hash)
            throw InvalidInput(text(the_case.file.string(), ": ", key,
                                    ": the file is not the one that the run began "
                                    "with. Put that back, or start another run"));
}

/// The last design that was the best so far; 0: none.
int last_accepted(const Journal& journal) {
    int best = 0;
    for (const JournalEvaluation& e : journal.evaluations())
        if (e.accepted) best = e.number;
    return best;
}

void resume(const ResumeArguments& args) {
    const std::filesystem::path dir = args.folder;
    std::error_code ignored;
    if (!std::filesystem::exists(dir / "journal.sqlite", ignored))
        throw InvalidInput(
            text(printable(args.folder, 400), ": holds no run that could go on (there is no journal.sqlite)"));
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
    const std::string yaml = resolved_case(the_case, dir);
    check_same_case(the_case, facts, yaml);
    const std::vector<std::string> changed = changed_keys(facts.case_yaml, yaml);
    const bool has_new_budget = std::any_of(changed.begin(), changed.end(),
                                            [](const std::string& key) { return key.starts_with("optimize.budget"); });
    const RunLimits limits = new_limits(args, journal.limits(), the_case, has_new_budget);
    journal.set_limits(limits.evaluations, limits.seconds);
    if (!changed.empty()) journal.set_case(yaml);
    request.folder->begin_best_at(last_accepted(journal));
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
    command->add_option("folder", args->folder, "folder of the run")->required();
    command->add_option("--evaluations", args->evaluations, "budget of the whole run, as 100; or +50 for more");
    command->add_option("--time", args->time, "time of the whole run, as 2h; or +30min for more");
    command->add_flag("--json", args->json, "results as JSON on standard output");
    command->add_flag("-q,--quiet", args->quiet, "no progress");
    command->callback([args] { resume(*args); });
}

}  // namespace strake::cli
