#include "cli/commands.hpp"
#include "cli/progress.hpp"
#include "core/error.hpp"
#include "optimize/run/history.hpp"
#include "report/json_number.hpp"
#include "report/run_status.hpp"

#include <fmt/core.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <system_error>
#include <thread>

namespace strake::cli {
namespace {

struct StatusArguments {
    std::string folder;
    bool json = false, watch = false;
    double every = 1;
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

ProgressFacts progress_of(const RunStatus& s) {
    ProgressFacts facts;
    facts.level = s.level;
    facts.evaluations = s.evaluations;
    facts.max_evaluations = s.max_evaluations;
    facts.objective = s.last_objective;
    facts.best = s.objective;
    facts.violation = s.max_violation;
    facts.seconds_each = s.seconds_each;
    if (s.max_seconds > 0) facts.seconds_left = std::max(0.0, s.max_seconds - s.seconds);
    return facts;
}

/// Until the run ends: one line rewritten in place on a terminal, elsewhere one line for each change.
void watch(const StatusArguments& args) {
    constexpr int log_width = 200;
    const int width = terminal_width(STDOUT_FILENO);
    std::string before;
    for (RunStatus s = run_status(args.folder); s.status == "running"; s = run_status(args.folder)) {
        const std::string line = progress_line(progress_of(s), width > 1 ? width - 1 : log_width);
        if (width > 0)
            fmt::print("\r{}\x1b[K", line);
        else if (line != before)
            fmt::print("{}\n", line);
        if (std::fflush(stdout) != 0) throw std::system_error(errno, std::generic_category(), "standard output");
        before = line;
        std::this_thread::sleep_for(std::chrono::duration<double>(args.every));
    }
    if (width > 0 && !before.empty()) fmt::print("\r\x1b[K");
    status(args);
}

struct HistoryArguments {
    std::string folder;
    bool csv = false, json = false;
};

void print_row(const JournalEvaluation& e, bool is_cached) {
    if (e.status == "ok")
        fmt::print("{:5}  {:5}  {:16.9e}  {:9.1e}  {:8.2f}{}{}\n", e.number, e.level, e.objective, e.max_violation,
                   e.seconds, e.accepted ? "  best" : "", is_cached ? "  cached" : "");
    else
        fmt::print("{:5}  {:5}  {}: {}\n", e.number, e.level, e.status, e.reason.substr(0, e.reason.find('\n')));
}

/// One object for each evaluation.
void print_json(const Journal& journal) {
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    const std::vector<int> cached = journal.cached();
    const std::vector<std::string>& names = journal.facts().values;
    for (const JournalEvaluation& e : journal.evaluations()) {
        const EvaluationRecord record = record_of(e);
        nlohmann::ordered_json row{{"evaluation", e.number},
                                   {"level", e.level},
                                   {"status", e.status},
                                   {"reason", e.reason},
                                   {"objective", json_number(e.objective)},
                                   {"max_violation", json_number(e.max_violation)},
                                   {"best", e.accepted},
                                   {"cached", std::binary_search(cached.begin(), cached.end(), e.number)},
                                   {"max_displacement", json_number(record.max_displacement)},
                                   {"seconds", json_number(e.seconds)}};
        row["values"] = nlohmann::ordered_json::object();
        for (std::size_t k = 0; k < std::min(names.size(), record.values.size()); ++k)
            row["values"][names[k]] = json_number(record.values[k]);
        rows.push_back(std::move(row));
    }
    fmt::print("{}\n", rows.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
}

void history(const HistoryArguments& args) {
    need_run(args.folder);
    const auto journal = Journal::look(std::filesystem::path(args.folder) / "journal.sqlite");
    if (args.json) return print_json(*journal);
    const JournalFacts& facts = journal->facts();
    if (args.csv)
        fmt::print("{}\n", history_header(facts.values, facts.parameters));
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
    CLI::App* command = app.add_subcommand("status", "show the progress of a run, also while it is running");
    command->add_option("RUN", args->folder, "folder of the run")->required();
    command->add_flag("--json", args->json, "JSON instead of words");
    CLI::Option* json = command->get_option("--json");
    CLI::Option* watching = command->add_flag("--watch", args->watch, "keep watching until the run ends");
    watching->excludes(json);
    command->add_option("--every", args->every, "seconds between updates (default: 1)")
        ->needs(watching)
        ->check(CLI::Range(0.1, 3600.0));
    command->callback([args] { args->watch ? watch(*args) : status(*args); });
}

void add_history(CLI::App& app) {
    auto args = std::make_shared<HistoryArguments>();
    CLI::App* command = app.add_subcommand("history", "list all evaluations of a run, also while it is running");
    command->add_option("RUN", args->folder, "folder of the run")->required();
    CLI::Option* csv = command->add_flag("--csv", args->csv, "in the format of history.csv, with all digits");
    command->add_flag("--json", args->json, "a JSON array with one object for each evaluation")->excludes(csv);
    command->callback([args] { history(*args); });
}

}  // namespace strake::cli
