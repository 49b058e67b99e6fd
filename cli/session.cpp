#include "cli/session.hpp"
#include "cli/detail.hpp"

#include "casefile/load_case.hpp"
#include "casefile/schema/scalars.hpp"
#include "cli/build_case.hpp"
#include "cli/commands.hpp"
#include "cli/plugin_exit.hpp"
#include "cli/progress.hpp"
#include "cli/say.hpp"
#include "cli/signals.hpp"
#include "core/mesh/geometry.hpp"
#include "core/text/file.hpp"
#include "core/text/shell_word.hpp"
#include "optimize/run/coarse_to_fine.hpp"
#include "optimize/run/design_table.hpp"
#include "optimize/run/fit.hpp"
#include "optimize/space/parameters.hpp"
#include "report/recorded_run.hpp"
#include "report/run_folder.hpp"
#include "report/run_report.hpp"

#include <fmt/core.h>
#include <csignal>
#include <cstring>
#include <nlohmann/json.hpp>
#include <numbers>

namespace strake::cli {
namespace {

/// A start value at the level of round-off, or of what a search leaves undecided, counts as zero.
std::string percent(double from, double to) {
    return std::abs(from) > 1e-6 * std::abs(to) ? fmt::format("{:+.4g} %", 100 * (to - from) / std::abs(from))
                                                : "from zero";
}

/// What a level gained; a failed one has no values to show.
std::string level_change(const LevelSummary& s, bool is_fit) {
    if (!std::isfinite(s.objective_start) || !std::isfinite(s.objective_end)) return "no design";
    if (!is_fit)
        return fmt::format("{:.9g} -> {:.9g} ({})", s.objective_start, s.objective_end,
                           percent(s.objective_start, s.objective_end));
    const std::string share = std::isfinite(s.explained)
                                  ? fmt::format(", removes {:.2f} % of the remaining distance", 100 * s.explained)
                                  : "";
    return fmt::format("rms distance {:.4e} -> {:.4e}{}", std::sqrt(s.objective_start), std::sqrt(s.objective_end),
                       share);
}

void report_design(const Problem& problem, const RunResult& r, bool is_fit) {
    const double diagonal = box_diagonal(problem.surface);
    for (std::size_t i = 0; i < r.values.size(); ++i)
        fmt::print("{:<11}  {:.9g} -> {:.9g} ({})\n", r.names[i], r.values_start[i], r.values[i],
                   percent(r.values_start[i], r.values[i]));
    const auto own = parameter_values(r.space, r.x);
    for (std::size_t i = 0; i < own.size(); ++i)
        fmt::print("{:<11}  {} -> {}\n", own[i].first,
                   shown_value(r.space.rest->program_parameters[i].start, problem.program_parameters[i].is_angle),
                   shown_value(own[i].second, problem.program_parameters[i].is_angle));
    for (const auto& [name, value, is_angle] : planform_values(r.space, r.x))
        fmt::print("{:<11}  {:+.4g} {}\n", name, (is_angle ? 180 / std::numbers::pi : 100) * value,
                   is_angle ? "deg" : "%");
    if (is_fit) fmt::print("rms distance {:.3e} of the diagonal remains\n", std::sqrt(r.objective) / diagonal);
    if (!is_fit && !problem.constraints.empty()) fmt::print("violation    {:.2e} (largest, scaled)\n", r.max_violation);
    fmt::print("moved        at most {:.4g} % of the diagonal\n",
               100 * (r.vertices - problem.surface.vertices).rowwise().norm().maxCoeff() / diagonal);
}

/// The variables that matter most for each value.
void report_effects(const SampleSummary& samples) {
    constexpr std::size_t shown = 8;
    if (!samples.without_effects.empty()) fmt::print("{}\n", samples.without_effects);
    for (const std::string& remark : samples.remarks) fmt::print("note         {}\n", remark);
    for (const SampledValue& value : samples.values) {
        fmt::print("{:<11}  deviation {:.4g}; the model predicts {:.1f} % of the variance of a design left out\n",
                   value.name, value.deviation, 100 * std::max(0.0, value.predicted_share));
        std::vector<std::size_t> order(value.share.size());
        for (std::size_t k = 0; k < order.size(); ++k) order[k] = k;
        std::ranges::stable_sort(order, std::greater(), [&](std::size_t k) { return value.share[k]; });
        for (std::size_t k = 0; k < std::min(shown, order.size()); ++k)
            fmt::print("  {:<24} main effect {:5.1f} % +- {:.1f} %, with interactions {:5.1f} %\n",
                       samples.table->variables[order[k]], 100 * value.share[order[k]], 100 * value.error[order[k]],
                       100 * value.total[order[k]]);
    }
}

/// @param dir the run folder as the user named it
/// @param has_page report.html is there
void report(const Problem& problem, const RunResult& r, const RunFolder& folder, const std::filesystem::path& dir,
            bool is_fit, bool has_page) {
    fmt::print("status       {}\nreason       {}\n", r.status, r.reason);
    fmt::print("evaluations  {}, on {} levels\n", r.evaluations, r.levels.size());
    for (const LevelSummary& s : r.levels)
        fmt::print("  level {}    {} patches, {} variables, {} evaluations: {}\n", s.level, s.patches, s.variables,
                   s.evaluations, level_change(s, is_fit));
    if (r.best_evaluation > 0) report_design(problem, r, is_fit);
    if (r.samples) report_effects(*r.samples);
    fmt::print("files        {}:", dir.string());
    for (const std::string& file : folder.files())
        if (file.find('/') == std::string::npos) fmt::print(" {}", file);
    fmt::print("\n");
    const auto& files = folder.files();
    if (std::find(files.begin(), files.end(), "series.pvd") != files.end())
        fmt::print("view         paraview {}\n", typed_path((dir / "series.pvd").string()));
    if (has_page) fmt::print("open         {}\n", typed_path((dir / "report.html").string()));
}

void print_json(const RunResult& result, const RunFolder& folder, const std::filesystem::path& dir) {
    std::vector<std::string> files;
    for (const std::string& file : folder.files()) files.push_back((dir / file).string());
    fmt::print("{}\n", run_json(result, files));
}

/// With -v, below the line of the evaluation.
std::string evaluation_detail(const std::vector<std::string>& names, const EvaluationRecord& r) {
    std::string out = fmt::format("       evaluation {}: {:.3g} s", r.evaluation, r.seconds);
    for (std::size_t i = 0; i < std::min(names.size(), r.values.size()); ++i)
        out += fmt::format(", {} = {:.9g}", names[i], r.values[i]);
    if (r.is_taken_over) out += " (same shape as on the previous level: nothing was called)";
    if (r.is_replayed) out += " (from the journal)";
    return r.reason.empty() ? out : out + ": " + r.reason;
}

void warn(const std::string& words) { say("warning: {}\n", words); }

/// What the user sees of the search, and how the user stops it.
RunEvents shown(const Problem& problem, Progress& progress) {
    RunEvents events;
    events.stop_wanted = stop_wanted;
    events.level = [&](const LevelStart& level) { progress.level(level); };
    events.evaluation = [&, names = value_names(problem)](const EvaluationRecord& record) {
        progress.evaluation(record);
        if (wants_detail()) progress.note(evaluation_detail(names, record));
    };
    events.level_end = [&](const LevelSummary& level) { progress.level_end(level); };
    events.note = [&](const std::string& words) { progress.note(words); };
    return events;
}

/// The command that continues the run.
std::string continue_command(const RunRequest& request) {
    const std::string folder = typed_path(request.the_case.output.dir.string());
    if (!request.is_step) return fmt::format("`strake resume {}`", folder);
    return fmt::format("`strake step {} --out {}`", typed_path(request.the_case.file.string()), folder);
}

/// The end of `run`, `fit`, `step` and `resume`: the summary and the exit status.
void conclude(const BuiltProblem& built, const RunResult& result, const RunRequest& request) {
    RunFolder& folder = *request.folder;
    const std::filesystem::path& dir = request.the_case.output.dir;
    const bool is_fit = request.is_fit;
    const bool makes_report = wants_report(request.the_case.output) && result.status != "waiting";
    bool has_page = makes_report && has_report_page();
    if (has_page) folder.list_file("report.html");
    folder.finish(result);
    if (makes_report)
        if (const std::string why = make_report(built, request.the_case, folder.folder()); !why.empty()) {
            warn(why);
            has_page = false;
        }
    constexpr std::size_t enough = 5;
    for (std::size_t i = 0; i < std::min(enough, folder.problems().size()); ++i)
        say("warning: {}\n", folder.problems()[i]);
    if (request.json)
        print_json(result, folder, dir);
    else if (result.status == "waiting")
        for (const AwaitedCall& call : result.awaited) fmt::print("{}\n", call.folder);
    else if (!request.is_step)
        report(built.problem, result, folder, dir, is_fit, has_page);
    else if (!request.quiet)  // standard output lists what is awaited: nothing
        say("strake: {}: {}; see {}\n", result.status, result.reason, printable(dir.string()));
    if (result.status == "waiting") {
        if (!request.quiet) say("strake: {}; then {} again\n", result.reason, continue_command(request));
        return;
    }
    if (result.is_done()) return;
    const std::string again = continue_command(request);
    if (result.status == "interrupted") {
        say("strake: interrupted by SIG{} after {} evaluations; all are kept; {} continues\n",
            ::sigabbrev_np(stop_signal()), result.evaluations, again);
        if (!result.pending.empty())
            say("strake: still in the queue: {}; the continued run waits for it\n", joined(result.pending));
        throw ExitStatus{interrupted};
    }
    say("strake: {}: {}: {}\n", is_fit ? "fit" : "run", result.status, result.reason);
    if (result.status != "evaluation_failed") throw ExitStatus{run_failed};
    say("strake: once this is fixed, {} continues with this evaluation\n", again);
    throw ExitStatus{external_failed};
}

void run_case(const SessionArguments& args, bool is_fit) {
    RunRequest request;
    Case& the_case = request.the_case;
    the_case = load_case(args.case_file, is_fit ? Purpose::fit : Purpose::run, args.settings);
    set_output_folder(the_case, args.out);
    check_run_folder(the_case.output.dir);
    if (!args.quiet) say("strake: reading {}\n", the_case.surface.string());
    request.is_fit = is_fit;
    request.json = args.json;
    request.quiet = args.quiet;
    carry_out(std::move(request));
}

}  // namespace

void set_output_folder(Case& the_case, const std::string& wanted) {
    if (!wanted.empty()) the_case.output.dir = wanted;
    if (the_case.output.dir.empty()) the_case.output.dir = std::filesystem::path("runs") / the_case.name;
}

void carry_out(RunRequest request) {
    const Case& the_case = request.the_case;
    const BuiltProblem built = build_case(the_case, request.is_fit ? Purpose::fit : Purpose::run);
    const RunLimits limits =
        request.journal ? request.journal->limits()
                        : RunLimits{0, built.problem.optimize.max_evaluations, built.problem.optimize.max_seconds};
    Progress progress(request.quiet, request.is_fit, box_diagonal(built.problem.surface), limits.evaluations,
                      limits.seconds);
    for (const std::string& words : built.notes) progress.note(words);
    for (const std::string& words : built.warnings) progress.warning(words);
    if (!request.folder) request.folder = std::make_unique<RunFolder>(the_case.output.dir);
    RunFolder& folder = *request.folder;
    watch_signals(
        fmt::format("strake: ended at once: evaluations in progress are lost, all before are kept; {} continues",
                    continue_command(request)));
    say_at_exit(
        fmt::format("all evaluations before are kept; once this is fixed, {} continues", continue_command(request)));
    const RunResult result = recorded_run(built, the_case, folder, request.is_fit, shown(built.problem, progress),
                                          std::move(request.journal), [](const std::string& words) { warn(words); });
    progress.end();
    conclude(built, result, request);
}

void run_session(const SessionArguments& args, bool is_fit) {
    outlive_readers();
    try {
        run_case(args, is_fit);
    } catch (const UnheldPart& loose) {
        RunResult result;
        result.status = "unheld";
        result.reason = loose.what();
        if (args.json) fmt::print("{}\n", run_json(result, {}));
        throw;
    }
}

}  // namespace strake::cli
