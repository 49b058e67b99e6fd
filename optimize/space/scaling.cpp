#include "optimize/space/scaling.hpp"

#include "core/error.hpp"
#include "core/planform/planform_motion.hpp"
#include "optimize/space/motion_limit.hpp"
#include "optimize/space/null_directions.hpp"
#include "optimize/space/response_metric.hpp"

#include <Eigen/Cholesky>
#include <numbers>

namespace strake {
namespace {

constexpr double negligible = 1e-9;  ///< of the largest response of the same kind: moves nothing
/// Motion limits that a variable may ask for by itself; the limit itself is kept by shapes, not by these bounds. More
/// (others may hold back what it moves) leads searches into the many optima next to buckling, where units decide.
constexpr double room_within_limit = 1;
constexpr double room_without_limit = 1e3;  ///< units: more than any shape can do

/// Physical value at x = 1. @param largest displacement at the value 1.
double unit_of(const RestFacts& rest, const Variable& variable, double largest) {
    double reach = variable_scale(rest.parameters);
    if (variable.patch < 0) {
        const UserVariable& given = rest.parameters.user_variables[variable.component];
        if (given.unit > 0) return given.unit;
        if (given.max_displacement > 0) reach = given.max_displacement;
        // Of a field it is 1, of which wings that keep their sections may leave little.
        if (variable.kind == VariableKind::field && rest.parameters.kept_sections &&
            !rest.parameters.counts_kept_motion_alone)
            largest = std::max(largest, held_share);
    }
    return reach * rest.diagonal / largest;
}

/// A user variable's own limit bounds it, and so does the limit where it is one of variables; a factor on the height
/// has no natural size.
bool has_range_of_its_own(const Parameters& p, const Variable& variable) {
    return p.limits_variables || variable.kind == VariableKind::stiffness ||
           (variable.patch < 0 && has_own_limit(p.user_variables[variable.component]));
}

/// The bounds of a variable are -room and room.
double room_of(const Parameters& p, const Variable& variable) {
    if (has_range_of_its_own(p, variable)) return 1;
    const double limit = largest_limit(p);
    return std::isfinite(limit) ? room_within_limit * limit / variable_scale(p) : room_without_limit;
}

/// Own limits of user variables that the motion limit does not let them reach.
void note_out_of_reach(DesignSpace& space, const Responses& responses) {
    const double limit = largest_limit(space.rest->parameters);
    if (!limits_motion(space.rest->parameters)) return;
    for (int j = 0; j < space.size(); ++j) {
        const Variable& variable = space.variables[j];
        if (variable.kind == VariableKind::planform) continue;
        if (variable.patch >= 0 || !has_own_limit(space.rest->parameters.user_variables[variable.component])) continue;
        const double moves = responses.largest[j] / space.rest->diagonal;
        if (moves > 1.001 * limit)
            space.notes.push_back(text(variable.name, ": at its own limit it moves the surface by ",
                                       std::round(1e4 * moves) / 100, " % of the diagonal, but the motion limit is ",
                                       std::round(1e4 * limit) / 100,
                                       " %: raise parameters.max_displacement, or lower the variable's own limit"));
    }
}

/// Changes of wings have their own, whatever the motion limit.
void set_own_ranges(DesignSpace& space) {
    const Parameters& p = space.rest->parameters;
    for (int j = 0; j < space.size(); ++j) {
        const Variable& variable = space.variables[j];
        if (variable.kind != VariableKind::planform) continue;
        const int number = p.user_variables[variable.component].planform;
        const PlanformMotion::Variable& range = p.planform->variables()[static_cast<std::size_t>(number)];
        space.lower[j] = range.lower / variable.unit;
        space.upper[j] = range.upper / variable.unit;
    }
}

/// Dependent variables, whose linear response follows from those before them, are dropped with a note: their directions
/// move nothing, and have no natural size.
void leave_out_dependent(DesignSpace& space) {
    const Dependence found = dependence(responses_at_rest(space).samples);
    double least = 1;
    for (std::size_t k = 0; k < found.kept.size(); ++k)
        if (found.own[k] < weak_share) {
            space.weak.push_back(space.variables[found.kept[k]].name);
            least = std::min(least, found.own[k]);
        }
    std::vector<Variable> kept;
    for (const int j : found.kept) kept.push_back(space.variables[j]);
    for (std::size_t d = 0; d < found.dependent.size(); ++d)
        space.dependent.push_back({space.variables[found.dependent[d]], found.share.col(static_cast<Eigen::Index>(d))});
    space.variables = std::move(kept);
    if (!space.dependent.empty()) space.notes.push_back(null_words(space));
    if (!space.weak.empty()) space.notes.push_back(weak_words(space, least));
}

/// Variables whose ranges come from the motion limit.
std::vector<int> follow_limit(const DesignSpace& space) {
    std::vector<int> follow;
    for (int j = 0; j < space.num_shape(); ++j) {
        const Variable& variable = space.variables[static_cast<std::size_t>(j)];
        if (variable.kind != VariableKind::planform && !has_range_of_its_own(space.rest->parameters, variable))
            follow.push_back(j);
    }
    return follow;
}

}  // namespace

void scale_variables(DesignSpace& space) {
    const RestFacts& rest = *space.rest;
    const Responses unscaled = responses_at_rest(space);
    double largest_load = 0;
    for (int j = 0; j < space.size(); ++j)
        if (is_load(space.variables[j].kind)) largest_load = std::max(largest_load, unscaled.largest[j]);
    std::vector<Variable> kept;
    for (int j = 0; j < space.size(); ++j) {
        Variable variable = space.variables[j];
        const double least = is_load(variable.kind) ? negligible * largest_load : 0;
        if (variable.kind == VariableKind::stiffness) {
            variable.unit = std::numbers::ln2;
        } else if (!(unscaled.largest[j] > least)) {
            space.notes.push_back(text(variable.name, ": moves nothing, no variable"));
            continue;
        } else {
            variable.unit = unit_of(rest, variable, unscaled.largest[j]);
        }
        kept.push_back(variable);
    }
    space.variables = std::move(kept);
    leave_out_dependent(space);
    const Responses responses = responses_at_rest(space);
    space.metric = response_metric(space, responses);
    space.soft_work = soft_work(space, responses);
    space.upper.resize(space.size());
    for (int j = 0; j < space.size(); ++j) space.upper[j] = room_of(rest.parameters, space.variables[j]);
    space.lower = -space.upper;
    set_own_ranges(space);
    note_out_of_reach(space, responses);
}

double widen_to_limit(DesignSpace& space) {
    const Parameters& p = space.rest->parameters;
    const double limit = largest_limit(p) * space.rest->diagonal;
    const std::vector<int> follow = follow_limit(space);
    if (follow.empty() || !limits_motion(p) || !std::isfinite(limit)) return 1;
    const Eigen::MatrixXd moves = responses_at_rest(space).samples(Eigen::all, follow);
    const Eigen::LLT<Eigen::MatrixXd> mean_square(moves.transpose() * moves);
    if (mean_square.info() != Eigen::Success) return 1;
    const auto size = static_cast<Eigen::Index>(follow.size());
    const Eigen::MatrixXd inverse = mean_square.solve(Eigen::MatrixXd::Identity(size, size));
    double most = 1;
    for (Eigen::Index i = 0; i < size; ++i) {
        const int j = follow[static_cast<std::size_t>(i)];
        const double extent = std::min(limit * std::sqrt(inverse(i, i)), room_without_limit);
        if (!(extent > space.upper[j])) continue;  // an inherited value may have widened it
        most = std::max(most, extent / space.upper[j]);
        space.upper[j] = extent;
        space.lower[j] = std::min(space.lower[j], -extent);
    }
    return most;
}

bool widen_ranges(DesignSpace& space, const Eigen::VectorXd& x, double times) {
    const std::vector<int> follow = follow_limit(space);
    bool is_any_at_end = false;
    for (const int j : follow) {
        const double near = 1e-6 * (space.upper[j] - space.lower[j]);
        is_any_at_end |= x[j] <= space.lower[j] + near || x[j] >= space.upper[j] - near;
    }
    if (!is_any_at_end) return false;
    for (const int j : follow) {
        space.lower[j] *= times;
        space.upper[j] *= times;
    }
    return true;
}

}  // namespace strake
