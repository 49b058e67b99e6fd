#include "cli/commands.hpp"
#include "optimize/history.hpp"
#include "report/run_status.hpp"

#include <fmt/core.h>
#include <algorithm>
#include <memory>

namespace strake::cli {
namespace {

struct StatusArguments {
    std::string folder;
    bool json = false;
};

void status(const StatusArguments& args) {
    const RunStatus s = run_status(args.folder);
    if (args.json) {
        fmt::print("{}\n", status_json(s));
        return;
    }
    fmt::print("status       {}\nreason       {}\n", s.status, s.reason);
    fmt::print("evaluations  {} of {}, level {}, {:.1f} s\n", s.evaluations, s.max_evaluations, s.level, s.seconds);
    if (s.best_evaluation > 0)
        fmt::print("best         {:.9g}, violation {:.2e}, evaluation {}\n", s.objective, s.max_violation,
                   s.best_evaluation);
}

struct HistoryArguments {
    std::string folder;
    bool csv = false;
};

void print_row(const JournalEvaluation& e, bool is_cached) {
    if (e.status == "ok")
        fmt::print("{:5}  {:5}  {:16.9e}  {:9.1e}  {:8.2f}{}{}\n", e.number, e.level, e.objective, e.max_violation,
                   e.seconds, e.accepted ? "  best" : "", is_cached ? "  cached" : "");
    else
        fmt::print("{:5}  {:5}  {}: {}\n", e.number, e.level, e.status, e.reason.substr(0, e.reason.find('\n')));
}

void history(const HistoryArguments& args) {
    const auto journal = Journal::look(std::filesystem::path(args.folder) / "journal.sqlite");
    const JournalFacts& facts = journal->facts();
    if (args.csv)
        fmt::print("{}\n", history_header(facts.values, facts.own));
    else
        fmt::print("{:>5}  {:>5}  {:>16}  violation  {:>8}\n", "eval", "level", "objective", "time_s");
    const std::vector<int> cached = journal->cached();
    for (const JournalEvaluation& e : journal->evaluations())
        if (args.csv)
            fmt::print("{}\n", history_row(record_of(e), facts.values.size()));
        else
            print_row(e, std::binary_search(cached.begin(), cached.end(), e.number));
}

}  // namespace

void add_status(CLI::App& app) {
    auto args = std::make_shared<StatusArguments>();
    CLI::App* command = app.add_subcommand("status", "how far a run has come, also while it goes on");
    command->add_option("folder", args->folder, "folder of the run")->required();
    command->add_flag("--json", args->json, "as JSON");
    command->callback([args] { status(*args); });
}

void add_history(CLI::App& app) {
    auto args = std::make_shared<HistoryArguments>();
    CLI::App* command = app.add_subcommand("history", "all evaluations of a run, also while it goes on");
    command->add_option("folder", args->folder, "folder of the run")->required();
    command->add_flag("--csv", args->csv, "as history.csv, with all digits");
    command->callback([args] { history(*args); });
}

}  // namespace strake::cli
