#include "optimize/run/fit_verdict.hpp"

#include "core/error.hpp"
#include "optimize/run/run_verdict.hpp"

#include <cmath>
#include <cstdio>

namespace strake {
namespace {

/// After a level that explains less than this of what was left, finer ones are not expected to help.
constexpr double gains_little = 0.02;

std::string short_number(double value) {
    char buffer[32];
    std::snprintf(buffer, sizeof buffer, "%.3g", value);
    return buffer;
}

std::string percent_of(double share) { return short_number(100 * share) + " %"; }

std::string why(FitEnd end, const std::string& refused) {
    switch (end) {
        case FitEnd::recovered:
            return "the target is recovered to round-off";
        case FitEnd::converged:
            return "residual and variables change by less than the tolerances";
        case FitEnd::slackened:
            return "iterations remove too little of the residual";
        case FitEnd::budget:
            return "the limit of evaluations or time is reached";
        case FitEnd::no_valid_step:
            return text("next to the best design every shape is refused (", refused, ")");
        case FitEnd::roundoff:
            return "the solver found no better step";
        case FitEnd::failed:
        case FitEnd::no_design:
            break;
    }
    return refused;
}

std::string bounds_words(const RunResult& r) {
    const std::vector<std::string> own = own_bounds(r);
    int active = 0;
    for (int j = 0; j < r.space.size(); ++j)
        active += r.x[j] <= r.space.lower[j] + 1e-6 || r.x[j] >= r.space.upper[j] - 1e-6;
    if (active == 0) return motion_note(r);
    std::string advice =
        active > static_cast<int>(own.size()) ? "a larger parameters.max_displacement gives them room" : "";
    for (const std::string& words : own) advice += (advice.empty() ? "" : "; ") + words + " of its own";
    return text("; bounds active on ", active, " of ", r.space.size(), " variables: ", advice, motion_note(r));
}

/// The root mean square distance that each level reached; a level that did not converge could reach less.
std::string reached(const RunResult& r) {
    std::string words;
    for (const LevelSummary& level : r.levels) {
        if (!std::isfinite(level.objective_end) || level.variables == 0) continue;
        words += text(words.empty() ? "; rms distance by level: " : ", ", level.level, " reaches ",
                      short_number(std::sqrt(level.objective_end)), level.converged ? "" : " (not converged)");
    }
    return words;
}

/// Whether finer levels are expected to help, judged by the last one.
std::string forecast(const RunResult& r, FitEnd end) {
    if (end == FitEnd::recovered || end == FitEnd::budget || end == FitEnd::no_valid_step) return "";
    const LevelSummary& last = r.levels.back();
    if (!std::isfinite(last.explained)) return "";
    if (last.explained < gains_little)
        return text("; level ", last.level, " explains only ", percent_of(last.explained),
                    " of what was left: no progress is expected of finer levels; try other variables (strain, load), "
                    "fix less, and look where the residual is");
    return text("; level ", last.level, " still explains ", percent_of(last.explained),
                " of what was left: a finer level may go on");
}

}  // namespace

void describe_level(LevelSummary& level, double objective, FitEnd end, const std::string& refused) {
    level.converged = end == FitEnd::recovered || end == FitEnd::converged;
    level.stop = why(end, refused);
    if (!std::isfinite(level.objective_start) || !std::isfinite(objective)) return;
    const double before = std::sqrt(level.objective_start), after = std::sqrt(objective);
    level.explained = before > 0 ? 1 - after / before : 1;
    const std::string left = level.level > 1 ? text(" that level ", level.level - 1, " left") : std::string();
    level.stop = text("explains ", percent_of(level.explained), " of the difference", left, " (rms distance ",
                      short_number(before), " to ", short_number(after), "); ", level.stop);
}

void conclude_fit(RunResult& r, FitEnd end, const std::string& refused, int last_level, bool is_shape_refused) {
    if (end == FitEnd::failed) {
        r.status = "evaluation_failed";
        r.reason =
            text(refused, r.best_evaluation > 0 ? text("; the best design is that of evaluation ", r.best_evaluation)
                                                : std::string());
        return;
    }
    if (r.best_evaluation == 0) {
        r.status = "failed";
        r.reason = text(refused, is_shape_refused ? "; reduce the given loads and strains, or fix less"
                                                  : "; every quantity must have a finite value on the start surface");
        return;
    }
    const std::string found =
        r.objective_start > 0 ? text("the fit explains ", percent_of(1 - std::sqrt(r.objective / r.objective_start)),
                                     " of the difference; ")
                              : std::string();
    const std::string words = text(found, why(end, refused), " on level ", r.level);
    const std::string tail = text(bounds_words(r), reached(r), forecast(r, end));
    switch (end) {
        case FitEnd::recovered:
        case FitEnd::converged:
            // Convergence before the last level means that the budget did not last for the others.
            r.status = end == FitEnd::recovered || r.level == last_level ? "converged" : "budget";
            r.reason = r.status == "budget"
                           ? text(words, " of ", last_level, "; raise optimize.budget for the other levels", tail)
                           : words + tail;
            break;
        case FitEnd::budget:
            r.status = "budget";
            r.reason = text(words, " of ", last_level, "; raise optimize.budget to go on", tail);
            break;
        case FitEnd::no_valid_step:
            r.status = "no_valid_step";
            r.reason = text(words, "; allow a smaller parameters.max_displacement, or give a larger thickness", tail);
            break;
        case FitEnd::roundoff:
            r.status = "roundoff";
            r.reason = words + tail;
            break;
        default:
            r.status = r.level == last_level ? "progress" : "budget";
            r.reason = words + tail;
    }
}

}  // namespace strake
