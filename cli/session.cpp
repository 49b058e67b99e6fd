#include "cli/session.hpp"

#include "cases/build_problem.hpp"
#include "cli/commands.hpp"
#include "core/mesh/geometry.hpp"
#include "optimize/coarse_to_fine.hpp"
#include "optimize/fit.hpp"
#include "report/run_folder.hpp"

#include <fmt/core.h>
#include <chrono>
#include <nlohmann/json.hpp>

namespace strake::cli {
namespace {

SeriesPolicy series_policy(ParaView wanted) {
    switch (wanted) {
        case ParaView::every_accepted:
            return SeriesPolicy::every_accepted;
        case ParaView::best:
            return SeriesPolicy::best;
        case ParaView::none:
            return SeriesPolicy::none;
    }
    return SeriesPolicy::every_accepted;
}

/// The lines on stderr while it runs.
class Progress {
public:
    Progress(bool quiet, double diagonal, bool is_fit) : quiet_(quiet), is_fit_(is_fit), diagonal_(diagonal) {}

    void warning(const std::string& words) const { fmt::print(stderr, "warning: {}\n", words); }
    void note(const std::string& words) const {
        if (!quiet_) fmt::print(stderr, "{}\n", words);
    }
    void level(const LevelStart& start) {
        patches_ = static_cast<int>(start.space.patches().patches.size());
        variables_ = start.space.size();
        if (!quiet_ && !std::exchange(has_header_, true))
            fmt::print(stderr, "level  patches  vars  eval  {:>16}  violation  moved     time_s\n",
                       is_fit_ ? "rms distance" : "objective");
    }
    void evaluation(const EvaluationRecord& r) const {
        if (quiet_) return;
        const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
        if (r.status == "ok")
            fmt::print(stderr, "{:5}  {:7}  {:4}  {:4}  {:16.9e}  {:9.1e}  {:5.2f} %  {:7.1f}{}\n", r.level, patches_,
                       variables_, r.evaluation, is_fit_ ? std::sqrt(r.objective) : r.objective, r.max_violation,
                       100 * r.max_displacement / diagonal_, seconds, r.accepted ? "  best" : "");
        else
            fmt::print(stderr, "{:5}  {:7}  {:4}  {:4}  {}: {}\n", r.level, patches_, variables_, r.evaluation,
                       r.status, r.reason);
    }
    void level_end(const LevelSummary& s) const {
        if (!quiet_) fmt::print(stderr, "level {}: {} after {} evaluations\n", s.level, s.stop, s.evaluations);
    }

private:
    bool quiet_, is_fit_, has_header_ = false;
    double diagonal_;
    int patches_ = 0, variables_ = 0;
    std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

std::string percent(double from, double to) {
    return from != 0 ? fmt::format("{:+.4g} %", 100 * (to - from) / std::abs(from)) : "from zero";
}

void report(const Problem& problem, const RunResult& r, const RunFolder& folder, bool is_fit) {
    fmt::print("status       {}\nreason       {}\n", r.status, r.reason);
    fmt::print("evaluations  {}, on {} levels\n", r.evaluations, r.levels.size());
    const double diagonal = box_diagonal(problem.surface);
    for (const LevelSummary& s : r.levels) {
        const std::string change =
            is_fit
                ? fmt::format("rms distance {:.4e} -> {:.4e}, explains {:.2f} % of what was left",
                              std::sqrt(s.objective_start), std::sqrt(s.objective_end),
                              s.objective_start > 0 ? 100 * (1 - std::sqrt(s.objective_end / s.objective_start)) : 100)
                : fmt::format("{:.9g} -> {:.9g} ({})", s.objective_start, s.objective_end,
                              percent(s.objective_start, s.objective_end));
        fmt::print("  level {}    {} patches, {} variables, {} evaluations: {}\n", s.level, s.patches, s.variables,
                   s.evaluations, change);
    }
    for (std::size_t i = 0; i < r.values.size(); ++i)
        fmt::print("{:<11}  {:.9g} -> {:.9g} ({})\n", r.names[i], r.values_start[i], r.values[i],
                   percent(r.values_start[i], r.values[i]));
    if (is_fit && r.best_evaluation > 0)
        fmt::print("rms distance {:.3e} of the diagonal left\n", std::sqrt(r.objective) / diagonal);
    if (r.best_evaluation > 0 && !is_fit && !problem.constraints.empty())
        fmt::print("violation    {:.2e} (largest, scaled)\n", r.max_violation);
    if (r.vertices.rows() > 0)
        fmt::print("moved        {:.4g} % of the diagonal at most\n",
                   100 * (r.vertices - problem.surface.vertices).rowwise().norm().maxCoeff() / diagonal);
    fmt::print("files        {}:", folder.folder().string());
    for (const std::string& file : folder.files())
        if (file.find('/') == std::string::npos) fmt::print(" {}", file);
    fmt::print("\nview         paraview {}\n", (folder.folder() / "series.pvd").string());
}

void print_json(const RunResult& result, const RunFolder& folder) {
    std::vector<std::string> files;
    for (const std::string& file : folder.files()) files.push_back((folder.folder() / file).string());
    fmt::print("{}\n", run_json(result, files));
}

}  // namespace

void run_session(const SessionArguments& args, bool is_fit) {
    Case the_case = load_case(args.case_file, is_fit ? Purpose::fit : Purpose::run);
    if (!args.out.empty()) the_case.output.dir = args.out;
    if (the_case.output.dir.empty()) the_case.output.dir = std::filesystem::path("runs") / the_case.name;
    check_run_folder(the_case.output.dir);
    if (!args.quiet) fmt::print(stderr, "strake: reading {}\n", the_case.surface.string());
    const BuiltProblem built = build_problem(the_case, is_fit ? Purpose::fit : Purpose::run);
    const Problem& problem = built.problem;

    Progress progress(args.quiet, box_diagonal(problem.surface), is_fit);
    for (const std::string& words : built.warnings) progress.warning(words);
    RunFolder folder(the_case.output.dir);
    folder.write_case(resolved_case(the_case, the_case.output.dir));
    std::vector<std::string> names;
    for (const Quantity& quantity : problem.quantities)
        names.insert(names.end(), quantity.names.begin(), quantity.names.end());
    folder.begin(problem, names, built.format, series_policy(the_case.output.paraview));

    RunEvents events;
    events.level = [&](const LevelStart& level) { progress.level(level), folder.add(level); };
    events.evaluation = [&](const EvaluationRecord& record) { progress.evaluation(record), folder.add(record); };
    events.accepted = [&](const AcceptedDesign& design) { folder.add(design); };
    events.level_end = [&](const LevelSummary& level) { progress.level_end(level); };
    events.note = [&](const std::string& words) { progress.note(words); };
    const RunResult result = is_fit ? fit(problem, events) : optimize(problem, events);
    folder.finish(result);
    if (args.json)
        print_json(result, folder);
    else
        report(problem, result, folder, is_fit);
    if (result.is_done()) return;
    fmt::print(stderr, "strake: {}: {}: {}\n", is_fit ? "fit" : "run", result.status, result.reason);
    throw ExitStatus{result.status == "evaluation_failed" ? external_failed : run_failed};
}

}  // namespace strake::cli
