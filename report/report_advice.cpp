#include "core/error.hpp"
#include "core/text/file.hpp"
#include "core/text/shell_word.hpp"
#include "report/report_parts.hpp"

#include <cmath>
#include <map>

/// What to try next, derived from the run folder.
namespace strake::page {
namespace {

constexpr double at_bound = 1e-3;    ///< fraction of a variable's range
constexpr double many = 0.2;         ///< fraction of evaluations
constexpr double negligible = 0.02;  ///< fraction of the run's gain

void about_bounds(const RunFiles& run, std::vector<std::string>& out) {
    const VariableTable best = read_variables(run.folder / "levels/best.csv");
    int count = 0;
    for (std::size_t j = 0; j < best.x.size(); ++j) {
        const double range = best.upper[j] - best.lower[j];
        count += best.x[j] - best.lower[j] < at_bound * range || best.upper[j] - best.x[j] < at_bound * range;
    }
    if (count > 0)
        out.push_back(text(count, " of ", best.x.size(), count == 1 ? " variables is" : " variables are",
                           " at a bound in the best design: if the shape may move further, raise "
                           "parameters.max_displacement (or the bounds under variables)."));
}

void about_failures(const RunFiles& run, std::vector<std::string>& out) {
    std::size_t failed = 0;
    std::map<std::string, int> kinds;
    for (const JournalEvaluation& e : run.journal->evaluations())
        if (e.status != "ok") ++failed, ++kinds[e.status];
    const std::size_t all = run.journal->evaluations().size();
    if (failed == 0) return;
    std::string words;
    for (const auto& [kind, count] : kinds) words += text(words.empty() ? "" : ", ", count, " ", kind);
    if (static_cast<double>(failed) > many * static_cast<double>(all))
        out.push_back(text(failed, " of ", all, " evaluations failed (", words,
                           "): read the logs below before paying for more."));
}

/// The name as given if it is below the current folder; otherwise the absolute path, which works from anywhere.
std::string typed_folder(const std::filesystem::path& named) {
    const std::filesystem::path short_name = (named / "").lexically_normal().parent_path();
    const bool is_below =
        named.is_relative() && !short_name.empty() && *short_name.begin() != "." && *short_name.begin() != "..";
    if (is_below) return typed_path(short_name.string());
    return typed_path((std::filesystem::absolute(named) / "").lexically_normal().parent_path().string());
}

void about_budget(const RunFiles& run, std::vector<std::string>& out) {
    const std::string& status = run.status.status;
    const std::string folder = typed_folder(run.folder);
    if (status == "budget")
        out.push_back(text("The budget ended the run, not the search: `strake resume ", folder, " --evaluations +",
                           std::max(10, run.status.max_evaluations / 2),
                           "` continues from here without repeating any evaluation."));
    if (status == "sampled")
        out.push_back(text("`optimize: {start_from: ", folder,
                           "}` in the case starts a search at the best of these designs; variables with small effects "
                           "may be fixed."));
    if (status == "interrupted" || status == "killed")
        out.push_back(text("`strake resume ", folder, "` continues; no finished evaluation is repeated."));
    if (status == "waiting") out.push_back("Answer the pending requests, then run `strake step` again.");
    if (status == "evaluation_failed")
        out.push_back(text("Fix the failure (see below), then `strake resume ", folder,
                           "`; with on_failure: shrink_step a run avoids such designs and continues."));
    if (status == "conflict" || status == "infeasible")
        out.push_back(
            "Relax one of the constraints named above, or give the shape more degrees of freedom: finer levels, a "
            "larger max_displacement, fewer fixed regions.");
    if (status == "gradient_inconsistent")
        out.push_back("`strake gradient-check` on the case shows which quantity's gradient disagrees.");
}

void about_levels(const RunFiles& run, bool has_converged, std::vector<std::string>& out) {
    double start = std::numeric_limits<double>::quiet_NaN(), end = start, last_level = start;
    int level = 0;
    for (const JournalEvaluation& e : run.journal->evaluations()) {
        if (!e.accepted) continue;
        if (!std::isfinite(start)) start = e.objective;
        if (e.level != level) last_level = std::isfinite(end) ? end : start;
        level = e.level;
        end = e.objective;
    }
    const double gained = std::abs(end - start), by_last = std::abs(end - last_level);
    if (!std::isfinite(gained) || level < 2 || gained <= 0) return;
    if (by_last < negligible * gained)
        out.push_back(text("The last level contributed ", std::round(1000 * by_last / gained) / 10,
                           " % of the gain: finer patches are unlikely to gain more; other variables, constraints or "
                           "a different start may."));
    else if (has_converged)
        out.push_back(text("The last level still contributed ", std::round(1000 * by_last / gained) / 10,
                           " % of the gain: another level may be worth its cost (parameters.patches_per_level, "
                           "starting with optimize.start_from: this folder)."));
}

}  // namespace

std::vector<std::string> advice(const RunFiles& run, const ReportSubject&) {
    std::vector<std::string> out;
    if (run.status.status == "running") return {"The run is still in progress; this page shows its present state."};
    about_budget(run, out);
    about_failures(run, out);
    about_bounds(run, out);
    about_levels(run, run.status.status == "converged", out);
    return out;
}

}  // namespace strake::page
