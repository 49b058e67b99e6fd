#include "optimize/scaling.hpp"

#include "core/error.hpp"
#include "optimize/null_directions.hpp"

#include <numbers>

namespace strake {
namespace {

constexpr double negligible = 1e-9;  ///< of the largest response of the same kind: moves nothing

/// Physical value at x = 1. @param largest displacement at the value 1.
double unit_of(const RestFacts& rest, const Variable& variable, double largest) {
    double reach = rest.parameters.max_displacement;
    if (variable.patch < 0) {
        const GivenVariable& given = rest.parameters.given[variable.component];
        if (given.unit > 0) return given.unit;
        if (given.max_displacement > 0) reach = given.max_displacement;
    }
    return reach * rest.diagonal / largest;
}

/// Variables whose linear response follows from those before them are left out with a note: their directions would move
/// nothing, and have no natural size.
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
        space.left_out.push_back({space.variables[found.dependent[d]], found.share.col(static_cast<Eigen::Index>(d))});
    space.variables = std::move(kept);
    if (!space.left_out.empty()) space.notes.push_back(null_words(space));
    if (!space.weak.empty()) space.notes.push_back(weak_words(space, least));
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
            space.notes.push_back(text(variable.name, ": moves nothing, left out"));
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
    space.lower = Eigen::VectorXd::Constant(space.size(), -1);
    space.upper = Eigen::VectorXd::Constant(space.size(), 1);
}

}  // namespace strake
