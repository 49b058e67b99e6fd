#include "optimize/run/run_verdict.hpp"

#include "core/error.hpp"
#include "core/wrap/wrap_map.hpp"

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

/// What keeps the design: bounds of variables and the motion limit.
std::string bounds_note(const RunResult& r, const RunEnd& end) {
    if (end.level.active_bounds == 0 || r.levels.empty()) return motion_note(r);
    // Of the last level, where the search ended: the best design may be one of a coarser level.
    const std::vector<std::string> parameters = own_bounds(r);
    const bool is_by_shapes = r.motion.is_limited && !r.motion.is_active;
    std::string advice;
    if (end.level.active_bounds > static_cast<int>(parameters.size()))
        advice = is_by_shapes ? "the variables' own range ends there before any point is at the motion limit; a larger "
                                "max_displacement would give them room"
                              : "a larger max_displacement would give them room";
    for (const std::string& words : parameters) advice += (advice.empty() ? "" : "; ") + words;
    return text("; bounds active on ", end.level.active_bounds, " of ", r.levels.back().variables,
                " variables of level ", r.levels.back().level, " (", advice, ")", motion_note(r));
}

std::string flat_note(const RunEnd& end) {
    return end.level.is_flat ? "; the objective did not change with any variable: is it the intended one, and does the "
                               "surface move where it looks?"
                             : "";
}

/// Of a search that got next to nowhere the budget is not what it lacks.
std::string failures_note(const RunEnd& end) {
    if (end.level.failures < 5 || 2 * end.level.failures <= end.level.evaluations) return "";
    return text("; ", end.level.failures, " of the ", end.level.evaluations,
                " evaluations of this level failed: look at why (history.csv, the report) before you raise anything");
}

/// Fewer than the limit: the rest is too few for another step and the way back onto the constraints, or the share of
/// other starts.
std::string limit_words(const RunResult& r, const RunEnd& end) {
    if (r.evaluations >= end.max_evaluations) return text("the limit of evaluations is reached (", r.evaluations, ")");
    const bool is_kept = !end.rows.rows.empty() && end.level.reason.find(" starts, number ") == std::string::npos;
    return text("the limit of evaluations is reached (", r.evaluations, " of ", end.max_evaluations,
                is_kept ? "; the rest is kept for the way back onto the constraints)" : ")");
}

/// The words may end with lines of a program's log.
std::string no_valid_step_advice(const RunEnd& end, const std::string& words) {
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
                          "); raise optimize.budget, or relax the constraints", bounds_note(r, end))
                   : text("no design within the bounds meets ", unmet, ", the least violation is ", r.max_violation,
                          end.level.conflict.empty() ? text(" (", words, ")") : "",  // else it says the same
                          "; relax it or allow a larger max_displacement", bounds_note(r, end));
}

void gradient_inconsistent(RunResult& r, const RunEnd& end, const std::string& words) {
    const MinimizeResult& l = end.level;
    // Rows are scaled and turned to be <= 0, and what is maximized is minimized: the values are told as they are.
    const ConstraintRow* row = l.slope_of < 0 ? nullptr : &end.rows.rows[static_cast<std::size_t>(l.slope_of)];
    const double unit = row ? row->scale / row->sign : end.is_maximized ? -1 : 1;
    r.status = "gradient_inconsistent";
    r.reason = text("the values do not follow the gradient of ",
                    row ? r.names[static_cast<std::size_t>(row->value)] : text(end.objective, ", the objective"),
                    ": at the best design of level ", r.levels.empty() ? 0 : r.levels.back().level, " (evaluation ",
                    end.level_best, "), ", l.slope_where, ", it changes by ", unit * l.slope_found,
                    " where its gradient says ", unit * l.slope_expected, " (",
                    words.substr(0, words.find("; the gradient is inconsistent")),
                    "); check it with `strake gradient-check CASE`, or use a method without gradients (cobyla)");
}

void feasible(RunResult& r, const RunEnd& end, const std::string& words) {
    const bool at_the_end = end.refining_is_idle || !end.can_refine;
    const std::string notes =
        text(flat_note(end), end.refining_is_idle ? "; no progress is expected from further refinement" : "",
             bounds_note(r, end));
    switch (end.level.stop) {
        case MinimizeStop::converged:
            r.status = at_the_end ? "converged" : "budget";
            r.reason = at_the_end
                           ? text("converged",
                                  r.motion.is_active ? " at the motion limit that is set, on level " : " on level ",
                                  r.level, ": ", words, notes)
                           : text("the budget ended on level ", r.level, ", which is not the finest",
                                  "; raise optimize.budget to go on", notes);
            break;
        case MinimizeStop::roundoff:
            r.status = "roundoff";
            r.reason =
                text("stopped on level ", r.level, ": ", words, notes,
                     words.find("gradient predicts") == std::string::npos ? ""
                     : end.level.gradient_confirmed
                         ? "; the values followed the gradient before, that way too: their noise or kinks hide what is "
                           "left (`strake gradient-check CASE` shows them)"
                         : "; noise of the values or a wrong gradient: `strake gradient-check CASE` tells which");
            break;
        case MinimizeStop::no_valid_step:
            r.status = "no_valid_step";
            r.reason = text(words, no_valid_step_advice(end, words));
            break;
        case MinimizeStop::failed:
            r.status = r.best_evaluation > 0 ? "no_valid_step" : "failed";
            r.reason = r.best_evaluation > 0
                           ? text("level ", r.level, " cannot begin where the one before ended: ", words,
                                  "; retries get over what fails only now and then")
                           : words;
            break;
        default:
            r.status = "budget";
            r.reason = text(end.level.stop == MinimizeStop::evaluations ? limit_words(r, end) : words, " on level ",
                            r.level, end.can_refine ? ", which is not the finest" : "",
                            "; raise optimize.budget to go on", failures_note(end), notes);
    }
}

}  // namespace

std::vector<std::string> own_bounds(const RunResult& r) {
    std::vector<std::string> words;
    if (r.best_evaluation == 0) return words;
    const Parameters& p = r.space.rest->parameters;
    for (int j = 0; j < r.space.size(); ++j) {
        const Variable& variable = r.space.variables[j];
        const bool has_own = variable.kind == VariableKind::parameter ||
                             (variable.patch < 0 && has_own_limit(p.user_variables[variable.component]));
        if (!has_own) continue;
        if (r.x[j] <= r.space.lower[j] + 1e-6 || r.x[j] >= r.space.upper[j] - 1e-6)
            words.push_back(text(variable.name, " at its ", r.x[j] <= r.space.lower[j] + 1e-6 ? "min" : "max"));
    }
    return words;
}

std::string patch_at(const DesignSpace& space, int vertex) {
    const Triangles& triangles = space.rest->surface.triangles;
    for (Eigen::Index t = 0; t < triangles.rows(); ++t)
        if ((triangles.row(t).array() == vertex).any()) {
            const int elastic =
                space.rest->wrap ? space.rest->wrap->wrap_triangle()[static_cast<std::size_t>(t)] : static_cast<int>(t);
            const int patch = space.patches().label[static_cast<std::size_t>(elastic)];
            return space.patches().patches[static_cast<std::size_t>(patch)].name;
        }
    return "";
}

MotionAtEnd motion_of(const RunResult& r, const MotionLimit& limit, double slack) {
    constexpr double nearly = 1e-3;  // a search comes closer where it can
    MotionAtEnd end;
    end.is_limited = !limit.is_none();
    if (!end.is_limited || r.best_evaluation == 0) return end;
    const double share = 1 - std::max(nearly, slack);
    const MotionLimit::Use use = limit.max_use(beside_planform(*r.space.rest, demand(r.space, r.x), r.vertices), share);
    if (use.vertex < 0) return end;
    end.is_active = use.share >= share;
    end.used = use.share;
    end.vertex = use.vertex;
    end.num_vertices = use.num_there;
    end.limit = use.limit / limit.diagonal();
    end.where = patch_at(r.space, use.vertex);
    return end;
}

std::string motion_note(const RunResult& r) {
    const MotionAtEnd& m = r.motion;
    if (!m.is_active) return "";
    const auto rounded = [](double percent) {
        const double digit = std::pow(10, 1 - std::floor(std::log10(std::max(percent, 1e-12))));
        return std::round(percent * digit) / digit;
    };
    std::string words =
        text("; the motion limit (", rounded(100 * m.limit), " % of the diagonal) is active on ", m.where,
             ", at vertex ", m.vertex, m.num_vertices > 1 ? text(" and ", m.num_vertices - 1, " more") : "");
    const double share = 100 * std::abs(m.gain / r.objective);
    if (std::isfinite(share) && share > 0)
        words += text("; 0.1 % of the diagonal more motion would gain about ", rounded(share), " %");
    return words;
}

std::string level_words(const MinimizeResult& level) {
    if (level.stop == MinimizeStop::stopped) return "progress slackened";
    return level.stop == MinimizeStop::outpaced ? "finer details are expected to gain more" : level.reason;
}

void conclude_interrupted(RunResult& r) {
    r.status = "interrupted";
    r.reason = text("stopped by the user after ", r.evaluations, " evaluations");
    std::string jobs;
    for (const std::string& job : r.pending) jobs += (jobs.empty() ? "" : ", ") + job;
    if (!jobs.empty()) r.reason += text("; still in the queue: ", jobs);
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
        r.reason =
            text(words, end.last_failed_in_quantity ? "; every quantity must have a finite value on the start surface"
                                                    : "; reduce the given loads and strains, or fix less");
    } else if (end.level.gradient_inconsistent) {
        gradient_inconsistent(r, end, words);
    } else if (!end.is_feasible) {
        infeasible(r, end, words);
    } else {
        feasible(r, end, words);
    }
}

}  // namespace strake
