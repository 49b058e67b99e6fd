#include "casefile/load_case.hpp"
#include "casefile/schema/scalars.hpp"
#include "cli/commands.hpp"
#include "cli/continuation.hpp"
#include "cli/rebuild.hpp"
#include "cli/say.hpp"
#include "cli/session.hpp"
#include "core/error.hpp"
#include "core/text/file.hpp"

#include <fmt/core.h>
#include <cmath>

namespace strake::cli {
namespace {

struct ResumeArguments {
    std::string folder;
    std::string evaluations,
        time;  ///< "100", "2h": total; "+50", "+30min": added to the present limit; empty: unchanged
    bool json = false, quiet = false, rebuild = false;
};

std::string read_duration(const std::string& words, double& seconds) {
    Value value;
    value.text = words;
    const Key key{.path = "time", .type = Type::duration};
    const std::string why = convert_scalar(value, Type::duration, key, {});
    seconds = value.number;
    return why;
}

/// A limit for `resume`: the total, or with '+' an amount added to the present limit.
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
        const double n = raised("--evaluations", args.evaluations, before.evaluations,
                                "for example 100 (total) or +50 (more)", read_number);
        if (n != std::floor(n) || n > 1e9)
            throw InvalidInput(text("--evaluations = ", args.evaluations, " must be a whole number"));
        now.evaluations = static_cast<int>(n);
    }
    if (!args.time.empty())
        now.seconds =
            raised("--time", args.time, before.seconds, "for example 2h (total) or +30min (more)", read_duration);
    return now;
}

/// Not: a damaged, foreign or newer one, which is left as it is.
bool is_missing_or_empty(const std::filesystem::path& journal) {
    std::error_code ignored;
    if (!std::filesystem::exists(journal, ignored)) return true;
    try {
        Journal::open(journal);
        return false;
    } catch (const InputError& error) {
        return std::string(error.what()).find("holds nothing") != std::string::npos;
    }
}

/// The case of the folder, as it may have been edited there.
void load(RunRequest& request, const std::filesystem::path& dir, const std::filesystem::path& case_dir) {
    Case& the_case = request.the_case;
    the_case = load_case(dir / "case.yaml", request.is_fit ? Purpose::fit : Purpose::run, case_dir);
    the_case.output.dir = dir;
    the_case.output.is_resumed = true;
}

/// The run ended before its first evaluation.
void start(RunRequest request, const ResumeArguments& args, const std::filesystem::path& dir) {
    const Beginning began = beginning_of(dir);
    request.is_fit = began.is_fit;
    load(request, dir, began.case_dir);
    clear_journal(dir);
    OptimizeOptions& limits = request.the_case.optimize;
    const RunLimits now = new_limits(args, {0, limits.max_evaluations, limits.max_seconds}, request.the_case, false);
    limits.max_evaluations = now.evaluations;
    limits.max_seconds = now.seconds;
    if (!args.quiet) say("strake: the run ended before its first evaluation; it starts now\n");
    carry_out(std::move(request));
}

std::unique_ptr<Journal> usable_journal(const std::filesystem::path& dir, bool rebuild) {
    std::unique_ptr<Journal> journal;
    try {
        journal = Journal::open(dir / "journal.sqlite");
        check_against_history(*journal, dir);
        return journal;
    } catch (const InputError& error) {
        journal.reset();
        const std::string why = error.what();
        if (rebuild) return rebuilt_journal(dir);
        const bool is_lost = why.find("damaged") != why.npos || why.find("holds nothing") != why.npos ||
                             why.find("No such file") != why.npos || why.find("is no file") != why.npos ||
                             why.find("is of version") != why.npos || why.find("is no journal") != why.npos;
        throw InputError(why.find("--rebuild") == why.npos && is_lost ? why + rebuild_words(dir) : why);
    }
}

void resume(const ResumeArguments& args) {
    outlive_readers();
    const std::filesystem::path dir = args.folder;
    std::error_code ignored;
    if (!std::filesystem::exists(dir, ignored)) throw InvalidInput(printable(args.folder, 400) + ": no such folder");
    if (!std::filesystem::is_directory(dir, ignored))
        throw InvalidInput(text(printable(args.folder, 400), ": is not a folder; resume takes the folder of a run, ",
                                "`strake run` a case file"));
    const auto has = [&](const char* name) { return std::filesystem::exists(dir / name, ignored); };
    if (!has("journal.sqlite") && !has("lock") && !says_how_it_began(dir))
        throw InvalidInput(printable(args.folder, 400) + ": is not a run folder (it has no journal.sqlite)");
    RunRequest request;
    request.folder = std::make_unique<RunFolder>(dir, true);
    request.json = args.json;
    request.quiet = args.quiet;
    if (has_evaluated_nothing(dir) && is_missing_or_empty(dir / "journal.sqlite"))
        return start(std::move(request), args, dir);
    request.journal = usable_journal(dir, args.rebuild);
    Journal& journal = *request.journal;
    const JournalFacts& facts = journal.facts();
    request.is_fit = facts.is_fit;
    if (!has("case.yaml")) request.folder->write_case(facts.case_yaml);
    load(request, dir, facts.case_dir);
    keep_meaning(request.the_case, facts.meaning);
    const Continuation now = continuation(request.the_case, facts, dir);
    const RunLimits limits = new_limits(args, journal.limits(), request.the_case, now.has_new_budget);
    begin_again(request, now, limits);
    if (!args.quiet)
        say("strake: continuing after {} of {} evaluations\n", journal.evaluations().size(), limits.evaluations);
    if (facts.host != host_name())
        say("note: the run started on {}; if this machine computes different bits, resume reports it and stops\n",
            printable(facts.host));
    carry_out(std::move(request));
}

}  // namespace

void add_resume(CLI::App& app) {
    auto args = std::make_shared<ResumeArguments>();
    CLI::App* command = app.add_subcommand("resume", "continue a run that was interrupted, killed or has ended");
    command->add_option("RUN", args->folder, "run folder")->required();
    command->add_option("--evaluations", args->evaluations,
                        "budget of the whole run, for example 100; or +50 for more");
    command->add_option("--time", args->time, "time limit of the whole run, for example 2h; or +30min for more");
    command->add_flag("--rebuild", args->rebuild,
                      "if the journal is damaged: make a new one from what can still be read of it and of the folders");
    command->add_flag("--json", args->json, "print the results as JSON");
    command->add_flag("-q,--quiet", args->quiet, "do not print progress");
    command->callback([args] { resume(*args); });
}

}  // namespace strake::cli
