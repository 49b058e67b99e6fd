#include "core/error.hpp"
#include "core/mesh/file.hpp"
#include "core/shell_word.hpp"
#include "report/report_parts.hpp"

#include <cmath>
#include <map>

/// What to try next, from what stands in the folder.
namespace strake::page {
namespace {

constexpr double at_bound = 1e-3;         ///< of the range of a variable
constexpr double many = 0.2;              ///< share of evaluations
constexpr double hardly_anything = 0.02;  ///< of what the run gained

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
                           "): read the logs below before you pay for more."));
}

/// As it was named, where that is below the folder of the one who asked; else in full, which is right from anywhere.
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
                           "` goes on from here and pays nothing twice."));
    if (status == "interrupted" || status == "killed")
        out.push_back(text("`strake resume ", folder, "` goes on; no finished evaluation is repeated."));
    if (status == "waiting") out.push_back("Answer the requests that wait, then `strake step` again.");
    if (status == "evaluation_failed")
        out.push_back(text("Mend what failed (below), then `strake resume ", folder,
                           "`; on_failure: shrink_step would let a run go on around such designs."));
    if (status == "conflict" || status == "infeasible")
        out.push_back(
            "Loosen one of the constraints named above, or give the shape more freedom: finer levels, a "
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
    if (by_last < hardly_anything * gained)
        out.push_back(text("The last level brought ", std::round(1000 * by_last / gained) / 10,
                           " % of the gain: finer patches promise little more; other variables, constraints or a "
                           "different start may."));
    else if (has_converged)
        out.push_back(text("The last level still brought ", std::round(1000 * by_last / gained) / 10,
                           " % of the gain: another level may be worth its price (parameters.patches_per_level, "
                           "starting with optimize.start_from: this folder)."));
}

}  // namespace

std::vector<std::string> advice(const RunFiles& run, const ReportSubject&) {
    std::vector<std::string> out;
    if (run.status.status == "running") return {"The run is still going on; this page shows it as it is now."};
    about_budget(run, out);
    about_failures(run, out);
    about_bounds(run, out);
    about_levels(run, run.status.status == "converged", out);
    return out;
}

}  // namespace strake::page
