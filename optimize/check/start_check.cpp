#include "optimize/check/start_check.hpp"

#include "core/error.hpp"
#include "optimize/evaluate/constraints.hpp"
#include "optimize/evaluate/evaluation.hpp"
#include "optimize/nlp/program/methods.hpp"

#include <algorithm>
#include <chrono>

namespace strake {
namespace {

double seconds_since(std::chrono::steady_clock::time_point begin) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

void take_gradients(const QuantityResult& result, const QuantityRequest& request, StartAnswer::Quantity& seen) {
    for (std::size_t i = 0; i < seen.values.size(); ++i) {
        StartAnswer::Value& value = seen.values[i];
        value.is_gradient_needed = request.wants(i);
        value.has_gradient = i < result.dJ_dv.size() && result.dJ_dv[i].rows() > 0;
        if (!value.has_gradient) continue;
        value.gradient_norm = result.dJ_dv[i].norm();
        value.largest_gradient = result.dJ_dv[i].rowwise().norm().maxCoeff(&value.largest_vertex);
        for (std::size_t j = 0; i < result.dJ_dp.size() && j < request.parameters.size(); ++j)
            if (result.dJ_dp[i].size() > static_cast<int>(j))
                value.by_variable.emplace_back(request.parameters[j].first, result.dJ_dp[i][static_cast<int>(j)]);
    }
}

/// The same quantity, recording what it is asked and answers.
Quantity watched(const Quantity& quantity, StartAnswer::Quantity& seen) {
    Quantity copy = quantity;
    copy.cache.clear();  // it is the program that is tried
    seen.is_program = !quantity.program.empty();
    for (const std::string& name : quantity.names) seen.values.emplace_back().name = name;
    if (quantity.combination) return copy;
    copy.evaluate = [&seen, ask = quantity.evaluate](const QuantityRequest& request) {
        const auto begin = std::chrono::steady_clock::now();
        seen.was_asked_for_gradients = request.want_sensitivities;
        QuantityResult result = ask(request);
        seen.seconds = seconds_since(begin);
        seen.failure = result.failure;
        for (std::size_t i = 0; i < std::min(seen.values.size(), result.values.size()); ++i)
            seen.values[i].value = result.values[i];
        take_gradients(result, request, seen);
        return result;
    };
    if (quantity.differentiate)
        copy.differentiate = [&seen, ask = quantity.differentiate](const QuantityRequest& request) {
            const auto begin = std::chrono::steady_clock::now();
            seen.was_asked_for_gradients = true;
            QuantityResult result = ask(request);
            seen.gradient_seconds = seconds_since(begin);
            if (result.failure) seen.failure = result.failure;
            take_gradients(result, request, seen);
            return result;
        };
    return copy;
}

/// Values whose gradients a run would ask for.
std::vector<std::string> differentiated(const Problem& problem) {
    if (!method_facts(problem.optimize.method).needs_gradients) return {};
    std::vector<std::string> wanted{problem.objective}, names;
    for (const Constraint& c : problem.constraints) wanted.push_back(c.quantity);
    wanted.insert(wanted.end(), problem.fit.begin(), problem.fit.end());
    std::sort(wanted.begin(), wanted.end());
    wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
    for (const std::string& name : wanted)
        for (const Quantity& quantity : problem.quantities)
            if (quantity.has_sensitivities &&
                std::find(quantity.names.begin(), quantity.names.end(), name) != quantity.names.end())
                names.push_back(name);
    return names;
}

std::vector<StartAnswer::Row> rows_of(const Problem& problem, const ShapeEvaluator& evaluator,
                                      const std::vector<double>& values) {
    std::vector<int> index, none;
    for (const Constraint& c : problem.constraints) index.push_back(evaluator.index_of(c.quantity)), none.push_back(-1);
    const ConstraintRows made = constraint_rows(problem.constraints, index, none, values);
    std::vector<StartAnswer::Row> rows;
    for (std::size_t i = 0; i < made.rows.size(); ++i) {
        const ConstraintRow& row = made.rows[i];
        const double value = values[static_cast<std::size_t>(row.value)];
        rows.push_back({evaluator.names()[static_cast<std::size_t>(row.value)], value, row.limit, row.sign * row.scale,
                        row.of(value), static_cast<int>(i) >= made.num_inequalities});
    }
    return rows;
}

}  // namespace

StartAnswer check_start(const Problem& problem) {
    const auto rest = rest_facts(problem);
    return check_start(problem, rest, design_space(rest, 1));
}

StartAnswer check_start(const Problem& problem, std::shared_ptr<const RestFacts> rest, const DesignSpace& space) {
    StartAnswer answer;
    answer.quantities.resize(problem.quantities.size());
    Problem copy = problem;
    for (std::size_t i = 0; i < copy.quantities.size(); ++i)
        copy.quantities[i] = watched(problem.quantities[i], answer.quantities[i]);
    ShapeEvaluator evaluator(copy, std::move(rest), differentiated(problem));
    if (space.size() == 0)
        throw InvalidInput(text("no variable of level ", space.level, " moves anything; is all of it fixed?"));
    evaluator.enter(space);
    ShapeEvaluation at = evaluator.evaluate(Eigen::VectorXd::Zero(space.size()), 1);
    if (at.status == EvaluationStatus::ok && at.has_gradients_to_come) evaluator.differentiate(at);
    for (std::size_t i = 0; i < copy.quantities.size(); ++i)
        if (copy.quantities[i].combination && !at.values.empty())
            answer.quantities[i].values[0].value =
                at.values[static_cast<std::size_t>(evaluator.index_of(copy.quantities[i].names[0]))];
    answer.status = to_string(at.status);
    answer.reason = at.reason;
    answer.level = space.level;
    answer.variables = space.size();
    answer.remarks = at.remarks;
    if (at.status == EvaluationStatus::ok) answer.constraints = rows_of(problem, evaluator, at.values);
    return answer;
}

Problem without_programs(const Problem& problem) {
    Problem copy = problem;
    std::vector<std::string> known;
    for (const ProgramParameter& own : problem.program_parameters) known.push_back(own.name);
    const auto is_known = [&](const std::string& name) {
        return std::find(known.begin(), known.end(), name) != known.end();
    };
    copy.quantities.clear();
    for (const Quantity& quantity : problem.quantities) {
        const bool is_free = quantity.combination ? std::all_of(quantity.combination->of.begin(),
                                                                quantity.combination->of.end(), is_known)
                                                  : quantity.program.empty();
        if (!is_free) continue;
        copy.quantities.push_back(quantity);
        known.insert(known.end(), quantity.names.begin(), quantity.names.end());
    }
    std::erase_if(copy.constraints, [&](const Constraint& c) { return !is_known(c.quantity); });
    return copy;
}

}  // namespace strake
