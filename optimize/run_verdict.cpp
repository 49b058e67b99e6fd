#include "optimize/run_verdict.hpp"

#include "core/error.hpp"

namespace strake {
namespace {

/// "area <= 1.107, volume >= 2"
std::string names_of(const RunEnd& end, const RunResult& r, const std::vector<int>& rows) {
    std::string words;
    for (const int i : rows) {
        const ConstraintRow& row = end.rows.rows[i];
        const bool equality = i >= end.rows.num_inequalities;
        words += text(words.empty() ? "" : " and ", r.names[row.value],
                      equality       ? " = "
                      : row.sign > 0 ? " <= "
                                     : " >= ",
                      row.limit);
    }
    return words;
}

/// Own variables of the best design that lie at a bound, which no max_displacement moves: "alpha at its max".
std::vector<std::string> own_at_bounds(const RunResult& r) {
    std::vector<std::string> words;
    if (r.best_evaluation == 0) return words;
    for (int j = r.space.num_shape(); j < r.space.size(); ++j)
        if (r.x[j] <= r.space.lower[j] + 1e-6 || r.x[j] >= r.space.upper[j] - 1e-6)
            words.push_back(
                text(r.space.variables[j].name, " at its ", r.x[j] <= r.space.lower[j] + 1e-6 ? "min" : "max"));
    return words;
}

std::string bounds_note(const RunResult& r, const RunEnd& end) {
    if (end.level.active_bounds == 0 || r.levels.empty()) return "";
    // Of the last level, where the search ended: the best design may be one of a coarser level.
    const std::vector<std::string> own = own_at_bounds(r);
    std::string advice =
        end.level.active_bounds > static_cast<int>(own.size()) ? "a larger max_displacement would give them room" : "";
    for (const std::string& words : own) advice += (advice.empty() ? "" : "; ") + words;
    return text("; bounds active on ", end.level.active_bounds, " of ", r.levels.back().variables,
                " variables of level ", r.levels.back().level, " (", advice, ")");
}

std::string flat_note(const RunEnd& end) {
    return end.level.is_flat ? "; the objective did not change with any variable: is it what was meant, and does the "
                               "surface move where it looks?"
                             : "";
}

/// Of a search that got next to nowhere the budget is not what it lacks.
std::string failures_note(const RunEnd& end) {
    if (end.level.failures < 5 || 2 * end.level.failures <= end.level.evaluations) return "";
    return text("; ", end.level.failures, " of the ", end.level.evaluations,
                " evaluations of this level failed: look at why (history.csv, the report) before you raise anything");
}

/// The words may end with lines of a program's log.
std::string blocked_advice(const RunEnd& end, const std::string& words) {
    if (!end.last_failed_in_quantity)
        return "; the surface buckles or folds there: allow a smaller max_displacement, or give a larger thickness";
    return text(words.find('\n') == std::string::npos ? "; " : "\n",
                "the surface is sound there, a quantity has no value: its log says why; a constraint or a smaller "
                "max_displacement keeps away from there");
}

void infeasible(RunResult& r, const RunEnd& end, const std::string& words) {
    if (end.level.conflict.size() > 1) {
        r.status = "conflict";
        for (const int i : end.level.conflict) r.conflict.push_back(r.names[end.rows.rows[i].value]);
        r.reason = text("the constraints ", names_of(end, r, end.level.conflict),
                        " cannot be met together (the least violation is ", r.max_violation,
                        "); relax one of them or allow a larger max_displacement", bounds_note(r, end));
        return;
    }
    r.status = "infeasible";
    const bool by_budget = end.level.stop == MinimizeStop::evaluations || end.level.stop == MinimizeStop::time;
    const std::string unmet = end.level.conflict.empty() ? "the constraints" : names_of(end, r, end.level.conflict);
    r.reason = by_budget
                   ? text("none of the ", r.evaluations, " designs evaluated meets ", unmet,
                          ", the least violation is ", r.max_violation, " (", words,
                          "); raise optimize.budget, or relax what is asked", bounds_note(r, end))
                   : text("no design within the bounds meets ", unmet, ", the least violation is ", r.max_violation,
                          " (", words, "); relax it or allow a larger max_displacement", bounds_note(r, end));
}

void feasible(RunResult& r, const RunEnd& end, const std::string& words) {
    const bool at_the_end = end.refining_is_idle || !end.can_refine;
    const std::string notes =
        text(flat_note(end), end.refining_is_idle ? "; no progress is expected from further refinement" : "",
             bounds_note(r, end));
    switch (end.level.stop) {
        case MinimizeStop::converged:
            r.status = at_the_end ? "converged" : "budget";
            r.reason = at_the_end ? text("converged on level ", r.level, ": ", words, notes)
                                  : text("the budget ended on level ", r.level, ", which is not the finest",
                                         "; raise optimize.budget to go on", notes);
            break;
        case MinimizeStop::roundoff:
            r.status = "roundoff";
            r.reason = text("stopped on level ", r.level, ": ", words, notes);
            break;
        case MinimizeStop::blocked:
            r.status = "blocked";
            r.reason = text(words, blocked_advice(end, words));
            break;
        case MinimizeStop::failed:
            r.status = r.best_evaluation > 0 ? "blocked" : "failed";
            r.reason = r.best_evaluation > 0
                           ? text("level ", r.level, " cannot begin where the one before ended: ", words,
                                  "; retries get over what fails only now and then")
                           : words;
            break;
        default:
            r.status = "budget";
            r.reason = text(end.level.stop == MinimizeStop::evaluations
                                ? text("the limit of evaluations is reached (", r.evaluations, ")")
                                : words,
                            " on level ", r.level, end.can_refine ? ", which is not the finest" : "",
                            "; raise optimize.budget to go on", failures_note(end), notes);
    }
}

}  // namespace

std::string level_words(const MinimizeResult& level) {
    if (level.stop == MinimizeStop::stopped) return "progress slackened";
    return level.stop == MinimizeStop::outpaced ? "finer details promise more" : level.reason;
}

void conclude_interrupted(RunResult& r) {
    r.status = "interrupted";
    r.reason = text("stopped by the user after ", r.evaluations, " evaluations");
    std::string jobs;
    for (const std::string& job : r.going_on) jobs += (jobs.empty() ? "" : ", ") + job;
    if (!jobs.empty()) r.reason += text("; in the queue goes on: ", jobs);
}

void conclude_waiting(RunResult& r) {
    r.status = "waiting";
    r.reason = text(r.awaited.size(), r.awaited.size() == 1 ? " answer is" : " answers are", " awaited after ",
                    r.evaluations, " evaluations");
}

void conclude_run(RunResult& r, const RunEnd& end) {
    const std::string words = level_words(end.level);
    if (end.quantity_failed) {
        r.status = "evaluation_failed";
        r.reason = text("evaluation ", r.evaluations, ": ", end.level.reason);
    } else if (r.best_evaluation == 0) {
        r.status = "failed";
        r.reason = text(words, "; reduce the given loads and strains, or fix less");
    } else if (end.level.gradient_inconsistent) {
        const int of = end.level.slope_of;
        r.status = "gradient_inconsistent";
        r.reason = text("the values do not follow the gradient of ",
                        of < 0 ? std::string("the objective") : r.names[end.rows.rows[of].value], ": they change by ",
                        end.level.slope_ratio, " of what it says (", words,
                        "); check it with `strake gradient-check`, or use a method without gradients (cobyla)");
    } else if (!end.is_feasible) {
        infeasible(r, end, words);
    } else {
        feasible(r, end, words);
    }
}

}  // namespace strake
